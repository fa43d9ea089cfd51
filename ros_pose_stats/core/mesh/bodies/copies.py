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

"""Whether one body is another one, moved and turned but not mirrored."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from ...records import Array
from .. import vectors

SAME = 2e-4
"""Distance of corners, in radii of the body, by which copies may be off: text files
have six digits of the distance from the origin."""

_MOST_TURNS = 20_000  # turns tried until bodies count as different

_SAMPLE = 32  # corners that are looked at before all are


def is_copy(first: Array, second: Array) -> bool:
    """Whether a rotation takes the corners (V, 3) of one body to those of another."""
    if len(first) != len(second):
        return False
    first = first - first.sum(axis=0) / len(first)
    second = second - second.sum(axis=0) / len(second)
    size = float(vectors.lengths(first).max())
    if size == 0.0:
        return False
    first = first / size
    second = second / size
    radii = np.sort(vectors.lengths(first)) - np.sort(vectors.lengths(second))
    if np.abs(radii).max() > SAME:
        return False
    # Copies are mostly written corner by corner in the same order.
    turned = vectors.turn_vectors(first, _best_turn(first, second))
    if vectors.lengths(turned - second).max() <= SAME:
        return True
    neighbours = cKDTree(second)
    sample = np.random.default_rng(0).integers(len(first), size=_SAMPLE)
    for turn in _likely_turns(first, second):
        if all(
            # The turn is off by what its two corners are.
            neighbours.query(vectors.turn_vectors(points, turn))[0].max() <= 4.0 * SAME
            for points in (first[sample], first)
        ):
            return True
    return False


def _best_turn(first: Array, second: Array) -> Array:
    """Rotation (3, 3), for rows, that takes points nearest to others of their order.

    Kabsch, A solution for the best rotation to relate two sets of vectors (1976).
    """
    left, _, right = np.linalg.svd((first[:, :, None] * second[:, None]).sum(axis=0))
    hand = np.sign(np.linalg.det(left) * np.linalg.det(right))
    return np.asarray((left * [1.0, 1.0, hand]) @ right)


def _likely_turns(first: Array, second: Array) -> Iterator[Array]:
    """Rotations, for rows, that take two corners to two others at their distances."""
    radius = vectors.lengths(first)
    radius_there = vectors.lengths(second)
    # The fewest others are as far out as the first corner, and some are as far as a
    # corner across it.
    sorted_radii = np.sort(radius_there)
    rivals = np.searchsorted(sorted_radii, radius + SAME) - np.searchsorted(
        sorted_radii, radius - SAME
    )
    start = int(np.where(radius > 0.5, rivals, len(first)).argmin())
    end = int(vectors.lengths(vectors.cross(first, first[start])).argmax())
    frame = _frame(first[start], first[end])
    distance = vectors.length(first[end] - first[start])
    turns = 0
    for start_there in np.flatnonzero(np.abs(radius_there - radius[start]) <= SAME):
        distances = vectors.lengths(second - second[start_there])
        is_likely = (np.abs(radius_there - radius[end]) <= SAME) & (
            np.abs(distances - distance) <= 2.0 * SAME
        )
        for end_there in np.flatnonzero(is_likely):
            yield frame.T @ _frame(second[start_there], second[end_there])
            turns += 1
            if turns == _MOST_TURNS:
                return


def _frame(first: Array, second: Array) -> Array:
    """Right-handed unit axes, as rows: along a vector, across both, and across these.

    Zeros where both are along each other.
    """
    across = vectors.cross(first, second)
    return vectors.unit_vectors(np.stack((first, across, vectors.cross(first, across))))
