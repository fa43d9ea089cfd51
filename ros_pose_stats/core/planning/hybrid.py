# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""An estimate and drops combined: fewer drops for the same error."""

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

FIRST_CHECKPOINT = 10
"""Drops before the first look at the error: an estimate may need no more."""

SHOWN_SECONDS = 0.1
"""Between two judgements that are only shown. To judge may take longer than the drops
since the last time, where these are slow."""


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
        FIRST_CHECKPOINT,
    )
    return replace(answer, seconds=time.perf_counter() - begin)


def drop_with_prior(
    prior: PosePrior,
    part: Part,
    scene: DropScene,
    request: DropRequest,
    watch: Watch,
    first_checkpoint: int,
) -> PoseStatistics:
    """Drop a part, and combine the drops with an estimate.

    `first_checkpoint`: drops before the first look.
    """
    # They weigh by their errors.
    part.require_known_error("an estimate and drops together")
    judge = Judge(
        partial(confidence.judge_drops, prior), first_checkpoint, SHOWN_SECONDS
    )
    combined = watch._replace(on_progress=combined_progress(prior, watch.on_progress))
    return hybrid_statistics(count_drops(part, scene, request, combined, judge), prior)


def hybrid_statistics(simulated: PoseStatistics, prior: PosePrior) -> PoseStatistics:
    """Combine counts of random drops with an estimate.

    Where they refute the estimate they stay as they are, with the warning `CONFLICT`.
    """
    counts = simulated.column("count")
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
