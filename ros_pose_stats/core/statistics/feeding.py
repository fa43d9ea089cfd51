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

"""Shares that a feeder accepts, with intervals, and flips that a cell has counted.

Counted flips are combined with those of the model.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln, ndtri

from ...base import text
from ...base.errors import RequestError
from ..records import Array, FlipStatistics, Index, Mask, PoseStatistics
from ..records.scene import is_whole_number
from .errors import DEFAULT_LEVEL, jeffreys_interval
from .pose_groups import PoseShares, list_poses, pose_shares


class Bounded(NamedTuple):
    """A number and the bounds of its 90 % interval; NaN where none are known."""

    value: float
    low: float
    high: float


CERTAIN_DROPS = 1e15  # so many drops would leave no error but that of rounding
CERTAINTY = Bounded(1.0, 1.0, 1.0)
NO_FLIPS = Bounded(0.0, 0.0, 0.0)


def passes_of(share: float, low: float, high: float) -> Bounded:
    """Drops that an accepted part takes where the others are dropped again."""
    value, low_passes, high_passes = (
        1.0 / bound if bound else math.inf for bound in (share, high, low)
    )
    return Bounded(value, low_passes, high_passes)


def relative_bounds(error: float) -> tuple[float, float]:
    """Factors from a positive number to the ends of its 90 % interval.

    `error`: its relative standard error. The number is log-normal, or where it is
    hardly known, which would leave it no bound, normal and not negative.
    """
    deviations = -float(ndtri(0.5 * (1.0 - DEFAULT_LEVEL)))
    if error > 1.0:
        return 0.0, 1.0 + deviations * error
    return math.exp(-deviations * error), math.exp(deviations * error)


def with_bounds(value: float, variance: float) -> Bounded:
    """A positive number with its interval; `variance`: the relative one."""
    low, high = relative_bounds(math.sqrt(variance))
    return Bounded(value, value * low, value * high)


def share_of_poses(statistics: PoseStatistics, poses: Sequence[int]) -> Bounded:
    """Share of some poses; where they are a row of the table, as it stands there."""
    for is_ungrouped in (False, True):
        for row in list_poses(statistics, is_ungrouped):
            if set(row.indices) == set(poses):
                return Bounded(
                    row.probability, row.probability_low, row.probability_high
                )
    return accepted_share(pose_shares(statistics), poses)


def accepted_share(dropped: PoseShares, wanted_poses: Sequence[int] | Index) -> Bounded:
    """Share of some poses; symmetry tells how a unit's share is shared out."""
    is_wanted = np.zeros(dropped.probability.size, dtype=np.bool_)
    is_wanted[list(wanted_poses)] = True
    if is_wanted.all():
        return CERTAINTY
    drops = dropped.drops
    share = min(1.0, float(dropped.probability[is_wanted].sum()))
    if 0.0 < share < 1.0:
        scatter = dropped.scatter(is_wanted.astype(np.float64))
        drops *= share * (1.0 - share) / scatter if scatter else math.inf
    return counted_share(share, drops)


def counted_share(share: float, drops: float) -> Bounded:
    """A share as if counted in so many drops; NaN where nothing is known of them."""
    if math.isnan(drops):
        return Bounded(share, math.nan, math.nan)
    if drops > CERTAIN_DROPS:
        return Bounded(share, share, share)
    low, high = map(float, jeffreys_interval(share * drops, drops))
    # Of less than a drop both ends are above the share.
    return Bounded(share, min(low, share), max(high, share))


def check_wanted_poses(wanted_poses: Sequence[int], poses: int) -> Mask:
    """Which of all poses (K,) are accepted."""
    indices: list[Any] = (
        list(wanted_poses) if np.ndim(wanted_poses) == 1 else [wanted_poses]
    )
    invalid_indices = [
        index
        for index in indices
        if not is_whole_number(index) or not 0 <= index < poses
    ]
    if invalid_indices or not indices:
        raise RequestError(
            f"wanted poses out of 0 to {poses - 1}, at least one",
            f"{invalid_indices[0]!r}" if invalid_indices else "none",
            "they are the `index` of the poses; `ros_pose_stats estimate` lists them",
        )
    is_wanted = np.zeros(poses, dtype=np.bool_)
    is_wanted[indices] = True
    return is_wanted


def check_rate(rate: float, cycle_time: float) -> None:
    """Refuse a rate of drops, and a time from kick to kick, that is none."""
    if not 0.0 < rate < math.inf:
        raise RequestError(
            "a rate above 0 parts a minute",
            f"{rate}",
            "count the parts that are dropped, those sent back included",
        )
    if not 0.0 <= cycle_time < math.inf:
        raise RequestError(
            "a cycle time of 0 s or more",
            f"{cycle_time}",
            "it is the time from one kick to the next",
        )


STRENGTHS = np.geomspace(3.0, 300.0, 9)
"""Flips that a row of the model may stand for, each as likely before any were counted:
a row that is 15 points off stands for some ten, one that is 5 points off for a
hundred."""


def learn_flips(
    kicks: Sequence[FlipStatistics], counts: ArrayLike, feeder_setting: str = ""
) -> FlipStatistics:
    """Combine flips counted at one setting of a feeder with those of the model.

    The kick height is that of the model's kicks which explains the counts best. Each
    row is a Dirichlet about that kick's row, which stands for as many flips as agrees
    with how far the counts are from it. Poses that look alike share what was counted
    out of and into them.

    Parameters
    ----------
    kicks : sequence of FlipStatistics
        Of the model, of one part and scene with its poses, at least one.
    counts : (K, K) array of int
        Row i: flips out of pose i, by the pose in which they ended; 0 or more.
    feeder_setting : str
        Name of the setting.

    Returns
    -------
    FlipStatistics
        `transition` has the means, `standard_error` theirs, and `counts` the flips as
        which each row is known, those of the model included; `counted_flips` is their
        number without these.

    Raises
    ------
    RequestError
        If the counts are not a whole number from 0 up from pose to pose, or there are
        no kicks.
    """
    if not kicks:
        raise RequestError(
            "flips of the model at one kick height or more", "none", "name kick heights"
        )
    check_alike(kicks)
    poses = kicks[0].counts.shape[0]
    flip_counts = _check_flips(counts, poses)
    groups = [pose.group for pose in kicks[0].poses]
    member = np.equal.outer(groups, sorted(set(groups))).astype(float)
    size = member.sum(axis=0)
    group_counts = member.T @ flip_counts @ member
    rows = [
        (kick.effective_counts + 0.5 / poses)
        / (kick.effective_counts.sum(axis=1) + 0.5)[:, None]
        for kick in kicks
    ]
    models = [member.T @ row @ member for row in rows]
    evidence = np.array([_evidence(model, group_counts, size) for model in models])
    best = int(np.logaddexp.reduce(evidence, axis=1).argmax())
    weight = np.exp(evidence[best] - evidence[best].max())
    strength = float(np.exp(weight @ np.log(STRENGTHS) / weight.sum()))

    group_flips = strength * models[best] + group_counts
    share_in_group = rows[best] / (rows[best] @ member @ member.T)
    total = group_flips.sum(axis=1)
    flips = np.asarray(total / size @ member.T)  # out of each pose, shared among twins
    group_shares = group_flips / total[:, None]
    group_errors = np.sqrt(group_shares * (1.0 - group_shares) / (total + 1.0)[:, None])
    transition = member @ group_shares @ member.T * share_in_group
    return replace(
        kicks[best],
        counts=flips[:, None] * transition,
        effective_counts=flips[:, None] * transition,
        transition=transition,
        unsettled=np.zeros_like(kicks[best].unsettled),
        standard_error=member @ group_errors @ member.T * share_in_group,
        feeder_setting=feeder_setting,
        counted_flips=int(flip_counts.sum()),
    )


def _check_flips(counts: ArrayLike, poses: int) -> Index:
    """Counts (K, K) as an array; raises RequestError if there are not K x K of them."""
    flip_counts = np.asarray(counts)
    if (
        flip_counts.shape != (poses, poses)
        or flip_counts.dtype.kind not in "iu"
        or (flip_counts < 0).any()
    ):
        raise RequestError(
            f"{poses} rows of {poses} whole numbers from 0 up, a row a pose",
            f"{flip_counts}",
            "count the flips from pose to pose, by their index",
        )
    return flip_counts


def check_alike(results: Sequence[PoseStatistics | FlipStatistics]) -> None:
    """Refuse results that are not about the same poses of the same part."""
    numberings = {
        (result.part_digest, result.cluster_tolerance, result.round_sides)
        for result in results
    }
    if len(numberings) > 1:
        raise RequestError(
            "results of one part and its poses",
            text.listed(sorted({result.part_id for result in results})),
            "simulate all of them with the same part, cluster tolerance and "
            "round sides",
        )


def _evidence(model: Array, group_counts: Array | Index, size: Array) -> Array:
    """Log likelihoods (S,) of counts between groups, at each strength of a model.

    `model` (G, G): shares, summed over the poses of a group, of which there are `size`
    (G,).
    """
    row, column = np.nonzero(group_counts)
    prior = STRENGTHS[:, None] * model[row, column]
    total = STRENGTHS[:, None] * size
    cells = gammaln(prior + group_counts[row, column]) - gammaln(prior)
    rows = gammaln(total) - gammaln(total + group_counts.sum(axis=1))
    return np.asarray(cells.sum(axis=1) + rows.sum(axis=1))
