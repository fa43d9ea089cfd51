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

"""What a part is to do: rest in some poses, or in each as often as wanted.

Both are one measure. Poses are put into classes, each with a wanted share, and a part
meets its goal by the sum over the classes of its share or the wanted one, whichever is
smaller: 1 less the total variation distance of both. With one class, of share 1, that
is the share of the wanted poses.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import RequestError
from ...base.text import name_poses
from ...core.records import Array, Index, Mask
from ...core.records.scene import real_number
from ...core.statistics import feeding
from ...core.statistics.errors import DEFAULT_LEVEL
from ...core.statistics.pose_groups import PoseShares
from .paired_drops import PairedDifference, count_share, paired_difference

Wanted = Sequence[int] | Mapping[Any, float]
"""Indices of wanted poses; or from each index, or from several, to the wanted share."""

SUM_TOLERANCE = 0.005
"""By which wanted shares may miss their sum, as a share of it: 33.3 thrice."""

NEAR = 2.0
"""Standard errors between a counted share and the wanted one, below which either may be
the larger one: the interval of a gain then holds for both."""

ROUNDING = 1e-12  # by which shares of all poses may be more than all


class Goal(NamedTuple):
    """Classes of poses with their wanted shares."""

    class_of_pose: Index  # (P,); 0 for poses that are not wanted
    shares: Array  # (C,); wanted share of each class, 0 for class 0; their sum is 1

    @property
    def has_shares(self) -> bool:
        """Whether it is about shares of several classes, not about one sum."""
        return self.shares.size > 2

    @property
    def wanted_poses(self) -> tuple[int, ...]:
        """Poses that are wanted at all, rising."""
        return tuple(np.flatnonzero(self.class_of_pose).tolist())

    def poses(self, number: int) -> tuple[int, ...]:
        """Poses of a class, rising."""
        return tuple(np.flatnonzero(self.class_of_pose == number).tolist())

    def describe(self) -> str:
        """In words: poses 0, 3, or shares of 3 sets of poses."""
        if self.has_shares:
            return f"shares of {self.shares.size - 1} sets of poses"
        return name_poses(self.wanted_poses)

    def is_kept(self, images: Index) -> bool:
        """Whether poses may change places with their images (P,) and it is the same."""
        pairs = np.unique(
            np.stack((self.class_of_pose, self.class_of_pose[images])), axis=1
        )
        return pairs.shape[1] == np.unique(pairs[0]).size == np.unique(
            pairs[1]
        ).size and np.allclose(self.shares[pairs[0]], self.shares[pairs[1]])

    def class_shares(self, probability: Array) -> Array:
        """Share of each class (C,), from the probabilities (P,) of the poses."""
        return np.bincount(
            self.class_of_pose, probability, minlength=self.shares.size
        ).astype(np.float64)

    def fulfilment(self, class_shares: Array) -> float:
        """How far shares (C,) meet the goal, 0 to 1."""
        return float(np.minimum(class_shares, self.shares).sum())

    def estimated_fulfilment(self, estimate: PoseShares) -> feeding.Bounded:
        """How far an estimate meets the goal, with its 90 % interval."""
        is_rare = self._is_rare(self.class_shares(estimate.probability))
        poses = np.flatnonzero(is_rare[self.class_of_pose])
        return self._with_full(feeding.accepted_share(estimate, poses), is_rare)

    def counted_fulfilment(self, classes: Index) -> feeding.Bounded:
        """How far drops that ended in these classes (n,) meet the goal."""
        is_rare = self._is_rare(self._counted_shares(classes))
        return self._with_full(count_share(is_rare[classes]), is_rare)

    def gain(
        self, before: Index, after: Index, level: float = DEFAULT_LEVEL
    ) -> PairedDifference:
        """By how much a change brings a part nearer to the goal.

        `before`, `after`: classes (n,) in which drops from the same starts ended;
        `level`: of the interval.
        """
        shares_before = self._counted_shares(before)
        shares_after = self._counted_shares(after)
        rare_before = self._is_rare(shares_before)
        rare_after = self._is_rare(shares_after)
        # Where a share is about the wanted one, chance decides which counts, and is off
        # by as much as it moved the share.
        variance = self.shares * (1.0 - self.shares) / max(1, before.size)
        distance = np.minimum(
            np.abs(shares_before - self.shares), np.abs(shares_after - self.shares)
        )
        is_near = distance < NEAR * np.sqrt(variance)
        return paired_difference(
            rare_before[before],
            rare_after[after],
            level,
            float(self.shares[~rare_after].sum() - self.shares[~rare_before].sum()),
            float(variance[is_near].sum()),
        )

    def _is_rare(self, class_shares: Array) -> Mask:
        """Wanted classes (C,) of which more is wanted; the others count in full."""
        return (class_shares <= self.shares + ROUNDING) & (self.shares > 0.0)

    def _counted_shares(self, classes: Index) -> Array:
        counts = np.bincount(classes, minlength=self.shares.size)
        return counts / max(1, classes.size)

    def _with_full(self, rare: feeding.Bounded, is_rare: Mask) -> feeding.Bounded:
        """The share of the rare classes and what is wanted of the others."""
        full = float(self.shares[~is_rare].sum())
        # NaN stays.
        return feeding.Bounded(*np.minimum(1.0, np.array(rare) + full).tolist())


def find_goal(wanted: Wanted, poses: int) -> Goal:
    """The goal of a part with so many poses; raises RequestError where it is none."""
    if isinstance(wanted, Mapping):
        return _goal_of_shares(wanted, poses)
    is_wanted = feeding.check_wanted_poses(wanted, poses)
    return Goal(is_wanted.astype(np.int64), np.array([0.0, 1.0]))


def _goal_of_shares(wanted: Mapping[Any, Any], poses: int) -> Goal:
    class_of_pose = np.full(poses, -1, dtype=np.int64)
    shares = [0.0]
    for pose_or_poses, share in wanted.items():
        indices = pose_or_poses if np.ndim(pose_or_poses) else [pose_or_poses]
        is_named = feeding.check_wanted_poses(indices, poses)
        twice = np.flatnonzero(is_named & (class_of_pose >= 0))
        if twice.size:
            raise RequestError(
                "one share for each pose",
                f"two for pose {twice[0]}",
                "name each pose once",
            )
        number = real_number("a wanted share", share)
        if not 0.0 <= number < math.inf:
            raise RequestError(
                "wanted shares from 0", f"{share!r}", "1, or 100 for per cent, is all"
            )
        class_of_pose[is_named] = len(shares) if number else 0
        shares += [number] if number else []
    unnamed = np.flatnonzero(class_of_pose < 0).tolist()
    if unnamed:
        raise RequestError(
            f"a wanted share for each of the poses 0 to {poses - 1}",
            f"none for {name_poses(unnamed)}",
            "`ros_pose_stats estimate` lists the poses; give 0 to those not wanted",
        )
    total = sum(shares)
    if not any(abs(total - whole) <= SUM_TOLERANCE * whole for whole in (1.0, 100.0)):
        raise RequestError(
            "wanted shares with the sum 1, or 100 for per cent",
            f"a sum of {total:.6g}",
            "change the shares so that they are all there is",
        )
    return Goal(class_of_pose, np.array(shares) / total)
