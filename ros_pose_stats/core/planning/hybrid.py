"""An estimate and drops combined: fewer drops for the same error."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ...base.methods import HYBRID
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ..records.shares import with_shares
from ..resting.poses import poses_in
from ..simulation.request import DropRequest, OnProgress, Watch, drop_request
from ..simulation.simulate import count_drops
from ..statistics.prefix import Judge
from ..statistics.prior import PosePrior
from . import confidence


def hybrid(
    part: Part,
    drops: int | None = None,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int | None = None,
    drop_height: float | None = None,
    target_error: float = 0.0,
    workers: int | None = None,
    on_progress: OnProgress = None,
    should_stop: Callable[[], bool] | None = None,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> PoseStatistics:
    """Drop a part, and take an estimate as if it were drops already made.

    How many drops the estimate is worth is judged by its expected error on this part,
    and by how well the counts agree with it. Poses that symmetry makes equal share
    their counts. Where drops contradict the estimate beyond both errors, the answer is
    that of the drops alone, with the method `simulation` and the warning `CONFLICT`.

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    drops : int, optional
        How many, 1 to 1e9; the most where a target error is given. Default: 10 000.
    seed : int, optional
        0 to 2^64 - 1; the drops are those of `simulate`. Default: a fresh one, to be
        found in the answer.
    target_error : float
        Stop once the root mean square error over the poses is within this fraction with
        90 % confidence; looked at after 10 drops, and then where it may be reached. 0
        asks for all drops.
    restitution, drop_height, workers, on_progress, should_stop, cluster_tolerance,
    round_sides
        As for `simulate`.

    Returns
    -------
    PoseStatistics
        Probabilities are posterior means, intervals the shortest ones of 90 %, `count`
        the plain counts. The same request gives the same answer, whatever the workers.

    Raises
    ------
    RequestError
        If a value is out of its range.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    begin = time.perf_counter()
    request = drop_request(drops, seed, target_error, workers)
    prior = confidence.pose_prior(poses_in(part, scene), scene)
    answer = drop_with_prior(
        prior,
        part,
        scene,
        request,
        Watch.from_callbacks(on_progress, should_stop),
        confidence.FIRST_CHECKPOINT,
    )
    return replace(answer, seconds=time.perf_counter() - begin)


def drop_with_prior(
    prior: PosePrior | None,
    part: Part,
    scene: DropScene,
    request: DropRequest,
    watch: Watch,
    first_checkpoint: int,
) -> PoseStatistics:
    """Drop a part, and combine the drops with an estimate.

    `first_checkpoint`: drops before the first look.
    """
    judge = Judge(partial(confidence.judge_drops, prior), first_checkpoint)
    if prior is None:
        return count_drops(part, scene, request, watch, judge)
    combined = watch._replace(on_progress=combined_progress(prior, watch.on_progress))
    return hybrid_statistics(count_drops(part, scene, request, combined, judge), prior)


def hybrid_statistics(simulated: PoseStatistics, prior: PosePrior) -> PoseStatistics:
    """Combine counts of random drops with an estimate.

    Where they refute the estimate they stay as they are, with the warning `CONFLICT`.
    """
    counts = np.array([pose.count for pose in simulated.by_index.values()])
    refuted = np.flatnonzero(prior.contradicted_poses(counts))
    if refuted.size:
        return replace(
            simulated,
            warnings=(
                *simulated.warnings,
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
    return with_shares(simulated, HYBRID, prior.update(counts).shares(counts))


def combined_progress(prior: PosePrior, on_progress: OnProgress) -> OnProgress:
    """Progress of a simulation as that of the hybrid; None where nobody listens."""
    if on_progress is None:
        return None

    def report(progress: DropProgress) -> None:
        def combined_statistics() -> PoseStatistics:
            return hybrid_statistics(progress.statistics(), prior)

        on_progress(replace(progress, statistics=combined_statistics))

    return report


CHECK_DROPS = 200
CHECK_EVENTS = 50_000
"""Drops beside an estimate that check it, and the impacts and steps that they may take
together. A part that takes many to calm down is dropped less often, but 50 times."""

MOST_RESTITUTION = 0.99
MOST_RADII = 100.0
"""Scenes up to which estimates are checked: a drop that hardly ends takes seconds."""


def check_estimate(
    estimate: PoseStatistics,
    part: Part,
    scene: DropScene,
    request: DropRequest,
    watch: Watch,
) -> tuple[PoseStatistics, str]:
    """An estimate checked by drops, and why it answers.

    It stays alone where drops say nothing or hardly end.
    """
    prior = confidence.estimate_prior(estimate, poses_in(part, scene), scene)
    answer = estimate
    if len(prior.size) > 1 and not _hardly_ends(scene, estimate.radius):
        check_request = replace(
            request, drops=min(request.drops, CHECK_DROPS), events=CHECK_EVENTS
        )
        answer = drop_with_prior(
            prior, part, scene, check_request, watch, confidence.FIRST_CHECKPOINT
        )
    return answer, explain_check(estimate.method, answer.drops, scene, estimate.radius)


def _hardly_ends(scene: DropScene, radius: float) -> bool:
    return (
        scene.restitution > MOST_RESTITUTION
        or scene.release_height(radius) > MOST_RADII * radius
    )


def explain_check(method: str, drops: int, scene: DropScene, radius: float) -> str:
    """Why an estimate with so many drops beside it answers."""
    if drops:
        return (
            f"{method} is expected to be the most accurate estimate of this part; no "
            f"target error was asked for, so {drops} drops check it."
        )
    if _hardly_ends(scene, radius):
        return f"Drops hardly end in such a scene, so {method} answers alone."
    return f"Symmetry decides all, so {method} alone is exact."


def keep_target(
    estimate: PoseStatistics,
    part: Part,
    scene: DropScene,
    request: DropRequest,
    watch: Watch,
) -> tuple[PoseStatistics, str]:
    """The estimate if it keeps the target, else drops, and why.

    The drops are combined with the estimate if that has some worth.
    """
    target = request.target_error
    prior = confidence.estimate_prior(estimate, poses_in(part, scene), scene)
    bound = confidence.estimate_bound(prior)
    subject = f"{estimate.method} alone"
    if bound <= target:
        return estimate, confidence.explain_kept_target(subject, bound, target)
    uses_estimate = confidence.is_worthwhile(prior, target)
    answer = drop_with_prior(
        prior if uses_estimate else None,
        part,
        scene,
        request,
        watch,
        confidence.first_checkpoint(prior, target, uses_estimate),
    )
    conclusion = f"so {answer.drops} drops were counted"
    if math.isinf(bound):
        return answer, f"Estimates do not know so low a drop; {conclusion}."
    if answer.method == HYBRID:
        reason = f"; so {answer.drops} drops were added"
    elif uses_estimate:
        reason = f", and drops contradict it; {conclusion}"
    else:
        reason = f", and worth too few drops to matter; {conclusion}"
    return (
        answer,
        f"{confidence.explain_missed_target(subject, bound, target)}{reason}.",
    )
