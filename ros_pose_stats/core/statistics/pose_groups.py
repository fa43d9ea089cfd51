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

"""Poses that symmetry makes alike: what a feeder or a camera sees as one pose.

Probabilities that were not counted are taken to be as uncertain as if counted in as
many drops as would leave their errors.
"""

import math
from collections.abc import Sequence, Set as AbstractSet
from typing import NamedTuple

import numpy as np

from ...base import errors, methods, text
from ..records import Array, Index, PoseStatistics, StablePose
from ..records.notes import Note, note
from ..records.poses import PoseGroup, single_poses
from ..records.shares import rank_probabilities
from .errors import jeffreys_interval

EQUIVALENCE_ROUNDS = 40  # each round halves the error of the logarithm


def pose_groups(statistics: PoseStatistics) -> tuple[PoseGroup, ...]:
    """Take poses that are alike together, the most probable first.

    The interval of several counted poses is that of the sum of their counts. Estimates
    and `hybrid` share one error evenly among the poses: their bounds add up to those of
    the sum.
    """
    groups: dict[int, list[StablePose]] = {}
    for pose in statistics.by_index.values():
        groups.setdefault(pose.group, []).append(pose)
    settled_drops = None
    if _has_counted_errors(statistics):
        settled_drops = sum(pose.count for pose in statistics.poses)
    joined_poses = [
        _join_poses(poses, settled_drops, len(groups)) for poses in groups.values()
    ]
    rank = rank_probabilities(group.probability for group in joined_poses)
    order = sorted(
        range(len(joined_poses)), key=lambda k: (rank[k], joined_poses[k].first.index)
    )
    return tuple(joined_poses[k] for k in order)


def _has_counted_errors(statistics: PoseStatistics) -> bool:
    """Whether the counts tell the errors; of the hull of an open solid they do not."""
    is_counted = statistics.method == methods.SIMULATION
    return is_counted and not math.isnan(statistics.expected_error)


def list_poses(statistics: PoseStatistics, ungrouped: bool) -> tuple[PoseGroup, ...]:
    """Each pose by itself, or those that are alike together."""
    return single_poses(statistics.poses) if ungrouped else pose_groups(statistics)


def _join_poses(
    poses: list[StablePose], settled_drops: int | None, groups: int
) -> PoseGroup:
    """Join poses, by rising index; the only group of a part is certain.

    `settled_drops`: None where the poses were not counted.
    """
    count = sum(pose.count for pose in poses)
    low = sum(pose.probability_low for pose in poses)
    high = sum(pose.probability_high for pose in poses)
    high = 1.0 if high > 1.0 else high  # NaN stays
    if settled_drops is not None and len(poses) > 1:
        if groups > 1:
            low, high = map(float, jeffreys_interval(count, settled_drops))
        else:
            low = high = 1.0
    probability = sum(pose.probability for pose in poses)
    return PoseGroup(tuple(poses), probability, low, high, count)


def warn_of_lookalikes(
    statistics: PoseStatistics, wanted_poses: Sequence[int]
) -> tuple[Note, ...]:
    """Warn where only some of the poses that look the same are wanted.

    By symmetry, or from above where it is known which do (`alike_from_above`).
    """
    wanted_indices = set(map(int, wanted_poses))
    return (
        *_warn_of_twins(statistics, wanted_indices),
        *_warn_of_silhouettes(statistics, wanted_indices),
    )


def _warn_of_twins(
    statistics: PoseStatistics, wanted_indices: set[int]
) -> tuple[Note, ...]:
    """Warn where the part's symmetry makes others the same as wanted poses."""
    sentences = []
    missing_poses: list[int] = []
    for group in sorted(group.indices for group in pose_groups(statistics)):
        wanted_twins = [index for index in group if index in wanted_indices]
        other_twins = [index for index in group if index not in wanted_indices]
        if wanted_twins and other_twins:
            verb = "looks" if len(other_twins) == 1 else "look"
            sentences.append(
                f"{text.name_poses(other_twins)} {verb} the same as "
                f"{text.name_poses(wanted_twins)}"
            )
            missing_poses += other_twins
    if not sentences:
        return ()

    shares = ""
    accepted_share = _summed_share(statistics, wanted_indices)
    if not math.isnan(accepted_share):
        possible_share = _summed_share(statistics, {*wanted_indices, *missing_poses})
        shares = (
            f": {100.0 * accepted_share:.1f} % are accepted, with them "
            f"{100.0 * possible_share:.1f} %"
        )
    verb = "is" if len(missing_poses) == 1 else "are"
    return (
        note(
            "WANTED_ALIKE",
            f"{text.listed(sentences)} (symmetry) and {verb} not among the wanted "
            f"ones{shares}.",
        ),
    )


def poses_mistaken(
    statistics: PoseStatistics, wanted_indices: AbstractSet[int]
) -> dict[int, list[int]]:
    """Wanted poses that each pose looks like from above which is not wanted.

    By the index of both. What symmetry makes alike is not mistaken: it is the same.
    """
    poses = statistics.by_index
    wanted_groups = {poses[index].group for index in wanted_indices}
    mistaken: dict[int, list[int]] = {}
    for pose in poses.values():
        lookalikes = wanted_indices & set(pose.alike_from_above or ())
        if lookalikes and pose.group not in wanted_groups:
            mistaken[pose.index] = sorted(lookalikes)
    return mistaken


def _warn_of_silhouettes(
    statistics: PoseStatistics, wanted_indices: set[int]
) -> tuple[Note, ...]:
    """Warn where a camera takes other poses for wanted ones."""
    mistaken = poses_mistaken(statistics, wanted_indices)
    if not mistaken:
        return ()
    others_like: dict[tuple[int, ...], list[int]] = {}
    for index, wanted in mistaken.items():
        others_like.setdefault(tuple(wanted), []).append(index)
    sentences = [
        f"{text.name_poses(others)} {'looks' if len(others) == 1 else 'look'} from "
        f"above like {text.name_poses(wanted)}"
        for wanted, others in others_like.items()
    ]
    share = _summed_share(statistics, set(mistaken))
    parts = "parts that lie so"
    if not math.isnan(share):
        parts = f"{100.0 * share:.1f} % of the parts"
    return (
        note(
            "ALIKE_FROM_ABOVE",
            f"{text.listed(sentences)} and {'is' if len(mistaken) == 1 else 'are'} not "
            f"wanted: by the silhouette alone {parts} would be picked wrongly.",
        ),
    )


def _summed_share(statistics: PoseStatistics, indices: set[int]) -> float:
    total = sum(pose.probability for pose in statistics.poses if pose.index in indices)
    return 1.0 if total > 1.0 else total  # NaN stays


class PoseShares(NamedTuple):
    """In which poses a dropped part comes to rest, and how sure that is."""

    probability: Array  # (K,); of the poses by their index
    # whose counts would be as uncertain; infinite where nothing is uncertain, NaN where
    # nothing is known about it
    drops: float
    # (K,) int; poses of one number, from 0 on, are equally probable by symmetry and
    # share one error
    unit: Index

    @property
    def shares(self) -> Array:
        """Probability of each unit."""
        return np.bincount(self.unit, self.probability).astype(np.float64)

    def by_unit(self, values: Array) -> Array:
        """Mean of a value of the poses (K,) over those of each unit."""
        return np.bincount(self.unit, values) / np.bincount(self.unit)

    def scatter(self, values: Array) -> float:
        """Variance of a value of the poses (K,) between the units, not within."""
        unit_values = self.by_unit(values)
        mean = float(self.shares @ unit_values)
        return max(0.0, float(self.shares @ (unit_values - mean) ** 2))


def pose_shares(statistics: PoseStatistics) -> PoseShares:
    """Probabilities of a result as feeding needs them.

    Of counted poses each has an error of its own, else those that are alike share one
    evenly.
    """
    probability = statistics.column("probability")
    if not np.isfinite(probability).all():
        raise errors.RequestError(
            "probabilities of the poses", "none", "simulate more drops"
        )
    if _has_counted_errors(statistics):
        drops = float(statistics.column("count").sum())
        return PoseShares(probability, drops, np.arange(probability.size))
    unit = np.unique(statistics.column("group"), return_inverse=True)[1]
    unit_errors = np.bincount(unit, statistics.column("standard_error")).astype(
        np.float64
    )
    certain = PoseShares(probability, math.inf, unit)
    return certain._replace(drops=equivalent_drops(certain.shares, unit_errors))


def equivalent_drops(shares: Array, errors: Array) -> float:
    """Drops n whose counts would have these errors; NaN where no errors are known.

    The sum of the squares of `standard_errors` is that of q (1 - q) / n, with q between
    the share and 1 / K, so that n stands on both sides; the mean of both converges.
    """
    scatter = float((errors * errors).sum())
    # Poses that symmetry makes alike are all there are.
    if scatter == 0.0 or shares.size == 1:
        return math.inf
    drops = 1.0 / scatter
    for _ in range(EQUIVALENCE_ROUNDS):
        q = (drops * shares + 0.5) / (drops + 0.5 * shares.size)
        # A share may have been rounded to above 1.
        spread = max(0.0, float((q * (1.0 - q)).sum()))
        drops = math.sqrt(drops * spread / scatter)
    return drops
