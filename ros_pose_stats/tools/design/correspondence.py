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

"""Which poses of two variants are the same: like footprints on the same side.

A variant may lie turned in the frame of its file: that is recognized and turned back.
Where frames do not match at all, footprint and height alone decide, and that is said.
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

SIZE_TOLERANCE = math.log(1.05)
SIZE_LIMIT = math.log(1.4)
"""Largest logarithm of the ratio of sizes that are nearly the same, and of
corresponding poses."""

NEAR_COSINE = math.cos(math.radians(5.0))
WIDEST_ANGLE = math.radians(20.0)
"""Of directions down that are nearly the same the least cosine; of corresponding poses
the largest angle."""

ALIKE_SHARE = 0.75
FEWEST_ALIKE = 3
"""Share of the poses, and number of them, that a changed part must have nearly as
before for it to be found turned in its file; as it lies there, no more than half as
many."""

SURFACE_TOLERANCE = 0.003
INERTIA_TOLERANCE = 0.02
"""Distance between the surfaces of two exports of one body, in radii: a circle of 48
sides; and difference between their inertias, as a share of it."""

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

    # (P,); pose of the second variant that each of the first is; -1 for none
    partner: Index
    # each pose of both is in one of them; pairs first, by the index in the first
    # variant
    matches: tuple[MatchedPoses, ...]
    # (3, 3); takes directions of the first frame to the second's; None where they are
    # equal
    turn: Array | None
    # whether the second variant is the first one, turned in its file, and nothing else
    same_body: bool
    # whether sides were told apart; else footprints and heights alone were
    by_orientation: bool

    @property
    def angle(self) -> float:
        """By how much the second variant is turned in its file, radians."""
        if self.turn is None:
            return 0.0
        cosine = 0.5 * (float(np.trace(self.turn)) - 1.0)
        return math.acos(min(1.0, max(-1.0, cosine)))

    def follow(self, poses: tuple[int, ...]) -> MatchedPoses:
        """Some poses of the first variant, and what they are in the second, rising."""
        partners = np.unique(self.partner[list(poses)])
        return MatchedPoses(poses, tuple(partners[partners >= 0].tolist()))


def find_correspondence(first: RestingPoses, second: RestingPoses) -> Correspondence:
    """Find which poses of two variants correspond, numbered alike."""
    turn, same_body = find_turn(first, second)
    # A round side rests on any of its facets, which another export has elsewhere: the
    # smallest angle between the directions down of any members counts.
    downs = first.equilibria.downs if turn is None else first.equilibria.downs @ turn.T
    cosine = np.full((len(first.poses), len(second.poses)), -1.0)
    for number, pose in enumerate(second.poses):
        nearest = (downs @ second.equilibria.downs[list(pose.members)].T).max(axis=1)
        np.maximum.at(cosine[:, number], first.clusters.pose, nearest)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    footprint = _size_ratios(first, second, FOOTPRINT)
    is_near = (angle <= WIDEST_ANGLE) & (footprint <= SIZE_LIMIT)
    partner = _match_poses(
        np.where(is_near, angle / WIDEST_ANGLE + footprint / SIZE_LIMIT, np.inf)
    )
    by_orientation = 2 * np.count_nonzero(partner >= 0) >= min(is_near.shape)
    if not by_orientation:
        ratio = _size_ratios(first, second)
        partner = _match_poses(np.where(ratio <= SIZE_TOLERANCE, ratio, np.inf))
    return Correspondence(
        partner,
        _join_lookalikes(first, second, partner),
        turn,
        same_body,
        bool(by_orientation),
    )


def find_turn(first: RestingPoses, second: RestingPoses) -> tuple[Array | None, bool]:
    """Rotation from the first frame to the second, and whether the bodies are equal.

    The rotation is None where the frames are equal.

    A centre of mass that was moved to the other side of a symmetric part is a change,
    not a turn.
    """
    directions = random_starts(1, 0, DIRECTIONS)
    first_heights = first.body.R(directions)

    def surface_distance(turn: Array) -> Array:
        """Distance between the surfaces once the first is turned, in radii."""
        return first_heights - second.body.R(directions @ turn.T) * (
            second.body.radius / first.body.radius
        )

    distance = surface_distance(np.eye(3))
    shifted = directions @ np.linalg.lstsq(directions, distance, rcond=None)[0]
    if np.abs(distance - shifted).max() <= SURFACE_TOLERANCE:
        return None, False
    footprint = _size_ratios(first, second, FOOTPRINT) <= SIZE_TOLERANCE

    def count_alike(turn: Array) -> int:
        """Poses of the first that the second has likewise, once the first is turned."""
        cosine = first.downs @ turn.T @ second.downs.T
        return int((footprint & (cosine >= NEAR_COSINE)).any(axis=1).sum())

    turns = [np.eye(3), *_candidate_turns(first, second)]
    alike_poses = [count_alike(turn) for turn in turns]
    most_alike = max(alike_poses)
    # Surfaces take longer to compare, so only those of the best turns are.
    best_turns = [
        turn
        for turn, alike in zip(turns, alike_poses, strict=True)
        if alike == most_alike
    ]
    misfits = [float(np.abs(surface_distance(turn)).max()) for turn in best_turns]
    misfit = min(misfits)
    turn = best_turns[misfits.index(misfit)]
    first_inertia = first.body.radius**2 * (turn @ first.inertia @ turn.T)
    second_inertia = second.body.radius**2 * second.inertia
    same_body = misfit <= SURFACE_TOLERANCE and (
        np.abs(first_inertia - second_inertia).max()
        <= INERTIA_TOLERANCE * np.abs(first_inertia).max()
    )
    needed_poses = max(
        FEWEST_ALIKE,
        ALIKE_SHARE * min(len(first.poses), len(second.poses)),
        2 * alike_poses[0],
    )
    if same_body or most_alike >= needed_poses:
        return turn, bool(same_body)
    return None, False


def _candidate_turns(first: RestingPoses, second: RestingPoses) -> Iterator[Array]:
    """Rotations that lay the two most special poses on two of the second variant."""
    is_same_size = _size_ratios(first, second) <= SIZE_TOLERANCE
    equals = is_same_size.sum(axis=1)
    downs = first.downs
    other_downs = second.downs
    order = np.argsort(
        np.where(equals > 0, equals, len(other_downs) + 1), kind="stable"
    )
    lead = order[0]
    oblique = order[np.linalg.norm(np.cross(downs[lead], downs[order]), axis=1) > 0.1]
    if not oblique.size:
        return
    follower = oblique[0]
    alike = np.abs(downs[lead] @ downs[follower] - other_downs @ other_downs.T) <= 0.05
    pairs = np.argwhere(
        alike & is_same_size[lead][:, None] & is_same_size[follower][None]
    )
    for lead_image, follower_image in pairs[:MOST_TURNS].tolist():
        yield (
            _plane_frame(other_downs[lead_image], other_downs[follower_image])
            @ _plane_frame(downs[lead], downs[follower]).T
        )


def _plane_frame(first: Array, second: Array) -> Array:
    """Orthonormal columns: along one vector, in its plane with another, across."""
    normal = np.cross(first, second)
    normal = normal / np.linalg.norm(normal)
    return np.stack((first, np.cross(normal, first), normal), axis=1)


def _size_ratios(
    first: RestingPoses, second: RestingPoses, sizes: slice = slice(None)
) -> Array:
    """Largest logarithm (P, Q) of the ratio of two poses' sizes, all of them lengths.

    They are those of the outline's area, its girth, the highest point and the height.
    """
    first_sizes, second_sizes = (
        np.log(
            [
                (math.sqrt(area), girth, pose.top, pose.height)
                for pose in resting.poses
                for area, girth in [area_and_length(pose.outline)]
            ]
        )
        for resting in (first, second)
    )
    return np.asarray(
        np.abs(first_sizes[:, None, sizes] - second_sizes[None, :, sizes]).max(axis=2)
    )


def _join_lookalikes(
    first: RestingPoses, second: RestingPoses, partner: Index
) -> tuple[MatchedPoses, ...]:
    """Join pairs whose poses are alike in both variants, and poses without partner."""
    partnerless = np.setdiff1d(range(len(second.poses)), partner).tolist()
    pairs = np.array([*enumerate(partner), *((-1, pose) for pose in partnerless)])
    # The index -1, no pose, is that of the group -1 behind the others.
    groups = np.stack(
        (
            np.append(first.group, -1)[pairs[:, 0]],
            np.append(second.group, -1)[pairs[:, 1]],
        ),
        axis=1,
    )
    matches = []
    for pair_of_groups in np.unique(groups, axis=0):
        joined_pairs = pairs[(groups == pair_of_groups).all(axis=1)]
        first_poses, second_poses = (
            tuple(np.unique(side[side >= 0]).tolist()) for side in joined_pairs.T
        )
        matches.append(MatchedPoses(first_poses, second_poses))
    return tuple(
        sorted(
            matches,
            key=lambda match: (
                not match.is_pair,
                not match.first,
                match.first or match.second,
            ),
        )
    )


def _match_poses(cost: Array) -> Index:
    """Partner (P,) of each pose in the second variant, the cheapest first, or -1."""
    partner = np.full(cost.shape[0], -1, dtype=np.int64)
    for cell in np.argsort(cost, axis=None, kind="stable").tolist():
        pose, partner_pose = divmod(cell, cost.shape[1])
        if not math.isfinite(cost[pose, partner_pose]):
            break
        if partner[pose] < 0 and partner_pose not in partner:
            partner[pose] = partner_pose
    return partner
