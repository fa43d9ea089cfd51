"""The numbers of a report on a part, before they are put into words and pictures."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..estimators import best_method, estimate_all
from ..kernels.compilation import prepare_kernels
from ..planning.confidence import pose_prior
from ..planning.hybrid import hybrid_statistics
from ..records import DropScene, Part, PoseStatistics
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION
from ..resting.pose_sphere import PoseSphere, pose_sphere
from ..resting.poses import resting_poses
from ..resting.splitting_graph import SplittingNode, splitting_graph
from ..simulation.simulate import simulate
from .feeding import Feeding, feeding, refuse_unknown
from .words import said_once

MOST_DROPS = 5000
LONGEST = 0.8
"""Most drops, and seconds of dropping, where the number of drops is not given. A page should be
there soon, and its intervals show how far the drops go."""


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
        Splitting graph for r, the levels of which are those for R too.
    sphere : PoseSphere
    wanted : Feeding or None
        Numbers of a feeder that accepts some poses.
    """

    part: Part
    simulated: PoseStatistics
    hybrid: PoseStatistics
    estimates: tuple[PoseStatistics, ...]
    graph: SplittingNode
    sphere: PoseSphere
    wanted: Feeding | None

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
                workers: int | None = None, wanted: Sequence[int] = (),
                rate: float | None = None,
                should_stop: Callable[[], bool] | None = None) -> Findings:
    """Compute the numbers of a report.

    Parameters
    ----------
    part : Part
    drops : int, optional
        Default: 5000, or as many as are done in 0.8 s. However many they were, the same
        number with the same seed gives the same counts.
    seed, restitution, drop_height, cluster_tolerance, workers
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
    resting = resting_poses(part, cluster_tolerance)
    if rate is not None or len(wanted):
        refuse_unknown(wanted, len(resting.poses), rate)
    prepare_kernels()
    until = time.perf_counter() + LONGEST

    def stop() -> bool:
        asked = should_stop is not None and should_stop()
        return asked or (drops is None and time.perf_counter() > until)

    simulated = simulate(part, MOST_DROPS if drops is None else drops, restitution, seed,
                         drop_height, workers=workers, should_stop=stop,
                         cluster_tolerance=cluster_tolerance)
    asked = feeding(simulated, wanted, rate) if len(wanted) else None
    estimates = estimate_all(part, restitution=restitution, drop_height=drop_height,
                             cluster_tolerance=cluster_tolerance)
    scene = DropScene(restitution, drop_height, cluster_tolerance)
    combined = hybrid_statistics(simulated, pose_prior(resting, scene))
    return Findings(part, simulated, combined, tuple(estimates), splitting_graph(resting),
                    pose_sphere(resting), asked)
