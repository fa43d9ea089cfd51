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

"""Edges of a hull that lie on the mesh's surface, and its outermost corners."""

import math

import numpy as np

from ..array_types import Array, Fixed2, FixedIndex1, FixedIndex2, Flags, Index
from ..compilation import entry_kernel, inlined
from ..elementary import sine_cosine
from ..vectors import Vec3, add, dot, length, point_at, scale, subtract


@entry_kernel
def edges_on_surface(
    vertices: Fixed2,
    triangles: FixedIndex2,
    ends: FixedIndex2,
    first: FixedIndex1,
    order: FixedIndex1,
    tolerance: float,
) -> Index:
    """Ends (E,) of each hull edge that lie on an edge of the mesh along it.

    An edge of the hull that is an edge of the mesh has two, and so has one that the
    mesh divides. Over a gap there are none. `order` (2E,): ends by vertex, 2 e + i
    being end i of edge e, from `first[v]` on those at vertex v.
    """
    is_seen = np.zeros(order.shape[0], np.bool_)
    for t in range(triangles.shape[0]):
        for i in range(3):
            a = triangles[t, i]
            if first[a] == first[a + 1]:
                continue
            for step in range(1, 3):
                b = triangles[t, (i + step) % 3]
                for k in range(first[a], first[a + 1]):
                    end = order[k]
                    if not is_seen[end]:
                        far_end = ends[end // 2, 1 - end % 2]
                        is_seen[end] = far_end == b or _is_along(
                            vertices, a, b, far_end, tolerance
                        )
    ends_on_surface = np.zeros(ends.shape[0], np.int64)
    for e in range(ends.shape[0]):
        ends_on_surface[e] = int(is_seen[2 * e]) + int(is_seen[2 * e + 1])
    return ends_on_surface


@inlined
def _is_along(vertices: Array, a: int, b: int, far_end: int, tolerance: float) -> bool:
    """Whether vertex b lies on the straight line between vertices a and other."""
    chord = subtract(point_at(vertices, far_end), point_at(vertices, a))
    offset = subtract(point_at(vertices, b), point_at(vertices, a))
    share = dot(offset, chord) / dot(chord, chord)
    if share >= 1.0:
        return False
    return length(subtract(offset, scale(chord, max(share, 0.0)))) <= tolerance


@entry_kernel
def outermost_corners(
    points: Fixed2,
    first: FixedIndex1,
    neighbour: FixedIndex1,
    axes: Fixed2,
    sides: int,
    tie: float,
) -> Flags:
    """Which corners (H,) lie farthest out in a direction of a grid over the sphere.

    The rows of the grid are circles of latitude, mirrored at the equator, their
    directions as far apart as those of a circle of `sides` or half as far.
    `neighbour[first[i]:first[i + 1]]`: neighbours of corner i; `axes`: the last goes
    through the poles; `tie`: what lies this little behind the farthest counts as well.
    """
    is_outermost = np.zeros(points.shape[0], np.bool_)
    corner = 0
    rows = (sides + 3) // 4
    for latitude in range(-rows, rows + 1):
        z, ring = sine_cosine(0.5 * math.pi * latitude / rows)
        directions = sides
        while directions % 2 == 0 and 2.0 * ring * sides <= directions:
            directions //= 2
        if abs(latitude) == rows:
            directions = 1
            ring = 0.0
        for k in range(directions):
            y, x = sine_cosine(2.0 * math.pi * k / directions)
            direction = add(
                add(
                    scale(point_at(axes, 0), ring * x),
                    scale(point_at(axes, 1), ring * y),
                ),
                scale(point_at(axes, 2), z),
            )
            corner = _climb_to_farthest(points, first, neighbour, direction, corner)
            _mark_ties(points, first, neighbour, direction, corner, tie, is_outermost)
    return is_outermost


@inlined
def _climb_to_farthest(
    points: Array, first: Index, neighbour: Index, direction: Vec3, corner: int
) -> int:
    """Corner farthest along a direction, over neighbours that lie farther each time."""
    extent = dot(direction, point_at(points, corner))
    rising = True
    while rising:
        rising = False
        start = corner
        for k in range(first[start], first[start + 1]):
            neighbour_extent = dot(direction, point_at(points, neighbour[k]))
            if neighbour_extent > extent:
                extent = neighbour_extent
                corner = neighbour[k]
                rising = True
    return corner


@inlined
def _mark_ties(
    points: Array,
    first: Index,
    neighbour: Index,
    direction: Vec3,
    top: int,
    tie: float,
    is_outermost: Flags,
) -> None:
    """Mark the farthest corner or both ends of an edge, but no corners of a face."""
    threshold = dot(direction, point_at(points, top)) - tie
    ties = 0
    farthest = top
    for k in range(first[top], first[top + 1]):
        if dot(direction, point_at(points, neighbour[k])) >= threshold:
            ties = ties + 1
            farthest = neighbour[k]
    if ties < 2:
        is_outermost[top] = is_outermost[farthest] = True
