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

"""Versions of a part as it is saved, and what is different from one to the next.

Poses are followed from version to version by their shape, as in a comparison. Each has
a key that stays, whatever its number in a version.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from ...base.text import name_poses
from ...core.records import Part, PoseStatistics
from ...core.resting.poses import RestingPoses
from ...core.statistics.feeding import (
    Bounded,
    check_wanted_poses,
    share_of_poses,
)
from ...core.statistics.pose_groups import pose_groups
from ..design.correspondence import find_correspondence

MOST_KEPT = 1000
"""Versions of which the history keeps the share: a day's work."""


@dataclass(frozen=True, eq=False)
class Version:
    """A part as it was saved."""

    number: int  # from 1 on
    saved: str  # time of day
    part: Part
    resting: RestingPoses
    keys: tuple[int, ...]  # of the poses by their index
    estimate: PoseStatistics  # at once
    answer: PoseStatistics  # the same, or with the drops so far

    def poses_of(self, keys: Sequence[int]) -> tuple[int, ...]:
        """Indices of the poses that have some keys, rising."""
        return tuple(index for index, key in enumerate(self.keys) if key in keys)


class Change(NamedTuple):
    """What is different in a version from an earlier one."""

    before: Version
    shares: tuple[Bounded, Bounded]  # of the wanted poses, before and after
    new: tuple[int, ...]  # poses that were not there, by their numbers now
    gone: tuple[int, ...]  # poses that are not there, by their numbers before

    @property
    def is_sure(self) -> bool:
        """Whether the shares differ by more than both their errors together.

        Errors of the estimate of two like parts are alike, so this is careful.
        """
        before, after = self.shares
        error = math.hypot(before.high - before.low, after.high - after.low)
        return 2.0 * abs(after.value - before.value) > error

    def __str__(self) -> str:
        """In words, without what the share is of: "40.4 -> 46.9 %, pose 5 gone"."""
        before, after = (100.0 * share.value for share in self.shares)
        words = [f"{before:.1f} -> {after:.1f} %"]
        if f"{before:.1f}" != f"{after:.1f}" and not self.is_sure:
            words[0] += " (within the error)"
        if self.new:
            verb = "is" if len(self.new) == 1 else "are"
            words.append(f"{name_poses(self.new)} {verb} new")
        if self.gone:
            words.append(f"{name_poses(self.gone)} gone")
        return ", ".join(words)


class History:
    """All versions since the start: the first one, the last two, and their shares.

    `wanted`: poses of the first version that a feeder accepts; none for those that come
    up most often.
    """

    def __init__(self, wanted: Sequence[int]) -> None:
        self.has_feeder = bool(wanted)
        self._wanted = tuple(wanted)
        self.wanted_keys: tuple[int, ...] = ()
        self.start: Version | None = None
        self.previous: Version | None = None
        self.current: Version | None = None
        self.shares: list[Bounded] = []  # of the wanted poses, the last versions
        self._next_key = 0

    @property
    def subject(self) -> str:
        """What the share is of."""
        if self.has_feeder:
            return "accepted"
        return f"in {name_poses(self.wanted_keys)}"  # numbers of the first version

    def add(
        self, part: Part, resting: RestingPoses, estimate: PoseStatistics, saved: str
    ) -> Version:
        """Add a version; RequestError where the first lacks a wanted pose."""
        if self.start is None:
            wanted = self._wanted or pose_groups(estimate)[0].indices
            check_wanted_poses(wanted, len(resting.poses))
            self.wanted_keys = tuple(sorted(set(wanted)))
        keys = self._trace_poses(resting)
        number = 1 if self.current is None else self.current.number + 1
        version = Version(number, saved, part, resting, keys, estimate, estimate)
        self.start = self.start or version
        self.previous = self.current
        self.current = version
        self.shares = [*self.shares[1 - MOST_KEPT :], self.share(version, estimate)]
        return version

    def _trace_poses(self, resting: RestingPoses) -> tuple[int, ...]:
        """Keys of the poses of the next version.

        A pose that was lost for a while is known again from the first version.
        """
        keys = [-1] * len(resting.poses)
        versions = [] if self.current is None else [self.current]
        if self.start is not None and set(self.start.keys) - set(versions[0].keys):
            versions.append(self.start)
        for version in versions:
            partners = find_correspondence(version.resting, resting).partner.tolist()
            for key, pose in zip(version.keys, partners, strict=True):
                if pose >= 0 and keys[pose] < 0 and key not in keys:
                    keys[pose] = key
        for pose, key in enumerate(keys):
            if key < 0:
                keys[pose] = self._next_key
                self._next_key += 1
        return tuple(keys)

    def sharpen(self, answer: PoseStatistics) -> None:
        """Take an answer with more drops for the present version."""
        if self.current is None:
            return
        sharper = replace(self.current, answer=answer)
        if self.start is self.current:
            self.start = sharper
        self.current = sharper
        self.shares[-1] = self.share(sharper, answer)

    def share(self, version: Version, statistics: PoseStatistics) -> Bounded:
        """Share of the wanted poses in a version, by some statistics of it."""
        return share_of_poses(statistics, version.poses_of(self.wanted_keys))

    def change_since(self, before: Version) -> Change | None:
        """What is different now; None where the version is the present one.

        Like is set beside like: drops beside drops, else both estimates.
        """
        after = self.current
        if after is None or after.number == before.number:
            return None
        pairs = [(version, version.estimate) for version in (before, after)]
        if before.answer.drops and after.answer.drops:
            pairs = [(version, version.answer) for version in (before, after)]
        first, second = (self.share(*pair) for pair in pairs)
        return Change(
            before,
            (first, second),
            after.poses_of(tuple(set(after.keys) - set(before.keys))),
            before.poses_of(tuple(set(before.keys) - set(after.keys))),
        )
