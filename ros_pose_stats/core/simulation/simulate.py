# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""A whole simulation: from a part and a request to the statistics of its drops."""

import math
import time
from collections.abc import Callable, Iterable

from numpy.typing import ArrayLike

from ...base.errors import RequestError
from ...base.methods import SIMULATION
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..records.notes import Note, note
from ..records.part import Array, Index
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ..records.shares import pose_statistics
from ..resting import poses, trust
from ..statistics.errors import Judgement
from ..statistics.prefix import Judge, Prefix, counted_shares, target_reached
from .chunks import DropWorkers
from .drop_body import drop_body
from .drops import (
    DropChunk,
    DropOutcomes,
    compute_drops,
    draw_poses,
    drop_rules,
    release_directions,
)
from .request import (
    FEWEST_DROPS,
    DropRequest,
    OnProgress,
    Watch,
    drop_request,
)


def simulate(
    part: Part,
    drops: int | None = None,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int | None = None,
    drop_height: float | None = None,
    target_error: float = 0.0,
    workers: int | None = None,
    starts: ArrayLike | None = None,
    on_progress: OnProgress = None,
    should_stop: Callable[[], bool] | None = None,
    *,
    on_drops: Callable[[DropChunk], object] | None = None,
    background: bool = False,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
    judge: Judge | None = None,
) -> PoseStatistics:
    """Drop a part many times and count the poses in which it comes to rest (section 3).

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    drops : int, optional
        How many, 1 to 1e9; the most where a target error is given. Default: 10 000, or
        all starts.
    restitution : float
        Coefficient of restitution, 0 <= restitution < 1.
    seed : int, optional
        0 to 2^64 - 1; drop k depends on seed and k alone. Default: a fresh one, in the
        answer.
    drop_height : float, optional
        Height of the centre of mass at release, metres; too low to fit means released
        touching the plate. Default: 20 part radii.
    target_error : float
        Stop once the root mean square error over the poses is within this fraction with
        90 % confidence, which is checked after 100, 150, 225, ... drops. 0 asks for all
        drops.
    workers : int, optional
        Threads; default: all cores.
    starts : (k, 3) array, optional
        Directions in the part frame that point down at release, one a drop.
    on_progress, on_drops : callable, optional
        Called in the caller's thread: the first with a `DropProgress`, some twenty
        times a second, the second with a `DropChunk` for all drops that count, in their
        order.
    should_stop : callable, optional
        Once it returns True the simulation ends, within about 50 ms, with the drops
        done by then.
    background : bool
        Whether workers give way to other threads of this machine (Linux: niceness 10
        above the caller's).
    cluster_tolerance : float
        Least rise out of a pose as a share of its height there; 0 merges nothing.
    round_sides : int
        Sides a turn of the polygons that round surfaces are taken as; 0 takes the file
        as it is.
    judge : Judge, optional
        Judges in place of the counts, and says how many drops come before the first
        check.

    Returns
    -------
    PoseStatistics
        All poses, most probable first; the same whatever the workers and the timing.
        Where none of fewer than 50 drops comes to rest, probabilities and errors are
        NaN.

    Raises
    ------
    RequestError, MeshError
        If a value is out of range, the part's hull does not enclose its centre of mass,
        or none of the first 50 drops comes to rest, as on a plate that takes next to no
        energy.
    """
    return count_drops(
        part,
        DropScene(restitution, drop_height, cluster_tolerance, round_sides),
        drop_request(drops, seed, target_error, workers, starts),
        Watch.from_callbacks(on_progress, should_stop, on_drops, background),
        judge,
    )


def count_drops(
    part: Part,
    scene: DropScene,
    request: DropRequest,
    watch: Watch,
    judge: Judge | None,
) -> PoseStatistics:
    """Drop a part in a scene as requested; `judge` and the rest as for `simulate`."""
    if request.target_error:
        part.require_known_error("a target error")
    return _Simulation(part, scene, request, judge).run(watch)


class _Simulation:
    """One simulation: its request, and the counts of the drops so far."""

    def __init__(
        self, part: Part, scene: DropScene, request: DropRequest, judge: Judge | None
    ) -> None:
        self._begin = time.perf_counter()
        self._part = part
        self._scene = scene
        self._request = request
        self._body = drop_body(part, scene)
        self._rules = drop_rules(scene, self._body.radius, draws=request.starts is None)
        first = min(FEWEST_DROPS, request.drops) if request.events else request.drops
        self._prefix = Prefix(
            len(self._body.resting.poses), first, request.target_error, judge
        )
        self._touching_drops = self._events = self._settled_early = 0

    def run(self, watch: Watch) -> PoseStatistics:
        """Count drops until there are enough of them or the caller stops."""
        prefix = self._prefix
        request = self._request

        def stop() -> bool:
            return prefix.finished or bool(watch.should_stop())

        workers = DropWorkers(
            self._drop,
            request.drops,
            request.workers,
            stop,
            watch.background,
            prefix.requested_drops,
        )
        for outcomes in workers.outcomes_in_order():
            counted_drops = self._count(outcomes, watch)
            if prefix.drops >= FEWEST_DROPS and not self._settled_early:
                workers.stop()
                raise RequestError(
                    "drops that come to rest",
                    f"none of the first {FEWEST_DROPS}, each of which was "
                    f"given up, {self._statistics().scene}",
                    "lower the restitution or the drop height",
                )
            if request.events and prefix.drops == FEWEST_DROPS:
                affordable = FEWEST_DROPS * request.events // max(self._events, 1)
                prefix.extend(min(request.drops, affordable))
            if prefix.finished:
                workers.stop()
            workers.request_drops(prefix.requested_drops)
            if watch.on_progress is not None and counted_drops:
                watch.on_progress(self._progress())
        return self._statistics()

    def _count(self, outcomes: DropOutcomes, watch: Watch) -> int:
        """Count the drops that are still wanted, and return how many they are."""
        first = self._prefix.drops
        count = self._prefix.add(outcomes.pose)
        if watch.on_drops is not None and count:
            downs = self._downs(first, count)
            watch.on_drops(DropChunk(first, downs, outcomes.first(count)))
        self._touching_drops += int(outcomes.touched[:count].sum())
        self._events += int(outcomes.events[:count].sum())
        early = max(0, min(count, FEWEST_DROPS - first))
        self._settled_early += int((outcomes.pose[:early] >= 0).sum())
        return count

    def _progress(self) -> DropProgress:
        prefix = self._prefix
        judgement = prefix.recent_judgement()
        if not self._part.error_known:
            judgement = Judgement(math.nan, math.nan)
        return DropProgress(
            prefix.drops,
            prefix.drop_bound,
            prefix.drops - prefix.settled_drops,
            judgement.expected_error,
            judgement.bound,
            self._request.target_error,
            time.perf_counter() - self._begin,
            self._statistics,
        )

    def _drop(self, first: int, count: int) -> DropOutcomes:
        outcomes = compute_drops(self._body, self._rules, self._downs(first, count))
        return draw_poses(self._body, outcomes, self._request.seed, first)

    def _downs(self, first: int, count: int) -> Array:
        request = self._request
        if request.starts is not None:
            return request.starts[first : first + count]
        return release_directions(self._body, request.seed, first, count)

    def _statistics(self) -> PoseStatistics:
        """Statistics of the drops counted so far."""
        prefix = self._prefix
        target = prefix.target_error
        target_warnings = []
        if prefix.finished and target > 0.0:
            bound = prefix.judgement().bound
            if not target_reached(bound, target):
                target_warnings.append(
                    note(
                        "TARGET_MISSED",
                        f"the 90 % bound of the error is {bound:.2g} after all "
                        f"{prefix.drops} drops, above the target of {target:g}.",
                    )
                )
        return counted_statistics(
            self._part,
            self._body.resting,
            self._scene,
            prefix.counts,
            prefix.drops,
            self._touching_drops,
            self._request.seed,
            time.perf_counter() - self._begin,
            target_warnings,
        )


def counted_statistics(
    part: Part,
    resting: poses.RestingPoses,
    scene: DropScene,
    counts: Index,
    drops: int,
    touched: int,
    seed: int,
    seconds: float,
    warnings: Iterable[Note] = (),
    uncertain: str = "their pose",
) -> PoseStatistics:
    """Statistics of drops by the poses in which they ended, `counts` (P,).

    `touched`: drops that were released touching the plate; `uncertain`: what was not
    certain of those that are left out.
    """
    unsettled = drops - int(counts.sum())
    all_warnings = [*trust.pose_notes(resting), *warnings]
    if touched:
        all_warnings.append(
            note(
                "RELEASED_TOUCHING",
                f"in {touched} of {drops} drops the part did not fit under a drop "
                f"height of {scene.drop_height:g} m and was released touching the "
                "plate.",
            )
        )
    if unsettled:
        all_warnings.append(
            note(
                "UNSETTLED",
                f"{unsettled} of {drops} drops were given up before {uncertain} was "
                "certain; they are left out of the probabilities.",
            )
        )
    return pose_statistics(
        part,
        resting.body.radius,
        resting.poses,
        counted_shares(counts),
        SIMULATION,
        scene,
        drops=drops,
        unsettled=unsettled,
        seed=seed,
        seconds=seconds,
        warnings=all_warnings,
    )
