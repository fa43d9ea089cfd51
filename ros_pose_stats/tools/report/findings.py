"""The numbers of a report on a part, before they are put into words and pictures."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import NamedTuple

from ...base import errors
from ...core.estimators import best_method, estimate_all
from ...core.kernels.compilation import prepare_kernels
from ...core.planning.auto import auto
from ...core.records import DropScene, FlipStatistics, Part, PoseStatistics
from ...core.records.notes import Note
from ...core.resting import pose_sphere, poses, splitting_graph
from ...core.simulation import flips, request, simulate
from ...core.statistics import feeding, pose_groups
from ..design.sensitivity import Sensitivity, sensitivity

TARGET_ERROR = 0.01
MOST_DROPS = 10_000
"""Error that the drops of a page are to reach, and the most of them, where their number
is not given: a page should be there soon, and a real plate adds five points anyway."""

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
    # whether to find out which changes of the part raise the accepted share
    changes: bool = False

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
    answer: PoseStatistics  # the default one, by fewer drops and an estimate
    estimates: tuple[PoseStatistics, ...]  # by every estimator, in the registry's order
    graph: splitting_graph.SplittingNode  # with the shares of the simulated drops
    sphere: pose_sphere.PoseSphere
    feeder: Feeder  # what was asked; without wanted poses there is no feeder
    # what it gets if parts that lie wrong are dropped again
    afresh: feeding.Feeding | None
    # what it gets by kicking them from several heights, that of the feeder among them
    kicks: tuple[KickFeeding, ...]
    target_error: float  # that the drops were to reach; 0 where their number was given
    # what changes of the part do to the accepted share
    sensitivity: Sensitivity | None = None

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
    kicks: tuple[KickFeeding, ...] = ()
    afresh = changes = None
    if feeder.wanted and simulated.drops > simulated.unsettled:
        shares = pose_groups.pose_shares(simulated)
        rate = math.nan if feeder.rate is None else feeder.rate
        afresh = feeding.drop_afresh(shares, feeder.wanted, rate)
        if feeder.kick_height is not None:
            kicks = _try_kicks(part, scene, feeder, simulated, on_progress)
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
    return Findings(
        part=part,
        simulated=simulated,
        answer=auto(part, **keywords),
        estimates=tuple(estimates),
        graph=graph,
        sphere=pose_sphere.pose_sphere(resting),
        feeder=feeder,
        afresh=afresh,
        kicks=kicks,
        target_error=target,
        sensitivity=changes,
    )


def _try_kicks(
    part: Part,
    scene: DropScene,
    feeder: Feeder,
    simulated: PoseStatistics,
    on_progress: Callable[[float, str], object],
) -> tuple[KickFeeding, ...]:
    """What a feeder with a rate gets by its own kick, and by usual ones."""
    assert feeder.kick_height is not None
    assert feeder.rate is not None
    shares = pose_groups.pose_shares(simulated)
    simulated_flips = flips.flips_by_kick(
        part,
        replace(scene, drop_height=None),
        [feeder.kick_height, *flips.usual_kicks(simulated.radius)],
        request.drop_request(FLIPS, simulated.seed),
        on_kick=lambda number, count: on_progress(
            number / count, f"kick {number + 1} of {count}"
        ),
    )
    return tuple(
        KickFeeding(
            statistics,
            feeding.flip_wrong_poses(
                shares,
                statistics.effective_counts,
                feeder.wanted,
                feeder.rate,
                feeder.cycle_time,
            ),
        )
        for statistics in simulated_flips
    )
