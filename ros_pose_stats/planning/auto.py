"""The cheapest method that reaches a target error."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from ..estimators import estimate
from ..geometry.poses import resting_poses
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION
from ..simulation import simulate
from ..simulation.request import drop_request
from ..statistics.intervals import DEFAULT_LEVEL
from ..statistics.posterior import PosePrior
from ..statistics.prefix import Judge
from .confidence import (
    best_method,
    estimate_bound,
    first_look,
    plain_bound,
    prior_bound,
    worthwhile,
)
from .hybrid import METHOD as HYBRID
from .hybrid import combined_progress, hybrid_statistics
from .prior import prior_of
from .time_limit import TimeLimit
from .words import enough, not_enough, untargeted

MOST_DROPS = 10_000_000
"""Drops that a target may cost where the caller sets no bound."""

BOUND = f"{100.0 * DEFAULT_LEVEL:.0f} % bound of the error"


def auto(part: Part, target_error: float = 0.0, drops: int | None = None,
         restitution: float = DEFAULT_RESTITUTION, seed: int | None = None,
         drop_height: float | None = None, max_seconds: float = 0.0,
         workers: int | None = None,
         on_progress: Callable[[DropProgress], object] | None = None,
         should_stop: Callable[[], bool] | None = None, *,
         cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE) -> PoseStatistics:
    """Pose statistics that keep a target error, by the cheapest method that does.

    The target is kept if the root mean square error over the poses, against what infinitely
    many drops would give, is at most the target with a probability of 90 %. An estimate
    answers if it is that sure of this part; else as many drops as needed, with the estimate's
    help; without it where the estimate stands for next to no drops.

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    target_error : float
        A fraction, 0 to below 1; 0 asks for the best estimate at once.
    drops : int, optional
        The most, 1 to 1e9. Default: 10 million.
    restitution : float
        Coefficient of restitution, 0 <= restitution < 1.
    seed, drop_height, workers, on_progress, should_stop, cluster_tolerance
        As for `hybrid`.
    max_seconds : float
        Ends the drops, with a warning; the answer then depends on the speed of the machine.
        0 for no limit.

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
    scene = DropScene(restitution, drop_height, cluster_tolerance)
    asked = _Asked(target_error, MOST_DROPS if drops is None else drops, seed, workers)
    drop_request(asked.drops, seed, target_error, workers, "random", None)  # refused at once
    in_time = TimeLimit(max_seconds, begin, should_stop)
    found = estimate(part, best_method(restitution), restitution=restitution,
                     drop_height=drop_height, cluster_tolerance=cluster_tolerance)
    choice = untargeted(found.method)
    if target_error > 0.0:
        found, choice = _kept(found, part, scene, asked, on_progress, in_time)
    return replace(found, choice=choice, seconds=time.perf_counter() - begin,
                   warnings=(*found.warnings, *in_time.warnings(found.drops)))


class _Asked(NamedTuple):
    """What `auto` hands on to the drops."""

    target_error: float
    drops: int
    seed: int | None
    workers: int | None


def _kept(best: PoseStatistics, part: Part, scene: DropScene, asked: _Asked,
          on_progress: Callable[[DropProgress], object] | None,
          in_time: TimeLimit) -> tuple[PoseStatistics, str]:
    """The estimate if it keeps the target, else drops; and why."""
    prior = prior_of(best, resting_poses(part, scene.cluster_tolerance), scene)
    bound = estimate_bound(prior)
    if bound <= asked.target_error:
        return best, enough(f"{best.method} alone", bound, asked.target_error)
    found = _dropped(part, scene, asked, prior, on_progress, in_time)
    return found, _why_drops(found, best.method, bound, asked.target_error)


def _dropped(part: Part, scene: DropScene, asked: _Asked, prior: PosePrior,
             on_progress: Callable[[DropProgress], object] | None,
             in_time: TimeLimit) -> PoseStatistics:
    """As many drops as the target needs, with the estimate's help where it has some worth."""
    helped = worthwhile(prior, asked.target_error)
    counted = simulate(
        part, asked.drops, scene.restitution, asked.seed, scene.drop_height, asked.target_error,
        asked.workers, should_stop=in_time.over, cluster_tolerance=scene.cluster_tolerance,
        on_progress=combined_progress(prior, on_progress) if helped else on_progress,
        judge=Judge(prior_bound(prior) if helped else plain_bound, BOUND,
                    first_look(prior, asked.target_error, helped)))
    return hybrid_statistics(counted, prior) if helped else counted


def _why_drops(found: PoseStatistics, method: str, bound: float, target_error: float) -> str:
    if math.isinf(bound):
        return f"Estimates do not know so low a drop; so {found.drops} drops were counted."
    alone = not_enough(f"{method} alone", bound, target_error)
    if found.method == HYBRID:
        return f"{alone}; so {found.drops} drops were added."
    return f"{alone}, and worth too few drops to matter; so {found.drops} drops were counted."
