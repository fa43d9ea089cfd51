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

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple, TypeVar

from ...core.estimators import best_method, estimate_all
from ...core.kernels.compilation import prepare_kernels
from ...core.planning.auto import auto
from ...core.planning.feeder_cell import FeederCell, KickPlan
from ...core.planning.feeding_plan import FeedingPlan, check_feeding, plan_feeding
from ...core.records import DropScene, FlipStatistics, Part, PoseStatistics
from ...core.records.notes import Note
from ...core.records.scene import DEFAULT_SEED
from ...core.resting import pose_sphere, poses, splitting_graph
from ...core.resting.silhouettes import find_lookalikes
from ...core.simulation import flips, request, simulate
from ...core.statistics import feeding, pose_groups
from ..design.sensitivity import Sensitivity, sensitivity


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
    """What a cell is to do."""

    plan: FeedingPlan
    own_kick: KickPlan | None  # by the kick that it gives now
    # the best kick, or its own where none gains anything, or none
    flips: FlipStatistics | None


@dataclass(frozen=True, eq=False)
class Findings:
    """The numbers of a report."""

    part: Part
    answer: PoseStatistics  # which all shares and plans of the page are from
    estimates: tuple[PoseStatistics, ...]  # by every estimator, in the registry's order
    graph: splitting_graph.SplittingNode  # with the shares of the answer
    sphere: pose_sphere.PoseSphere
    feeder: Feeder  # what was asked; without wanted poses there is no feeder
    cell: CellFindings | None
    # what changes of the part do to the accepted share
    sensitivity: Sensitivity | None

    @property
    def has_shares(self) -> bool:
        """Whether any part came to rest."""
        return self.answer.drops == 0 or self.answer.drops > self.answer.unsettled

    @property
    def accepted(self) -> feeding.Bounded | None:
        """Share of the parts that end in wanted poses; None where none are wanted."""
        if not self.feeder.wanted or not self.has_shares:
            return None
        return feeding.share_of_poses(self.answer, self.feeder.wanted)

    @property
    def best_estimate(self) -> PoseStatistics:
        """By the estimator that is the most accurate one at this restitution."""
        best = best_method(self.answer.restitution)
        return next(estimate for estimate in self.estimates if estimate.method == best)

    @property
    def warnings(self) -> tuple[Note, ...]:
        """Of the wanted poses and the answer, or of the plan, which has both."""
        if self.cell is not None:
            return self.cell.plan.warnings
        return (
            *pose_groups.warn_of_lookalikes(self.answer, self.feeder.wanted),
            *self.answer.warnings,
        )

    @property
    def cautions(self) -> list[Note]:
        """What else to act on the estimates say of themselves, each code once."""
        codes = {warning.code for warning in self.answer.warnings}
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

    `drops`: None for the default answer, that of `estimate`; `seed`: of drops, flips
    and changes, None for that of the default answer; `on_progress`: takes the share
    done, 0 to 1, and what is done.
    """
    resting = poses.poses_in(part, scene)
    seed = DEFAULT_SEED if seed is None else seed
    keywords: dict[str, Any] = {**asdict(scene), "seed": seed}
    feeder.check(len(resting.poses))
    prepare_kernels()
    if drops is None:
        answer = auto(part, **keywords)
    else:
        answer = simulate.simulate(
            part,
            drops,
            **keywords,
            on_progress=lambda progress: on_progress(
                progress.drops / drops, f"{progress.drops} of {drops} drops"
            ),
        )
    answer = find_lookalikes(answer, part, feeder.pixel)
    cell = None
    if feeder.cell is not None:
        cell = _plan_cell(part, scene, feeder, feeder.cell, answer, seed, on_progress)
    changes = None
    if feeder.changes:
        changes = sensitivity(
            part,
            feeder.wanted,
            answer=answer,
            **keywords,
            on_progress=lambda share: on_progress(share, "changes"),
        )
    return Findings(
        part,
        answer,
        tuple(estimate_all(part, **asdict(scene))),
        splitting_graph.with_shares(
            splitting_graph.splitting_graph(resting), answer.poses
        ),
        pose_sphere.pose_sphere(resting),
        feeder,
        cell,
        changes,
    )


def _plan_cell(
    part: Part,
    scene: DropScene,
    feeder: Feeder,
    cell: FeederCell,
    answer: PoseStatistics,
    seed: int,
    on_progress: Callable[[float, str], object],
) -> CellFindings:
    """Plan with the feeder's own kick and usual ones, as the command `feeding` does."""
    # What is refused is refused at once.
    check_feeding(answer, feeder.wanted, cell)
    own_height = feeder.kick_height
    heights = cell.kick_heights(answer.radius, None, own_height is not None)
    if own_height is not None:
        heights += (own_height,)
    kicks = flips.flips_by_kick(
        part,
        scene,
        heights,
        request.drop_request(
            flips.flips_per_pose(len(answer.poses), feeder.flips), seed
        ),
        on_kick=lambda number, count: on_progress(
            number / count, f"kick {number + 1} of {count}"
        ),
    )
    plan = plan_feeding(answer, feeder.wanted, cell, kicks, part)
    own_kick = _at_height(own_height, plan.options[1:])
    shown_height = plan.best.kick_height if plan.best.is_kicking else own_height
    return CellFindings(plan, own_kick, _at_height(shown_height, kicks))


Kick = TypeVar("Kick", KickPlan, FlipStatistics)


def _at_height(height: float | None, kicks: Sequence[Kick]) -> Kick | None:
    """What is about the kick of a height, if anything."""
    return next((kick for kick in kicks if kick.kick_height == height), None)
