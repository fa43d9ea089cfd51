"""Parts that were counted on a plate: which part, and how many lay in each of its poses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import RequestError
from ..records import Part
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES
from ..resting.poses import RestingPoses, resting_poses

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CountedPart:
    """Counts of one part."""

    part: Part
    count: Index  # (P,) int; parts seen in each pose, by `index`
    cluster_tolerance: float
    round_sides: int  # by which the poses are numbered

    @property
    def resting(self) -> RestingPoses:
        """Its stable poses."""
        return resting_poses(self.part, self.cluster_tolerance, self.round_sides)

    @property
    def counted(self) -> int:
        """Parts seen in all poses together."""
        return int(self.count.sum())

    @property
    def by_group(self) -> Index:
        """Parts (G,) in each group of poses that look alike; only these tell of a plate."""
        found: Index = np.bincount(self.resting.group, self.count).astype(np.int64)
        return found

    @property
    def free_shares(self) -> int:
        """Groups less one: the numbers that its counts can tell."""
        return self.by_group.size - 1


def count_part(part: Part, counts: Mapping[int, int], *,
               cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
               round_sides: int = DEFAULT_ROUND_SIDES) -> CountedPart:
    """Join a part and what was counted of it.

    `counts`: from the `index` of a pose to the parts seen in it; 0 for those left out;
    `cluster_tolerance, round_sides`: as of the statistics that numbered the poses. Raises
    RequestError if the part has no such pose, or a count is negative.
    """
    poses = len(resting_poses(part, cluster_tolerance, round_sides).poses)
    count = np.zeros(poses, dtype=np.int64)
    for index, number in counts.items():
        if not 0 <= index < poses:
            raise RequestError(f"poses 0 to {poses - 1} of {part.part_id}", f"{index}",
                               "count with the numbers that estimate shows, at the same cluster "
                               "tolerance and round sides")
        if number < 0:
            raise RequestError("counts of at least 0", f"{number} of {part.part_id} in pose "
                               f"{index}", "give the parts seen in each pose")
        count[index] = number
    return CountedPart(part, count, cluster_tolerance, round_sides)


def merge_counts(counted: Iterable[CountedPart]) -> tuple[CountedPart, ...]:
    """Add up counts of the same part with equally numbered poses, in order of appearance."""
    found: dict[tuple[str, float, int], CountedPart] = {}
    for one in counted:
        key = one.part.digest, one.cluster_tolerance, one.round_sides
        known = found.get(key)
        found[key] = one if known is None else CountedPart(
            known.part, known.count + one.count, one.cluster_tolerance, one.round_sides)
    return tuple(found.values())
