"""An estimate and drops combined: fewer drops for the same error."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..methods import HYBRID
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION, DEFAULT_ROUND_SIDES
from ..records.statistics import ranked
from ..resting.poses import resting_poses
from ..simulation.simulate import simulate
from ..statistics.prefix import Judge
from ..statistics.prior import PosePrior
from ..text import percent, ranges, several
from .confidence import (
    FIRST_LOOK,
    enough,
    estimate_bound,
    first_look,
    judge_drops,
    not_enough,
    pose_prior,
    prior_of,
    worthwhile,
)


def hybrid(part: Part, drops: int | None = None, restitution: float = DEFAULT_RESTITUTION,
           seed: int | None = None, drop_height: float | None = None, target_error: float = 0.0,
           workers: int | None = None,
           on_progress: Callable[[DropProgress], object] | None = None,
           should_stop: Callable[[], bool] | None = None, *,
           cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
           round_sides: int = DEFAULT_ROUND_SIDES) -> PoseStatistics:
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
    restitution : float
        Coefficient of restitution, 0 <= restitution < 1.
    seed : int, optional
        0 to 2^64 - 1; the drops are those of `simulate`. Default: a fresh one, to be found in
        the answer.
    drop_height : float, optional
        Height of the centre of mass at release, metres. Default: 20 part radii.
    target_error : float
        Stop once the root mean square error over the poses is within this fraction with 90 %
        confidence; looked at after 10 drops, and then where it may be reached. 0 asks for all
        drops.
    workers : int, optional
        Threads; default: all cores.
    on_progress, should_stop : callable, optional
        As for `simulate`.
    cluster_tolerance : float
        Least rise out of a pose as a share of its height there; 0 merges nothing.
    round_sides : int
        Sides a turn of the polygons that round surfaces stand as; 0 takes the file as it is.

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
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    prior = pose_prior(resting_poses(part, scene.cluster_tolerance, scene.round_sides), scene)
    judge = Judge(partial(judge_drops, prior), FIRST_LOOK)
    counted = simulate(part, drops, restitution, seed, drop_height, target_error, workers,
                       on_progress=combined_progress(prior, on_progress),
                       should_stop=should_stop, cluster_tolerance=cluster_tolerance,
                       round_sides=round_sides, judge=judge)
    return replace(hybrid_statistics(counted, prior), seconds=time.perf_counter() - begin)


def hybrid_statistics(counted: PoseStatistics, prior: PosePrior) -> PoseStatistics:
    """Counts of a simulation combined with an estimate.

    Takes about a millisecond or two for ten poses, so that it can be had at any moment of a run.

    `counted`: of independent drops, as from `simulate` with random starting directions; `prior`:
    from `pose_prior` of the same part, scene and cluster tolerance. Returns as `counted`, with the
    method `hybrid`, and probabilities and errors of both together; where the counts refute the
    estimate, `counted` itself with the warning `CONFLICT`. Raises RequestError if the prior is of
    another number of poses.
    """
    poses = sorted(counted.poses, key=lambda pose: pose.index)
    counts = np.array([pose.count for pose in poses])
    refuted = np.flatnonzero(prior.contradicted(counts))
    if refuted.size:
        return replace(counted, warnings=(*counted.warnings, describe_conflict(counts, prior,
                                                                               refuted)))
    posterior = prior.updated(counts)
    low, high = posterior.interval()
    rows = zip(poses, posterior.probability.tolist(), low.tolist(), high.tolist(),
               posterior.standard_error.tolist(), counts.tolist(), strict=True)
    return replace(counted, method=HYBRID, expected_error=posterior.expected_error,
                   largest_error=posterior.largest_error(),
                   poses=ranked([pose.with_probability(*known) for pose, *known in rows]))


def describe_conflict(counts: NDArray[np.int64], prior: PosePrior,
                      refuted: NDArray[np.int64]) -> str:
    """The warning, with the pose that is farthest off first.

    `counts` (P,) int; `refuted` (R,) int: indices of the poses in which counts contradict the
    estimate, at least one.
    """
    estimated = (prior.mean / prior.size)[prior.unit]
    share = counts / counts.sum()
    first = refuted[np.argsort(-np.abs(share - estimated)[refuted], kind="stable")]
    worst, others = first[0], several(first.size, "pose")
    return (f"CONFLICT: drops contradict the estimate in {others} ({ranges(sorted(first))}), in "
            f"pose {worst} most: counted {percent(share[worst])} %, estimated "
            f"{percent(estimated[worst])} %; the estimate is left out, so the answer is that of "
            f"the drops.")


def combined_progress(prior: PosePrior, told: Callable[[DropProgress], object] | None
                      ) -> Callable[[DropProgress], object] | None:
    """Progress of a simulation as that of the hybrid; None where nobody listens."""
    if told is None:
        return None

    def tell(progress: DropProgress) -> None:
        told(replace(progress,
                     statistics=lambda: hybrid_statistics(progress.statistics(), prior)))

    return tell


class Asked(NamedTuple):
    """What `auto` hands on to the drops."""

    target_error: float
    drops: int
    seed: int | None
    workers: int | None


def keep_target(best: PoseStatistics, part: Part, scene: DropScene, asked: Asked,
                on_progress: Callable[[DropProgress], object] | None,
                should_stop: Callable[[], bool]) -> tuple[PoseStatistics, str]:
    """The estimate if it keeps the target, else drops; and why."""
    prior = prior_of(best, resting_poses(part, scene.cluster_tolerance, scene.round_sides), scene)
    bound = estimate_bound(prior)
    if bound <= asked.target_error:
        return best, enough(f"{best.method} alone", bound, asked.target_error)
    found = _dropped(part, scene, asked, prior, on_progress, should_stop)
    return found, _why_drops(found, best.method, bound, asked.target_error)


def _dropped(part: Part, scene: DropScene, asked: Asked, prior: PosePrior,
             on_progress: Callable[[DropProgress], object] | None,
             should_stop: Callable[[], bool]) -> PoseStatistics:
    """As many drops as the target needs, with the estimate's help where it has some worth."""
    helped = worthwhile(prior, asked.target_error)
    counted = simulate(
        part, asked.drops, scene.restitution, asked.seed, scene.drop_height, asked.target_error,
        asked.workers, should_stop=should_stop, cluster_tolerance=scene.cluster_tolerance,
        round_sides=scene.round_sides,
        on_progress=combined_progress(prior, on_progress) if helped else on_progress,
        judge=Judge(partial(judge_drops, prior if helped else None),
                    first_look(prior, asked.target_error, helped)))
    return hybrid_statistics(counted, prior) if helped else counted


def _why_drops(found: PoseStatistics, method: str, bound: float, target_error: float) -> str:
    if math.isinf(bound):
        return f"Estimates do not know so low a drop; so {found.drops} drops were counted."
    alone = not_enough(f"{method} alone", bound, target_error)
    if found.method == HYBRID:
        return f"{alone}; so {found.drops} drops were added."
    if any(line.startswith("CONFLICT:") for line in found.warnings):
        return f"{alone}, and drops contradict it; so {found.drops} drops were counted."
    return f"{alone}, and worth too few drops to matter; so {found.drops} drops were counted."
