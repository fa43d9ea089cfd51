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

"""What of a surface faces a direction, and where it ends.

Seen along that direction, the triangles that face it cover what the body covers: its
shadow.
"""

import numpy as np

from ..array_types import Array, Fixed1, Fixed2, FixedIndex2, Index
from ..compilation import entry_kernel, kernel
from ..vectors import (
    Vec3,
    area_vector,
    cross,
    dot,
    length,
    read_vector,
    subtract,
    triangle_at,
)
from .connections import triangle_neighbours

FLAT = 1e-4
"""Angle in radians between triangles of one plane: float32 tilts small ones so far."""


@entry_kernel
def neighbours_across(points: Fixed2, triangles: FixedIndex2) -> tuple[Index, float]:
    """Triangle (T, 3) across the side opposite to each vertex; -1 unless two meet.

    Behind it the share of the area that is folded: where a face with a bay was cut into
    a fan from a corner that does not see all of it, triangles lie on each other. Those
    beside a needle are neighbours, too; where needles meet, nothing is known of them.
    """
    neighbours = triangle_neighbours(triangles)
    total = 0.0
    folded = 0.0
    for t in range(triangles.shape[0]):
        own = area_vector(*triangle_at(points, triangles, t))
        total += length(own)
        if _is_needle(points, triangles, t):
            folded += _folded_beside(points, triangles, neighbours[t])
        for i in range(3):
            if neighbours[t, i] > t:
                other = area_vector(*triangle_at(points, triangles, neighbours[t, i]))
                folded += _overlap(own, other)
    return neighbours, folded / total


@kernel
def _overlap(first: Vec3, second: Vec3) -> float:
    """By how much two triangles lie on each other at most, by their area vectors."""
    across = cross(first, second)
    along = dot(first, second)
    if along < 0.0 and dot(across, across) < FLAT * FLAT * along * along:
        return min(length(first), length(second))
    return 0.0


@kernel
def _is_needle(points: Array, triangles: Index, t: int) -> bool:
    """Whether a triangle is so thin that rounding turns it about its length."""
    first, second, third = triangle_at(points, triangles, t)
    longest = max(
        length(subtract(first, second)),
        length(subtract(second, third)),
        length(subtract(third, first)),
    )
    return length(area_vector(first, second, third)) < FLAT * longest * longest


@kernel
def _folded_beside(points: Array, triangles: Index, neighbours: Index) -> float:
    """The area that is folded across a needle, or may be across several."""
    folded = 0.0
    for i in range(3):
        for j in range(3):
            if i == j or neighbours[i] < 0 or neighbours[j] < 0:
                continue
            first = area_vector(*triangle_at(points, triangles, neighbours[i]))
            second = area_vector(*triangle_at(points, triangles, neighbours[j]))
            if _is_needle(points, triangles, neighbours[i]):
                folded += length(second)
            else:
                folded += 0.5 * _overlap(first, second)  # each pair comes twice
    return folded


@entry_kernel
def loops_facing(
    points: Fixed2, triangles: FixedIndex2, neighbours: FixedIndex2, direction: Fixed1
) -> tuple[Index, Index]:
    """Loops around the triangles that face a direction, the triangles on their left.

    Vertices, one loop after the other, and where each loop ends. `neighbours`: as
    above. A side that several triangles share may be in loops both ways.
    """
    begin, end = _sides_between(points, triangles, neighbours, direction)
    # Sides that begin at one vertex form a chain: the first in `head`, others behind.
    head = np.full(points.shape[0], -1, np.int64)
    following = np.empty(begin.shape[0], np.int64)
    for side in range(begin.shape[0] - 1, -1, -1):
        following[side] = head[begin[side]]
        head[begin[side]] = side
    corners = np.empty(begin.shape[0], np.int64)
    ends = np.empty(begin.shape[0], np.int64)
    count = loops = 0
    for first_side in range(begin.shape[0]):
        vertex = begin[first_side]
        if head[vertex] < 0:
            continue
        # As many sides end at a vertex as begin there, so that a walk ends at its
        # start, and none is left there.
        while head[vertex] >= 0:
            side = head[vertex]
            head[vertex] = following[side]
            corners[count] = vertex
            count += 1
            vertex = end[side]
        ends[loops] = count
        loops += 1
    return corners, ends[:loops].copy()


@kernel
def _sides_between(
    points: Array, triangles: Index, neighbours: Index, direction: Array
) -> tuple[Index, Index]:
    """Where the sides begin and end at which triangles that face a direction end."""
    axis = read_vector(direction, 0)
    is_facing = np.empty(triangles.shape[0], np.bool_)
    for t in range(triangles.shape[0]):
        is_facing[t] = dot(area_vector(*triangle_at(points, triangles, t)), axis) > 0.0
    count = 0
    for t in range(triangles.shape[0]):
        if is_facing[t]:
            for i in range(3):
                if neighbours[t, i] < 0 or not is_facing[neighbours[t, i]]:
                    count += 1
    begin = np.empty(count, np.int64)
    end = np.empty(count, np.int64)
    side = 0
    for t in range(triangles.shape[0]):
        if is_facing[t]:
            for i in range(3):
                if neighbours[t, i] < 0 or not is_facing[neighbours[t, i]]:
                    begin[side] = triangles[t, (i + 1) % 3]
                    end[side] = triangles[t, (i + 2) % 3]
                    side += 1
    return begin, end
