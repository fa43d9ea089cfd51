"""The numbers of a report on a part, before they are put into words and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..estimators import best_method, estimate_all
from ..kernels.compilation import prepare_kernels
from ..planning.confidence import pose_prior
from ..planning.hybrid import hybrid_statistics
from ..records import DropScene, Part, PoseStatistics
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION, DEFAULT_ROUND_SIDES
from ..resting.pose_sphere import PoseSphere, pose_sphere
from ..resting.poses import resting_poses
from ..resting.splitting_graph import SplittingNode, splitting_graph, with_shares
from ..simulation.simulate import simulate
from .feeding import Feeding, feeding, refuse_unknown
from .words import said_once

TARGET_ERROR = 0.01
MOST_DROPS = 10_000
"""Error that the drops of a page are to reach, and the most of them, where their number is not
given: a page should be there soon, and a real plate adds five points anyway."""


@dataclass(frozen=True, eq=False)
class Findings:
    """The numbers of a report.

    Attributes
    ----------
    part : Part
    simulated : PoseStatistics
        Counted from drops.
    hybrid : PoseStatistics
        The same drops and an estimate, combined.
    estimates : tuple of PoseStatistics
        By every estimator, in the registry's order.
    graph : SplittingNode
        Splitting graph with the shares of the simulated drops.
    sphere : PoseSphere
    wanted : Feeding or None
        Numbers of a feeder that accepts some poses.
    target_error : float
        That the drops were to reach; 0 where their number was given.
    """

    part: Part
    simulated: PoseStatistics
    hybrid: PoseStatistics
    estimates: tuple[PoseStatistics, ...]
    graph: SplittingNode
    sphere: PoseSphere
    wanted: Feeding | None
    target_error: float

    @property
    def best_estimate(self) -> PoseStatistics:
        """By the estimator that is the most accurate one at this restitution."""
        best = best_method(self.simulated.restitution)
        return next(one for one in self.estimates if one.method == best)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of all methods, each once."""
        return said_once((found.method, found.warnings)
                         for found in (self.simulated, *self.estimates))


def investigate(part: Part, *, drops: int | None = None, seed: int | None = None,
                restitution: float = DEFAULT_RESTITUTION, drop_height: float | None = None,
                cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
                round_sides: int = DEFAULT_ROUND_SIDES,
                workers: int | None = None, wanted: Sequence[int] = (),
                rate: float | None = None,
                should_stop: Callable[[], bool] | None = None) -> Findings:
    """Compute the numbers of a report.

    Parameters
    ----------
    part : Part
    drops : int, optional
        Default: as many as bring the error over the poses within a point, at most 10 000. The
        same request gives the same counts on every machine.
    seed, restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    wanted : sequence of int
        `index` of poses that a feeder accepts; none where there is no feeder.
    rate : float, optional
        Parts dropped a minute.
    should_stop : callable, optional
        Asked now and then; after True the simulation ends with the drops done by then.

    Raises
    ------
    RequestError
        If a value is out of its range or there is no such pose.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    resting = resting_poses(part, cluster_tolerance, round_sides)
    if rate is not None or len(wanted):
        refuse_unknown(wanted, len(resting.poses), rate)
    prepare_kernels()
    target = TARGET_ERROR if drops is None else 0.0
    simulated = simulate(part, MOST_DROPS if drops is None else drops, restitution, seed,
                         drop_height, target, workers, should_stop=should_stop,
                         cluster_tolerance=cluster_tolerance, round_sides=round_sides)
    asked = feeding(simulated, wanted, rate) if len(wanted) else None
    estimates = estimate_all(part, restitution=restitution, drop_height=drop_height,
                             cluster_tolerance=cluster_tolerance, round_sides=round_sides)
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    combined = hybrid_statistics(simulated, pose_prior(resting, scene))
    graph = with_shares(splitting_graph(resting), simulated.poses)
    return Findings(part, simulated, combined, tuple(estimates), graph, pose_sphere(resting),
                    asked, target)
