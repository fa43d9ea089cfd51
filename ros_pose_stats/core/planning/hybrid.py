"""An estimate and drops combined: fewer drops for the same error."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ...base.methods import HYBRID
from ..records import DropProgress, DropScene, Part, PoseStatistics, statistics
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ..resting.poses import poses_in
from ..simulation import request as requests, simulate
from ..statistics import prefix, prior as priors
from . import confidence


def hybrid(
    part: Part,
    drops: int | None = None,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int | None = None,
    drop_height: float | None = None,
    target_error: float = 0.0,
    workers: int | None = None,
    on_progress: Callable[[DropProgress], object] | None = None,
    should_stop: Callable[[], bool] | None = None,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> PoseStatistics:
    """Drop a part, and take an estimate as if it were drops already made.

    How many drops the estimate is worth is judged by its expected error on this part, and by
    how well the counts agree with it. Poses that symmetry makes equal share their counts. Where
    drops contradict the estimate beyond both errors, the answer is that of the drops alone, with
    the method `simulation` and the warning `CONFLICT`.

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    drops : int, optional
        How many, 1 to 1e9; the most where a target error is given. Default: 10 000.
    seed : int, optional
        0 to 2^64 - 1; the drops are those of `simulate`. Default: a fresh one, to be found in
        the answer.
    target_error : float
        Stop once the root mean square error over the poses is within this fraction with 90 %
        confidence; looked at after 10 drops, and then where it may be reached. 0 asks for all
        drops.
    restitution, drop_height, workers, on_progress, should_stop, cluster_tolerance, round_sides
        As for `simulate`.

    Returns
    -------
    PoseStatistics
        Probabilities are posterior means, intervals the shortest ones of 90 %, `count` the
        plain counts. The same request gives the same answer, whatever the workers.

    Raises
    ------
    RequestError
        If a value is out of its range.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    begin = time.perf_counter()
    request = requests.drop_request(drops, seed, target_error, workers)
    prior = confidence.pose_prior(poses_in(part, scene), scene)
    found = drop_with(
        prior,
        part,
        scene,
        request,
        requests.Watch.of(on_progress, should_stop),
        confidence.FIRST_LOOK,
    )
    return replace(found, seconds=time.perf_counter() - begin)


def drop_with(
    prior: priors.PosePrior | None,
    part: Part,
    scene: DropScene,
    request: requests.DropRequest,
    watch: requests.Watch,
    look: int,
) -> PoseStatistics:
    """Drop a part, and combine the drops with an estimate; `look`: drops before the first look."""
    judge = prefix.Judge(partial(confidence.judge_drops, prior), look)
    if prior is None:
        return simulate.count_drops(part, scene, request, watch, judge)
    combined = watch._replace(on_progress=combined_progress(prior, watch.on_progress))
    return hybrid_statistics(
        simulate.count_drops(part, scene, request, combined, judge), prior
    )


def hybrid_statistics(
    counted: PoseStatistics, prior: priors.PosePrior
) -> PoseStatistics:
    """Combine counts of random drops with an estimate, in a millisecond or two for ten poses.

    Where they refute the estimate they stay as they are, with the warning `CONFLICT`.
    """
    counts = np.array([pose.count for pose in counted.by_index.values()])
    refuted = np.flatnonzero(prior.contradicted(counts))
    if refuted.size:
        return replace(
            counted,
            warnings=(
                *counted.warnings,
                confidence.describe_conflict(
                    prior,
                    counts,
                    refuted,
                    "drops contradict the estimate",
                    "estimated",
                    "the estimate is left out, so the answer is that of the drops",
                ),
            ),
        )
    return statistics.with_shares(counted, HYBRID, prior.updated(counts).shares(counts))


def combined_progress(
    prior: priors.PosePrior, told: Callable[[DropProgress], object] | None
) -> Callable[[DropProgress], object] | None:
    """Progress of a simulation as that of the hybrid; None where nobody listens."""
    if told is None:
        return None

    def tell(progress: DropProgress) -> None:
        told(
            replace(
                progress,
                statistics=lambda: hybrid_statistics(progress.statistics(), prior),
            )
        )

    return tell


CHECK_DROPS = 200
CHECK_EVENTS = 50_000
"""Drops beside an estimate that check it, and the impacts and steps that they may take together.
A part that takes many to calm down is dropped less often, but 50 times."""

MOST_RESTITUTION = 0.99
MOST_RADII = 100.0
"""Scenes up to which estimates are checked: a drop that hardly ends takes seconds."""


def checked(
    best: PoseStatistics,
    part: Part,
    scene: DropScene,
    request: requests.DropRequest,
    watch: requests.Watch,
) -> tuple[PoseStatistics, str]:
    """An estimate with drops beside it, or alone where they say nothing or hardly end; why."""
    prior = confidence.prior_of(best, poses_in(part, scene), scene)
    found = best
    if len(prior.size) > 1 and not _hardly_ends(scene, best.radius):
        few = replace(
            request, drops=min(request.drops, CHECK_DROPS), events=CHECK_EVENTS
        )
        found = drop_with(prior, part, scene, few, watch, confidence.FIRST_LOOK)
    return found, explain_check(best.method, found.drops, scene, best.radius)


def _hardly_ends(scene: DropScene, radius: float) -> bool:
    return (
        scene.restitution > MOST_RESTITUTION
        or scene.release_height(radius) > MOST_RADII * radius
    )


def explain_check(method: str, drops: int, scene: DropScene, radius: float) -> str:
    """Why an estimate with so many drops beside it answers."""
    if not drops:
        return (
            f"Drops hardly end in such a scene, so {method} answers alone."
            if _hardly_ends(scene, radius)
            else f"Symmetry decides all, so {method} alone is exact."
        )
    return (
        f"{method} is expected to be the most accurate estimate of this part; no target error "
        f"was asked for, so {drops} drops check it."
    )


def keep_target(
    best: PoseStatistics,
    part: Part,
    scene: DropScene,
    request: requests.DropRequest,
    watch: requests.Watch,
) -> tuple[PoseStatistics, str]:
    """The estimate if it keeps the target, else drops, with its help if it has some worth; why."""
    target = request.target_error
    prior = confidence.prior_of(best, poses_in(part, scene), scene)
    bound = confidence.estimate_bound(prior)
    if bound <= target:
        return best, confidence.enough(f"{best.method} alone", bound, target)
    helped = confidence.worthwhile(prior, target)
    found = drop_with(
        prior if helped else None,
        part,
        scene,
        request,
        watch,
        confidence.first_look(prior, target, helped),
    )
    if math.isinf(bound):
        return (
            found,
            f"Estimates do not know so low a drop; so {found.drops} drops were counted.",
        )
    why = (
        f"; so {found.drops} drops were added"
        if found.method == HYBRID
        else f", and {'drops contradict it' if helped else 'worth too few drops to matter'}; so "
        f"{found.drops} drops were counted"
    )
    return (
        found,
        f"{confidence.not_enough(f'{best.method} alone', bound, target)}{why}.",
    )
