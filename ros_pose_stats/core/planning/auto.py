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

"""The default answer: the best estimate with drops beside it, by one rule."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from ...base import errors, methods
from ..estimators.estimate import estimate_in
from ..records import DropScene, Part, PoseStatistics
from ..records.notes import note
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    DEFAULT_SEED,
    real_number,
)
from ..resting.poses import poses_in
from ..simulation.request import DropRequest, OnProgress, Watch, drop_request
from ..statistics.prefix import target_reached
from . import confidence
from .hybrid import drop_with_prior

DEFAULT_TARGET = 0.02
"""Root mean square error, over the poses and over the shares of groups, that the
answer keeps with 90 % confidence where no target is asked for."""

LEAST_DROPS = 400
"""Drops before an estimate is believed: beside them one that is wrong hardly adds to
their own error, and its bounds are kept; docs/measured/benchmarks.md, "The power of
drops"."""

MOST_EVENTS = 1_000_000
"""Impacts and steps that all drops may take where no target is asked for: about half a
second of one core. The first 50 are made whatever they cost."""

MOST_DROPS = 10_000_000  # drops that a target may cost where the caller sets no bound

MOST_RESTITUTION = 0.99
MOST_RADII = 100.0
"""Scenes up to which parts are dropped: a drop that hardly ends takes seconds."""


def auto(
    part: Part,
    target_error: float = 0.0,
    drops: int | None = None,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int | None = None,
    drop_height: float | None = None,
    max_seconds: float = 0.0,
    workers: int | None = None,
    on_progress: OnProgress = None,
    should_stop: Callable[[], bool] | None = None,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> PoseStatistics:
    """Pose statistics that keep a target error, or the default one.

    The answer is the best estimate with drops beside it: 400 at least, so that one that
    is wrong hardly matters, then until the target is kept. How far to believe the
    estimate is judged by how well it agrees with the drops; where they refute it, they
    go on alone. Without a target it is two points, within a budget of impacts and steps
    that is the same on every machine; where that ends the drops sooner, the answer has
    the warning `TARGET_MISSED`.

    The target is kept if the root mean square error, over the poses and over the shares
    of groups, against what infinitely many drops would give, is at most the target with
    a probability of 90 %.

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    target_error : float
        A fraction, 0 to below 1; 0 asks for 0.02 within the budget.
    drops : int, optional
        The most, 1 to 1e9. Default: 10 million.
    seed : int, optional
        As for `hybrid`; the default is 1, for every part.
    max_seconds : float
        Ends the drops, with a warning; the answer then depends on the speed of the
        machine. 0 for no limit.
    restitution, drop_height, workers, on_progress, should_stop, cluster_tolerance,
    round_sides
        As for `simulate`.

    Returns
    -------
    PoseStatistics
        `method` is the one that was used, `choice` says why.

    Raises
    ------
    RequestError
        If a value is out of its range.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    request = drop_request(
        MOST_DROPS if drops is None else drops,
        DEFAULT_SEED if seed is None else seed,
        target_error,
        workers,
    )
    limit = _TimeLimit(max_seconds, begin, should_stop)
    answer = answer_with_drops(
        estimate_in(part, scene, methods.AUTO),
        part,
        scene,
        request,
        Watch(on_progress, limit.is_over),
    )
    answer = limit.warn_of_lateness(answer)
    return replace(answer, seconds=time.perf_counter() - begin)


class _TimeLimit:
    """Ends drops some seconds after they began, or when the caller wants it.

    `seconds`: 0 for no limit; raises RequestError if it is below.
    """

    def __init__(
        self, seconds: float, begin: float, should_stop: Callable[[], bool] | None
    ) -> None:
        if not 0.0 <= real_number("max_seconds", seconds) < math.inf:
            raise errors.RequestError(
                "max_seconds from 0 up", f"{seconds!r}", "0 sets no limit"
            )
        self._seconds = seconds
        self._begin = begin  # by the performance counter
        self._should_stop = should_stop
        self._is_late = False

    def is_over(self) -> bool:
        """Whether to end now."""
        if self._should_stop is not None and self._should_stop():
            return True
        self._is_late = 0.0 < self._seconds <= time.perf_counter() - self._begin
        return self._is_late

    def warn_of_lateness(self, answer: PoseStatistics) -> PoseStatistics:
        """The same answer, with a warning where the seconds were too few for it."""
        if not self._is_late:
            return answer
        warning = note(
            "TIME_LIMIT",
            f"ended after {self._seconds:g} s with {answer.drops} drops done, before "
            "the target was reached.",
        )
        return replace(answer, warnings=(*answer.warnings, warning))


def answer_with_drops(
    estimate: PoseStatistics,
    part: Part,
    scene: DropScene,
    request: DropRequest,
    watch: Watch,
) -> PoseStatistics:
    """Drop a part beside its estimate until the answer is sure; `choice` says why.

    A request without a target gets the default one, and its budget. Where symmetry
    decides all or drops hardly end, the estimate answers alone; also for the hull of an
    open solid, of which drops would tell an error that is not the part's.
    """
    if not part.error_known:
        if request.target_error:
            part.require_known_error("a target error")
        choice = f"{estimate.method} alone: no error of an open solid can be told."
        return replace(estimate, choice=choice)
    if not request.target_error:
        request = replace(request, target_error=DEFAULT_TARGET, events=MOST_EVENTS)
    target = request.target_error
    resting = poses_in(part, scene)
    prior = confidence.estimate_prior(estimate, resting, scene)
    if len(prior.size) == 1 or _hardly_ends(scene, estimate.radius):
        bound = confidence.estimate_bound(estimate, resting, scene)
        choice = explain_answer(estimate.method, estimate.method, 0, bound, target)
        answer = replace(estimate, choice=choice)
        if target_reached(bound, target):
            return answer
        warning = note(
            "TARGET_MISSED",
            f"the 90 % bound of the error is {bound:.2g} without drops, above the "
            f"target of {target:g}.",
        )
        return replace(answer, warnings=(*answer.warnings, warning))
    answer = drop_with_prior(prior, part, scene, request, watch, LEAST_DROPS)
    warnings = dict.fromkeys((*answer.warnings, *estimate.warnings))
    bound = confidence.judge_drops(prior, answer.column("count")).bound
    if request.events and answer.drops < LEAST_DROPS and target_reached(bound, target):
        warning = note(
            "TARGET_MISSED",
            f"{answer.drops} drops are fewer than the {LEAST_DROPS} from which on the "
            "estimate hardly matters; unless it is wrong, the 90 % bound of the error "
            f"is {bound:.2g}.",
        )
        warnings[warning] = None
    return replace(
        answer,
        choice=explain_answer(
            estimate.method, answer.method, answer.drops, bound, target
        ),
        warnings=tuple(warnings),
    )


def _hardly_ends(scene: DropScene, radius: float) -> bool:
    return (
        scene.restitution > MOST_RESTITUTION
        or scene.release_height(radius) > MOST_RADII * radius
    )


def explain_answer(
    estimator: str, method: str, drops: int, bound: float, target: float
) -> str:
    """Why an answer by a method is what it is, and how sure.

    `estimator`: whose estimate the drops were made beside.
    """
    subject = f"{estimator}, the most accurate estimate here, with {drops} drops"
    if method == methods.SIMULATION:
        subject = f"Drops contradict {estimator}; the {drops} drops alone"
    elif not drops and bound == 0.0:
        return f"Symmetry decides all, so {estimator} alone is exact."
    elif not drops:
        subject = f"Drops hardly end in such a scene; {estimator} alone"
    if target_reached(bound, target):
        return confidence.explain_kept_target(subject, bound, target)
    return f"{confidence.explain_missed_target(subject, bound, target)}."


def estimate(
    part: Part,
    method: str = methods.DEFAULT_METHOD,
    *,
    restitution: float = DEFAULT_RESTITUTION,
    drop_height: float | None = None,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> PoseStatistics:
    """Estimate the resting probabilities of a part's stable poses.

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    method : str
        One of `methods.AT_ONCE`: an estimator by its name, or `auto` for the best one
        checked by some drops, as by `auto(part)`.
    restitution, drop_height, cluster_tolerance, round_sides
        As for `simulate`. Few estimators know the first two (`knows_scene`).

    Returns
    -------
    PoseStatistics
        All stable poses, most probable first.

    Raises
    ------
    RequestError
        If the method is unknown or a value is out of its range.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    if method == methods.AUTO:
        return auto(
            part,
            0.0,
            None,
            restitution,
            None,
            drop_height,
            cluster_tolerance=cluster_tolerance,
            round_sides=round_sides,
        )
    return estimate_in(
        part,
        DropScene(restitution, drop_height, cluster_tolerance, round_sides),
        method,
    )
