"""The cheapest method that reaches a target error."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from ..estimators import estimate
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION
from ..simulation.request import drop_request
from .best import best_method
from .time_limit import TimeLimit
from .words import untargeted

MOST_DROPS = 10_000_000
"""Drops that a target may cost where the caller sets no bound."""


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
    most = MOST_DROPS if drops is None else drops
    drop_request(most, seed, target_error, workers, "random", None)  # refused at once
    in_time = TimeLimit(max_seconds, begin, should_stop)
    found = estimate(part, best_method(restitution), restitution=restitution,
                     drop_height=drop_height, cluster_tolerance=cluster_tolerance)
    choice = untargeted(found.method)
    if target_error > 0.0:
        from .targeted import Asked, keep_target  # with all that drops the part

        asked = Asked(target_error, most, seed, workers)
        found, choice = keep_target(found, part, scene, asked, on_progress, in_time)
    return replace(found, choice=choice, seconds=time.perf_counter() - begin,
                   warnings=(*found.warnings, *in_time.warnings(found.drops)))
