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

"""Upright lines through a closed surface, and how often their pieces are enclosed.

Lines stand where x and y are whole numbers, so that a triangle tells which of them
may pass it.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Fixed2, FixedIndex2
from ..compilation import entry_kernel, inlined
from ..sorting import rising_order, stable_order
from ..vectors import Vec3, triangle_at


class Edge(NamedTuple):
    """An edge from its lower vertex to its higher one.

    Both triangles at it are told the same, so that no line passes between them.
    """

    begin: Vec3
    end: Vec3
    forward: bool  # whether the triangle runs that way, counter-clockwise on its left


@entry_kernel
def count_pairs(points: Fixed2, triangles: FixedIndex2) -> int:
    """Pairs of a triangle and a line within the box around it."""
    pairs = 0
    for t in range(triangles.shape[0]):
        a, b, c = triangle_at(points, triangles, t)
        columns = _last_line(a.x, b.x, c.x) + 1 - _first_line(a.x, b.x, c.x)
        pairs += columns * (_last_line(a.y, b.y, c.y) + 1 - _first_line(a.y, b.y, c.y))
    return pairs


@entry_kernel
def enclosed_lengths(
    points: Fixed2, triangles: FixedIndex2, pairs: int, lines: int, shortest: float
) -> tuple[float, float]:
    """Length of the lines that is enclosed, and that twice or inside out.

    Each counts as often as it is enclosed, or wrongly so. `pairs`: as counted;
    `lines`: no line is as far along x or y; `shortest`: pieces are longer.
    """
    line = np.empty(pairs, np.int64)
    height = np.empty(pairs)
    sense = np.empty(pairs, np.int64)
    count = 0
    for t in range(triangles.shape[0]):
        a, b, c = triangle_at(points, triangles, t)
        i, j, k = triangles[t]
        ab = Edge(a, b, True) if i < j else Edge(b, a, False)
        bc = Edge(b, c, True) if j < k else Edge(c, b, False)
        ca = Edge(c, a, True) if k < i else Edge(a, c, False)
        for x in range(_first_line(a.x, b.x, c.x), _last_line(a.x, b.x, c.x) + 1):
            for y in range(_first_line(a.y, b.y, c.y), _last_line(a.y, b.y, c.y) + 1):
                sides = _inside(ab, x, y) + _inside(bc, x, y) + _inside(ca, x, y)
                if sides in (0, 3):
                    line[count] = x * lines + y
                    height[count] = _height(a, b, c, x, y)
                    sense[count] = 1 if sides == 3 else -1
                    count += 1
    by_height = stable_order(height[:count])
    order = by_height[rising_order(line[by_height])]
    total = 0.0
    wrong = 0.0
    enclosed = 0
    for i in range(count - 1):
        # A line that rises leaves the material where the surface faces up.
        enclosed -= sense[order[i]]
        length = height[order[i + 1]] - height[order[i]]
        if line[order[i + 1]] == line[order[i]] and length > shortest:
            total += abs(enclosed) * length
            wrong += abs(enclosed - (1 if enclosed != 0 else 0)) * length
    return total, wrong


@inlined
def _first_line(a: float, b: float, c: float) -> int:
    return math.ceil(min(a, min(b, c)))


@inlined
def _last_line(a: float, b: float, c: float) -> int:
    return math.floor(max(a, max(b, c)))


@inlined
def _inside(edge: Edge, x: int, y: int) -> int:
    """1 where a line passes an edge on the side of its triangle, else 0."""
    begin = edge.begin
    end = edge.end
    left = (end.x - begin.x) * (y - begin.y) - (end.y - begin.y) * (x - begin.x)
    return int((left > 0.0) == edge.forward)


@inlined
def _height(a: Vec3, b: Vec3, c: Vec3, x: int, y: int) -> float:
    """Height at which a line passes the plane of a triangle, within its corners."""
    area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
    # A triangle that stands almost upright gives noise here; its corners bound it.
    divisor = 1.0 if area == 0.0 else area
    s = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / divisor
    t = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / divisor
    height = a.z + s * (b.z - a.z) + t * (c.z - a.z)
    lowest = min(a.z, min(b.z, c.z))
    return min(max(height, lowest), max(a.z, max(b.z, c.z)))
