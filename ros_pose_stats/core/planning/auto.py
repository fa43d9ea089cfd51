"""The default answer: a checked estimate, or the cheapest way to a target error."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from ...base import errors, methods
from ..estimators.estimate import estimate_in
from ..records import DropScene, Part, PoseStatistics
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    real_number,
)
from ..simulation.request import OnProgress, Watch, drop_request
from .hybrid import check_estimate, keep_target

MOST_DROPS = 10_000_000  # drops that a target may cost where the caller sets no bound


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
    """Pose statistics that keep a target error, by the cheapest method that does.

    Without a target the answer is the best estimate, checked by 50 to 200 drops beside
    it: as many as a budget of impacts and steps allows, which is the same on every
    machine. How far to believe the estimate is judged by how well it agrees with the
    drops.

    The target is kept if the root mean square error over the poses, against what
    infinitely many drops would give, is at most the target with a probability of 90 %.
    An estimate answers if it is that sure of this part; else as many drops as needed,
    with the estimate's help; without it where the estimate stands for next to no drops.

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    target_error : float
        A fraction, 0 to below 1; 0 asks for the checked estimate.
    drops : int, optional
        The most, 1 to 1e9. Default: 10 million, and 200 without a target.
    seed : int, optional
        As for `hybrid`; without a target the default is the part's own, from its
        digest.
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
        MOST_DROPS if drops is None else drops, seed, target_error, workers
    )
    if not 0.0 <= real_number("max_seconds", max_seconds) < math.inf:
        raise errors.RequestError(
            "max_seconds from 0 up", f"{max_seconds!r}", "0 sets no limit"
        )
    is_late = False

    def is_over() -> bool:
        nonlocal is_late
        if should_stop is not None and should_stop():
            return True
        is_late = 0.0 < max_seconds <= time.perf_counter() - begin
        return is_late

    best_estimate = estimate_in(part, scene, methods.AUTO)
    if not target_error and seed is None:
        request = replace(request, seed=part.seed)
    answer_request = keep_target if target_error else check_estimate
    statistics, choice = answer_request(
        best_estimate, part, scene, request, Watch(on_progress, is_over)
    )
    warnings = statistics.warnings
    if is_late:
        aim = "the target was reached" if target_error else "all were"
        warnings = (
            *warnings,
            f"TIME_LIMIT: ended after {max_seconds:g} s with {statistics.drops} drops "
            f"done, before {aim}.",
        )
    return replace(
        statistics,
        choice=choice,
        seconds=time.perf_counter() - begin,
        warnings=warnings,
    )


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
