"""Which poses of two variants are the same: like footprints on the same side of the part.

A variant may lie turned in the frame of its file: that is recognized and turned back. Where frames
do not match at all, footprint and height alone decide, and that is said.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...core.records import Array, Index
from ...core.resting.outlines import area_and_length
from ...core.resting.poses import RestingPoses
from ...core.simulation.drops import random_starts

FOOTPRINT = slice(0, 3)  # what of a pose's sizes does not hang on the centre of mass

SAME_SIZE = math.log(1.05)
SCALED = math.log(1.4)
"""Largest logarithm of the ratio of sizes that are nearly the same, and of corresponding poses."""

NEARLY = math.cos(math.radians(5.0))
WIDEST = math.radians(20.0)
"""Of directions down that are nearly the same the least cosine; of corresponding poses the largest
angle."""

MOSTLY = 0.75
LEAST_ALIKE = 3
"""Share of the poses, and number of them, that a changed part must have nearly as before for it to
be found turned in its file; as it lies there, no more than half as many."""

SAME_BODY = 0.003
SAME_INERTIA = 0.02
"""Distance between the surfaces of two exports of one body, in radii: a circle of 48 sides; and
difference between their inertias, as a share of it."""

DIRECTIONS = 256  # in which surfaces are compared
MOST_TURNS = 200  # ways to turn one body into another that are tried


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

    partner: (
        Index  # (P,); pose of the second variant that each of the first is; -1 for none
    )
    # each pose of both is in one of them; pairs first, by the index in the first variant
    matches: tuple[MatchedPoses, ...]
    # (3, 3); takes directions of the first frame to the second's; None where they are equal
    turn: Array | None
    # whether the second variant is the first one, turned in its file, and nothing else
    same_body: bool
    by_orientation: (
        bool  # whether sides were told apart; else footprints and heights alone were
    )

    @property
    def angle(self) -> float:
        """By how much the second variant is turned in its file, radians."""
        return (
            0.0
            if self.turn is None
            else math.acos(
                min(1.0, max(-1.0, 0.5 * (float(np.trace(self.turn)) - 1.0)))
            )
        )

    def follow(self, poses: tuple[int, ...]) -> MatchedPoses:
        """Some poses of the first variant, and what they are in the second, rising."""
        return MatchedPoses(
            poses,
            tuple(sorted({int(one) for one in self.partner[list(poses)] if one >= 0})),
        )


def find_correspondence(first: RestingPoses, second: RestingPoses) -> Correspondence:
    """Find which poses of two variants correspond, at one cluster tolerance and round sides."""
    turn, same_body = find_turn(first, second)
    # A round side rests on any of its facets, which another export has elsewhere: the smallest
    # angle between the directions down of any members counts.
    downs = first.equilibria.downs if turn is None else first.equilibria.downs @ turn.T
    cosine = np.full((len(first.poses), len(second.poses)), -1.0)
    for other, pose in enumerate(second.poses):
        nearest = (downs @ second.equilibria.downs[list(pose.members)].T).max(axis=1)
        np.maximum.at(cosine[:, other], first.clusters.pose, nearest)
    apart = np.arccos(np.clip(cosine, -1.0, 1.0))
    footprint = _size_ratios(first, second, FOOTPRINT)
    near = (apart <= WIDEST) & (footprint <= SCALED)
    partner = _match(np.where(near, apart / WIDEST + footprint / SCALED, np.inf))
    by_orientation = 2 * np.count_nonzero(partner >= 0) >= min(near.shape)
    if not by_orientation:
        ratio = _size_ratios(first, second)
        partner = _match(np.where(ratio <= SAME_SIZE, ratio, np.inf))
    return Correspondence(
        partner,
        _join_alike(first, second, partner),
        turn,
        same_body,
        bool(by_orientation),
    )


def find_turn(first: RestingPoses, second: RestingPoses) -> tuple[Array | None, bool]:
    """Rotation from the first frame to the second, None if equal; whether both are the same body.

    A centre of mass that was moved to the other side of a symmetric part is a change, not a turn.
    """
    directions = random_starts(1, 0, DIRECTIONS)

    def apart(turn: Array) -> Array:
        """Distance between the surfaces once the first is turned, in radii."""
        return np.asarray(
            first.body.R(directions)
            - second.body.R(directions @ turn.T)
            * (second.body.radius / first.body.radius)
        )

    away = apart(np.eye(3))
    shifted = directions @ np.linalg.lstsq(directions, away, rcond=None)[0]
    if np.abs(away - shifted).max() <= SAME_BODY:
        return None, False
    footprint = _size_ratios(first, second, FOOTPRINT) <= SAME_SIZE
    ways = []
    for turn in (np.eye(3), *_turns(first, second)):
        near = (first.downs @ turn.T) @ second.downs.T >= NEARLY
        ways.append(
            (
                int((near & footprint).any(axis=1).sum()),
                float(np.abs(apart(turn)).max()),
                turn,
            )
        )
    alike, misfit, turn = max(ways, key=lambda way: (way[0], -way[1]))
    one = first.body.radius**2 * (turn @ first.inertia @ turn.T)
    other = second.body.radius**2 * second.inertia
    same_body = misfit <= SAME_BODY and (
        np.abs(one - other).max() <= SAME_INERTIA * np.abs(one).max()
    )
    enough = max(
        LEAST_ALIKE, MOSTLY * min(len(first.poses), len(second.poses)), 2 * ways[0][0]
    )
    return (turn, bool(same_body)) if same_body or alike >= enough else (None, False)


def _turns(first: RestingPoses, second: RestingPoses) -> Iterator[Array]:
    """Rotations that lay the two poses with the fewest equals on two of the second variant."""
    same = _size_ratios(first, second) <= SAME_SIZE
    equals = same.sum(axis=1)
    downs = first.downs
    others = second.downs
    order = np.argsort(np.where(equals > 0, equals, len(others) + 1), kind="stable")
    lead = int(order[0])
    aside = order[np.linalg.norm(np.cross(downs[lead], downs[order]), axis=1) > 0.1]
    if not aside.size:
        return
    along = int(aside[0])
    alike = np.abs(downs[lead] @ downs[along] - others @ others.T) <= 0.05
    pairs = np.argwhere(alike & same[lead][:, None] & same[along][None])
    for one, other in pairs[:MOST_TURNS].tolist():
        yield _frame(others[one], others[other]) @ _frame(downs[lead], downs[along]).T


def _frame(first: Array, second: Array) -> Array:
    """Orthonormal columns, the first along one vector, the second in its plane with another."""
    across = np.cross(first, second)
    across = across / np.linalg.norm(across)
    return np.stack((first, np.cross(across, first), across), axis=1)


def _size_ratios(
    first: RestingPoses, second: RestingPoses, which: slice = slice(None)
) -> Array:
    """Largest logarithm (P, Q) of the ratio of two poses' sizes, all of them lengths.

    They are those of the outline's area, its girth, the highest point and the height.
    """
    one, other = (
        np.log(
            [
                (math.sqrt(area), girth, pose.top, pose.height)
                for pose in resting.poses
                for area, girth in [area_and_length(pose.outline)]
            ]
        )
        for resting in (first, second)
    )
    return np.asarray(np.abs(one[:, None, which] - other[None, :, which]).max(axis=2))


def _join_alike(
    first: RestingPoses, second: RestingPoses, partner: Index
) -> tuple[MatchedPoses, ...]:
    """Join pairs whose poses are alike in both variants, and poses without a partner likewise."""
    joined: dict[tuple[int, int], tuple[list[int], list[int]]] = {}
    for one, other in [
        *enumerate(partner.tolist()),
        *(
            (-1, other)
            for other in np.setdiff1d(range(len(second.poses)), partner).tolist()
        ),
    ]:
        entry = joined.setdefault(
            (
                int(first.group[one]) if one >= 0 else -1,
                int(second.group[other]) if other >= 0 else -1,
            ),
            ([], []),
        )
        for side, index in zip(entry, (one, other), strict=True):
            if index >= 0:
                side.append(index)
    found = [
        MatchedPoses(tuple(one), tuple(sorted(other))) for one, other in joined.values()
    ]
    return tuple(
        sorted(
            found,
            key=lambda match: (
                not match.is_pair,
                not match.first,
                match.first or match.second,
            ),
        )
    )


def _match(cost: Array) -> Index:
    """Partner (P,) in the second variant of each pose, the cheapest first; -1 for none."""
    partner = np.full(cost.shape[0], -1, dtype=np.int64)
    for place in np.argsort(cost, axis=None, kind="stable").tolist():
        one, other = divmod(place, cost.shape[1])
        if not math.isfinite(cost[one, other]):
            break
        if partner[one] < 0 and other not in partner:
            partner[one] = other
    return partner
