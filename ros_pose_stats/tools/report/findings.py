"""The numbers of a report on a part, before they are put into words and pictures."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import NamedTuple

from ...base import errors, text
from ...core.estimators import best_method, estimate_all
from ...core.kernels.compilation import prepare_kernels
from ...core.planning import confidence, hybrid
from ...core.records import DropScene, FlipStatistics, Part, PoseStatistics
from ...core.resting import pose_sphere as spheres, poses, splitting_graph as graphs
from ...core.simulation import flips, request, simulate
from ...core.statistics import feeding, pose_groups
from ..design.sensitivity import Sensitivity, sensitivity

TARGET_ERROR = 0.01
MOST_DROPS = 10_000
"""Error that the drops of a page are to reach, and the most of them, where their number is not
given: a page should be there soon, and a real plate adds five points anyway."""

FLIPS = 500  # flips a pose and kick: enough to see where the fastest kick lies


@dataclass(frozen=True)
class Feeder:
    """A feeder that accepts some poses."""

    wanted: tuple[int, ...]  # `index` of the accepted poses
    # parts dropped a minute, those sent back included; None where none was given
    rate: float | None = None
    # of kicks of parts that lie wrong, metres; None where it does not kick
    kick_height: float | None = None
    cycle_time: float = 1.0  # seconds from one kick to the next
    changes: bool = (
        False  # whether to find out which changes of the part raise the accepted share
    )

    def check(self, poses: int) -> None:
        """Check what is asked, before anything is dropped."""
        if self.wanted or self.changes or (self.rate, self.kick_height) != (None, None):
            feeding.check_wanted_poses(self.wanted, poses)
        feeding.check_rate(1.0 if self.rate is None else self.rate, self.cycle_time)
        if self.kick_height is not None:
            flips.check_kick(self.kick_height)
            if self.rate is None:
                raise errors.RequestError(
                    "a rate of parts a minute beside the kick height",
                    "none",
                    "count the parts that can be dropped, those sent back included",
                )


class KickFeeding(NamedTuple):
    """What a kick makes of a feeder."""

    flips: FlipStatistics
    feeding: feeding.Feeding


@dataclass(frozen=True, eq=False)
class Findings:
    """The numbers of a report."""

    part: Part
    simulated: PoseStatistics  # counted from drops
    hybrid: PoseStatistics  # the same drops and an estimate, combined
    estimates: tuple[PoseStatistics, ...]  # by every estimator, in the registry's order
    graph: (
        graphs.SplittingNode
    )  # splitting graph with the shares of the simulated drops
    sphere: spheres.PoseSphere
    feeder: Feeder  # what was asked; without wanted poses there is no feeder
    afresh: (
        feeding.Feeding | None
    )  # what it gets if parts that lie wrong are dropped again
    # what it gets by kicking them, from several heights, with that of the feeder among them
    kicks: tuple[KickFeeding, ...]
    target_error: float  # that the drops were to reach; 0 where their number was given
    sensitivity: Sensitivity | None = (
        None  # what changes of the part do to the accepted share
    )

    @property
    def kicked(self) -> KickFeeding | None:
        """What the feeder gets by its own kick."""
        return next(
            (
                kick
                for kick in self.kicks
                if kick.flips.kick_height == self.feeder.kick_height
            ),
            None,
        )

    @property
    def best_estimate(self) -> PoseStatistics:
        """By the estimator that is the most accurate one at this restitution."""
        best = best_method(self.simulated.restitution)
        return next(one for one in self.estimates if one.method == best)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What asks a person to act: of the drops, and of the wanted poses."""
        return (
            *pose_groups.warn_of_lookalikes(self.simulated, self.feeder.wanted),
            *self.simulated.warnings,
        )

    @property
    def cautions(self) -> list[str]:
        """What else the estimates say of themselves, each code once."""
        known = {text.code_of(one) for one in self.simulated.warnings}
        said = {
            text.code_of(one): one
            for found in (self.best_estimate, *self.estimates)[::-1]
            for one in found.warnings
        }
        return [one for code, one in said.items() if code not in known]


def investigate(
    part: Part,
    scene: DropScene,
    feeder: Feeder,
    drops: int | None,
    seed: int | None,
    on_progress: Callable[[float, str], object],
) -> Findings:
    """Compute the numbers of a report; the same request gives the same counts everywhere.

    `drops`: None for as many as bring the error over the poses within a point, at most 10 000;
    `on_progress`: takes the share done, 0 to 1, and what is done.
    """
    resting = poses.poses_in(part, scene)
    keywords = asdict(scene)
    feeder.check(len(resting.poses))
    prepare_kernels()
    target, bound = (TARGET_ERROR, MOST_DROPS) if drops is None else (0.0, drops)
    simulated = simulate.simulate(
        part,
        bound,
        seed=seed,
        target_error=target,
        **keywords,
        on_progress=lambda one: on_progress(
            one.drops / bound,
            f"{one.drops} of {bound} drops{', or fewer' * (drops is None)}",
        ),
    )
    kicks: tuple[KickFeeding, ...] = ()
    afresh = changes = None
    if feeder.wanted and simulated.drops > simulated.unsettled:
        shares = pose_groups.pose_shares(simulated)
        afresh = feeding.drop_afresh(
            shares, feeder.wanted, math.nan if feeder.rate is None else feeder.rate
        )
        if feeder.kick_height is not None and feeder.rate is not None:
            kicks = tuple(
                KickFeeding(
                    counted,
                    feeding.flip_wrong_poses(
                        shares,
                        counted.counts,
                        feeder.wanted,
                        feeder.rate,
                        feeder.cycle_time,
                    ),
                )
                for counted in flips.flips_by_kick(
                    part,
                    replace(scene, drop_height=None),
                    [feeder.kick_height, *flips.usual_kicks(simulated.radius)],
                    request.drop_request(FLIPS, simulated.seed),
                    on_kick=lambda place, count: on_progress(
                        place / count, f"kick {place + 1} of {count}"
                    ),
                )
            )
    estimates = estimate_all(part, **keywords)
    combined = hybrid.hybrid_statistics(
        simulated, confidence.pose_prior(resting, scene)
    )
    graph = graphs.with_shares(graphs.splitting_graph(resting), simulated.poses)
    if feeder.changes:
        changes = sensitivity(
            part,
            feeder.wanted,
            seed=simulated.seed,
            on_progress=lambda share: on_progress(share, "changes"),
            **keywords,
        )
    return Findings(
        part,
        simulated,
        combined,
        tuple(estimates),
        graph,
        spheres.pose_sphere(resting),
        feeder,
        afresh,
        kicks,
        target,
        changes,
    )
