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

"""The numbers of a report on a part, before they are put into words and pictures."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import NamedTuple

from ...core.estimators import best_method, estimate_all
from ...core.kernels.compilation import prepare_kernels
from ...core.planning.auto import auto
from ...core.planning.feeder_cell import FeederCell, KickPlan
from ...core.planning.feeding_plan import FeedingPlan, plan_feeding
from ...core.records import DropScene, FlipStatistics, Part, PoseStatistics
from ...core.records.notes import Note
from ...core.records.scene import DEFAULT_SEED
from ...core.resting import pose_sphere, poses, splitting_graph
from ...core.resting.silhouettes import find_lookalikes
from ...core.simulation import flips, request, simulate
from ...core.statistics import feeding, pose_groups
from ..design.sensitivity import Sensitivity, sensitivity

TARGET_ERROR = 0.01
MOST_DROPS = 10_000
"""Error that the drops of a page are to reach, and the most of them, where their number
is not given: a page should be there soon, and a real plate adds five points anyway."""


@dataclass(frozen=True)
class Feeder:
    """A feeder that accepts some poses."""

    wanted: tuple[int, ...]  # `index` of the accepted poses
    cell: FeederCell | None = None  # that is to be planned
    # of kicks that the cell gives now, metres; None where it does not kick
    kick_height: float | None = None
    flips: int | None = None  # out of each pose at each kick; None for the usual number
    # side of what a pixel of its camera shows of the plate, metres
    pixel: float | None = None
    # whether to find out which changes of the part raise the accepted share
    changes: bool = False

    def check(self, poses: int) -> None:
        """Check what is asked, before anything is dropped."""
        if self.wanted or self.changes or self.cell is not None:
            feeding.check_wanted_poses(self.wanted, poses)
        if self.cell is not None:
            self.cell.check()
        if self.kick_height is not None:
            flips.check_kick(self.kick_height)


class CellFindings(NamedTuple):
    """What a cell is to do, by the default answer."""

    plan: FeedingPlan
    own_kick: KickPlan | None  # by the kick that it gives now
    # the best kick, or its own where none gains anything, or none
    flips: FlipStatistics | None


@dataclass(frozen=True, eq=False)
class Findings:
    """The numbers of a report."""

    part: Part
    simulated: PoseStatistics  # counted from drops
    answer: PoseStatistics  # the default one, by fewer drops and an estimate
    estimates: tuple[PoseStatistics, ...]  # by every estimator, in the registry's order
    graph: splitting_graph.SplittingNode  # with the shares of the simulated drops
    sphere: pose_sphere.PoseSphere
    feeder: Feeder  # what was asked; without wanted poses there is no feeder
    # share of the parts that end in wanted poses, by `for_feeder`
    accepted: feeding.Bounded | None
    cell: CellFindings | None
    target_error: float  # that the drops were to reach; 0 where their number was given
    # what changes of the part do to the accepted share
    sensitivity: Sensitivity | None = None

    @property
    def for_feeder(self) -> PoseStatistics:
        """What is said of a feeder is by: the drops, with a cell what plans it."""
        return self.simulated if self.cell is None else self.answer

    @property
    def best_estimate(self) -> PoseStatistics:
        """By the estimator that is the most accurate one at this restitution."""
        best = best_method(self.simulated.restitution)
        return next(estimate for estimate in self.estimates if estimate.method == best)

    @property
    def warnings(self) -> tuple[Note, ...]:
        """Of the wanted poses, and of the drops."""
        return (
            *pose_groups.warn_of_lookalikes(self.simulated, self.feeder.wanted),
            *self.simulated.warnings,
        )

    @property
    def cautions(self) -> list[Note]:
        """What else to act on the estimates say of themselves, each code once."""
        codes = {warning.code for warning in self.simulated.warnings}
        cautions = {
            warning.code: warning
            for statistics in (self.best_estimate, *self.estimates)[::-1]
            for warning in statistics.warnings
            if warning.acts
        }
        return [warning for code, warning in cautions.items() if code not in codes]


def investigate(
    part: Part,
    scene: DropScene,
    feeder: Feeder,
    drops: int | None,
    seed: int | None,
    on_progress: Callable[[float, str], object],
) -> Findings:
    """Compute the numbers of a report; equal requests give equal counts.

    `drops`: None for as many as bring the error over the poses within a point, at most
    10 000; `on_progress`: takes the share done, 0 to 1, and what is done.
    """
    resting = poses.poses_in(part, scene)
    keywords = asdict(scene)
    feeder.check(len(resting.poses))
    prepare_kernels()
    answer = find_lookalikes(auto(part, **keywords), part, feeder.pixel)
    cell = None
    if feeder.cell is not None:
        cell = _plan_cell(part, scene, feeder, feeder.cell, answer, seed, on_progress)
    target = 0.0
    bound = MOST_DROPS
    ending = ""
    if drops is None and part.error_known:
        target = TARGET_ERROR
        ending = ", or fewer"
    elif drops is not None:
        bound = drops
    simulated = simulate.simulate(
        part,
        bound,
        seed=seed,
        target_error=target,
        **keywords,
        on_progress=lambda progress: on_progress(
            progress.drops / bound, f"{progress.drops} of {bound} drops{ending}"
        ),
    )
    simulated = find_lookalikes(simulated, part, feeder.pixel)
    changes = None
    estimates = estimate_all(part, **keywords)
    graph = splitting_graph.with_shares(
        splitting_graph.splitting_graph(resting), simulated.poses
    )
    if feeder.changes:
        changes = sensitivity(
            part,
            feeder.wanted,
            seed=simulated.seed,
            on_progress=lambda share: on_progress(share, "changes"),
            **keywords,
        )
    findings = Findings(
        part=part,
        simulated=simulated,
        answer=answer,
        estimates=tuple(estimates),
        graph=graph,
        sphere=pose_sphere.pose_sphere(resting),
        feeder=feeder,
        accepted=None,
        cell=cell,
        target_error=target,
        sensitivity=changes,
    )
    if not feeder.wanted or simulated.drops == simulated.unsettled:
        return findings
    shares = pose_groups.pose_shares(findings.for_feeder)
    return replace(findings, accepted=feeding.accepted_share(shares, feeder.wanted))


def _plan_cell(
    part: Part,
    scene: DropScene,
    feeder: Feeder,
    cell: FeederCell,
    answer: PoseStatistics,
    seed: int | None,
    on_progress: Callable[[float, str], object],
) -> CellFindings:
    """Plan with the feeder's own kick and usual ones, as the command `feeding` does."""
    # What is refused is refused at once.
    plan_feeding(answer, feeder.wanted, cell)
    own_height = feeder.kick_height
    heights: list[float] = []
    if own_height is not None or cell.plate is not None:
        heights += flips.usual_kicks(answer.radius)
    if own_height is not None:
        heights.append(own_height)
    kicks = flips.flips_by_kick(
        part,
        scene,
        heights,
        request.drop_request(
            flips.flips_per_pose(len(answer.poses), feeder.flips),
            DEFAULT_SEED if seed is None else seed,
        ),
        on_kick=lambda number, count: on_progress(
            number / count, f"kick {number + 1} of {count}"
        ),
    )
    plan = plan_feeding(answer, feeder.wanted, cell, kicks, part)
    by_height = dict(zip([kick.kick_height for kick in kicks], kicks, strict=True))
    own_kick = None
    shown_height = own_height
    if own_height is not None:
        own_kick = plan.options[1 + list(by_height).index(own_height)]
    if plan.best.is_kicking:
        shown_height = plan.best.kick_height
    shown_flips = None if shown_height is None else by_height[shown_height]
    return CellFindings(plan, own_kick, shown_flips)
