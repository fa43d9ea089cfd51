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

"""How much of a body's turning is gathered in few corners.

A corner's angle defect, 2 pi less the angles of its faces there, is its share of the 4
pi by which a convex body turns. The sum of the squares of these shares is one over the
number of equal corners. Here shares that lie within a reach of each other count as one
corner, the less the farther they are apart: so a corner that is cut off by a hair, or
one more on a straight edge, changes nothing, as it would with the plain sum.
"""

import math

import numpy as np

from ..array_types import Array, Fixed1, Fixed2, Index
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, inlined, kernel
from ..sorting import rising_order
from ..vectors import cross, dot, length, point_at, subtract

PAIRS_LIMIT = 500
"""Corners up to which all pairs are looked at; from there on those of nearby cells."""

CELLS = 2.0
"""Cells in the largest reach."""


@entry_kernel
def corner_crowding(points: Fixed2, body: BodyArrays, reaches: Fixed1) -> Array:
    """Sum over all pairs of corners of both shares times (1 - (distance / reach)^2)^2.

    `reaches` (n,) rise. Returns (n,): from one over the number of equal corners far
    apart, to 1.
    """
    share = corner_shares(points, body)
    corners = np.flatnonzero(share)
    cells = 1
    if corners.shape[0] > PAIRS_LIMIT:
        cells = max(1, int(2.0 * CELLS / reaches[-1]))
    order, cell, start = _sort_into_cells(points[corners], cells)
    share = share[corners][order]
    position = points[corners][order]
    sums = np.empty(reaches.shape[0])
    for n in range(reaches.shape[0]):
        sums[n] = _sum_pairs(share, position, cell, start, cells, reaches[n])
    return sums


@kernel
def _sum_pairs(
    share: Array, position: Array, cell: Index, start: Index, cells: int, reach: float
) -> float:
    """Sum over all pairs of points in the order of their cells."""
    reach_cells = int(0.5 * cells * reach) + 1
    total = 0.0
    for i in range(share.shape[0]):
        total += share[i] * share[i]
        # Cells before this one hold points before i, whose pairs are counted.
        for x in range(cell[i, 0], min(cell[i, 0] + reach_cells, cells - 1) + 1):
            low = max(cell[i, 1] - reach_cells, 0)
            high = min(cell[i, 1] + reach_cells, cells - 1)
            for y in range(low, high + 1):
                row = (x * cells + y) * cells
                begin = start[row + max(cell[i, 2] - reach_cells, 0)]
                end = start[row + min(cell[i, 2] + reach_cells, cells - 1) + 1]
                total = _add_pairs(
                    total, i, max(begin, i + 1), end, share, position, reach
                )
    return total


@inlined
def _add_pairs(
    total: float,
    i: int,
    begin: int,
    end: int,
    share: Array,
    position: Array,
    reach: float,
) -> float:
    """Add the pairs of point i and those from `begin` to before `end`, twice each."""
    square_reach = reach * reach
    for j in range(begin, end):
        offset = subtract(point_at(position, i), point_at(position, j))
        # Whether a pair is within the reach is beyond a processor's guess: no branch.
        closeness = max(1.0 - dot(offset, offset) / square_reach, 0.0)
        total += 2.0 * share[i] * share[j] * closeness * closeness
    return total


@kernel
def _sort_into_cells(position: Array, cells: int) -> tuple[Index, Index, Index]:
    """Order and cells of points in a grid over [-1, 1]^3, and each cell's first."""
    cell = np.empty(position.shape, np.int64)
    key = np.empty(position.shape[0], np.int64)
    start = np.zeros(cells**3 + 1, np.int64)
    for i in range(position.shape[0]):
        for axis in range(3):
            index = int(0.5 * cells * (position[i, axis] + 1.0))
            cell[i, axis] = min(max(index, 0), cells - 1)
        key[i] = (cell[i, 0] * cells + cell[i, 1]) * cells + cell[i, 2]
        start[key[i] + 1] += 1
    for k in range(start.shape[0] - 1):
        start[k + 1] += start[k]
    order = rising_order(key)
    return order, cell[order], start


@kernel
def corner_shares(points: Array, body: BodyArrays) -> Array:
    """Angle defect (H,) of every point over 4 pi; 0 for those that are no corners."""
    share = np.zeros(points.shape[0])
    for k in range(body.corner.shape[0]):
        side = body.next_side[k]
        corner = body.corner[side]
        apex = point_at(points, corner)
        a = subtract(point_at(points, body.corner[k]), apex)
        b = subtract(point_at(points, body.corner[body.next_side[side]]), apex)
        share[corner] += math.atan2(length(cross(a, b)), dot(a, b))
    for v in range(share.shape[0]):
        if share[v] > 0.0:
            share[v] = max(0.5 - share[v] / (4.0 * math.pi), 0.0)
    return share
