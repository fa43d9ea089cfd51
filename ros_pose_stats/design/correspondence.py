"""Which poses of two variants of a part are the same pose.

Poses correspond where the same side of the part points down and the footprints are alike. A
variant may lie turned in the frame of its file: that is recognized and turned back. Where frames
do not match at all, footprint and height alone decide, and that is said.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..resting.poses import RestingPoses
from .turned_files import FOOTPRINT, SAME_SIZE, find_turn, size_ratios

Array = NDArray[np.float64]
Index = NDArray[np.int64]

WIDEST = math.radians(20.0)
"""Largest angle between the directions down of poses that correspond."""

SCALED = math.log(1.4)
"""Largest logarithm of the ratio of their footprints."""


class MatchedPoses(NamedTuple):
    """Poses of two variants that are the same, with those that symmetry makes alike."""

    # their indices, rising; one of them is empty for poses without a partner
    first: tuple[int, ...]
    second: tuple[int, ...]

    @property
    def is_pair(self) -> bool:
        """Whether the pose is there in both variants."""
        return bool(self.first and self.second)


@dataclass(frozen=True, eq=False)
class Correspondence:
    """How the poses of two variants correspond."""

    partner: Index  # (P,) int; pose of the second variant that each of the first is; -1 for none
    # each pose of both is in one of them; pairs first, by the index in the first variant
    matches: tuple[MatchedPoses, ...]
    # (3, 3); takes directions of the first variant's frame to the second's; None where they are
    # equal
    turn: Array | None
    # whether the second variant is the first one, turned in its file, and nothing else
    same_body: bool
    # whether sides of the part were told apart; else only footprints and heights were
    by_orientation: bool

    @property
    def angle(self) -> float:
        """By how much the second variant is turned in its file, radians."""
        if self.turn is None:
            return 0.0
        return math.acos(min(1.0, max(-1.0, 0.5 * (float(np.trace(self.turn)) - 1.0))))

    def partners(self, poses: Sequence[int]) -> tuple[int, ...]:
        """Poses of the second variant that some of the first are, rising."""
        return tuple(sorted({int(one) for one in self.partner[list(poses)] if one >= 0}))


def find_correspondence(first: RestingPoses, second: RestingPoses) -> Correspondence:
    """Find which poses of two variants correspond.

    `first, second`: at the same cluster tolerance and round sides.
    """
    turn, same_body = find_turn(first, second)
    apart, footprint = _angles(first, second, turn), size_ratios(first, second, FOOTPRINT)
    near = (apart <= WIDEST) & (footprint <= SCALED)
    partner = _match(np.where(near, apart / WIDEST + footprint / SCALED, np.inf))
    by_orientation = 2 * np.count_nonzero(partner >= 0) >= min(near.shape)
    if not by_orientation:
        ratio = size_ratios(first, second)
        partner = _match(np.where(ratio <= SAME_SIZE, ratio, np.inf))
    return Correspondence(partner, _join_alike(first, second, partner), turn, same_body,
                          bool(by_orientation))


def _join_alike(first: RestingPoses, second: RestingPoses, partner: Index
                ) -> tuple[MatchedPoses, ...]:
    """Join pairs whose poses are alike in both variants, and poses without a partner likewise."""
    joined: dict[tuple[int, int], tuple[list[int], list[int]]] = {}
    for one, other in enumerate(partner.tolist()):
        key = (int(first.group[one]), int(second.group[other]) if other >= 0 else -1)
        entry = joined.setdefault(key, ([], []))
        entry[0].append(one)
        if other >= 0:
            entry[1].append(other)
    for other in sorted(set(range(len(second.poses))) - set(partner.tolist())):
        joined.setdefault((-1, int(second.group[other])), ([], []))[1].append(other)
    found = [MatchedPoses(tuple(sorted(one)), tuple(sorted(other)))
             for one, other in joined.values()]
    return tuple(sorted(found, key=lambda match: (
        not match.is_pair, not match.first, match.first or match.second)))


def _match(cost: Array) -> Index:
    """Partner (P,) in the second variant of each pose, the cheapest first; -1 for none."""
    partner = np.full(cost.shape[0], -1, dtype=np.int64)
    taken = np.zeros(cost.shape[1], dtype=np.bool_)
    for place in np.argsort(cost, axis=None, kind="stable").tolist():
        one, other = divmod(place, cost.shape[1])
        if not math.isfinite(cost[one, other]):
            break
        if partner[one] < 0 and not taken[other]:
            partner[one], taken[other] = other, True
    return partner


def _angles(first: RestingPoses, second: RestingPoses, turn: Array | None) -> Array:
    """Smallest angle (P, Q) between the directions down of any members of two poses.

    A round side rests on any of its facets, which another export has elsewhere.
    """
    downs = first.equilibria.downs if turn is None else first.equilibria.downs @ turn.T
    cosine = np.full((len(first.poses), len(second.poses)), -1.0)
    for other, pose in enumerate(second.poses):
        nearest = (downs @ second.equilibria.downs[list(pose.members)].T).max(axis=1)
        np.maximum.at(cosine[:, other], first.clusters.pose, nearest)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))
