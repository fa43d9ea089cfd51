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

"""Triangles of a hull gathered into planar faces.

A region grows from its largest triangle over the neighbours whose vertices lie within
the tolerance of the plane of all triangles gathered so far. That plane is kept as an
area vector and an area-weighted centroid, so that a fan of slivers (the cap of a finely
tessellated cylinder, rounded to float32) settles on the right plane while it grows.
"""

from typing import NamedTuple

import numpy as np

from ..array_types import Array, Flags, Index
from ..compilation import inlined, kernel
from ..mesh.measures import area_vectors, centroid_of
from ..sorting import falling_order
from ..vectors import (
    add,
    area_vector,
    divide,
    dot,
    length,
    point_at,
    read_vector,
    scale,
    subtract,
    triangle_at,
    write_vector,
)

# The plane (7,) of what is gathered: area vector, sum of centroids times area, sum of
# areas.
NORMAL = 0  # 0, 1, 2
CENTROID = 3  # 3, 4, 5
AREA = 6
PLANE = 7


class Surface(NamedTuple):
    """Triangles to be gathered."""

    points: Array  # (H, 3)
    triangles: Index  # (M, 3)
    neighbors: Index  # (M, 3) triangle opposite to each vertex, -1 for none
    vectors: Array  # (M, 3) area along the normal
    areas: Array  # (M,)


@kernel
def orient_triangles(points: Array, triangles: Index, neighbors: Index) -> None:
    """Wind every triangle counter-clockwise seen from outside, in place.

    The triangle that stands clearest of the origin (which is inside) decides; the
    others follow over shared edges, so that slivers whose own orientation is rounding
    noise agree.
    """
    count = triangles.shape[0]
    largest_volume = -1.0
    start = 0
    for t in range(count):
        a, b, c = triangle_at(points, triangles, t)
        volume = dot(area_vector(a, b, c), a)
        if abs(volume) > largest_volume:
            largest_volume = abs(volume)
            start = t
        if volume < 0.0:
            _flip_triangle(triangles, neighbors, t)
    is_oriented = np.zeros(count, np.bool_)
    stack = np.empty(count, np.int64)
    stack[0] = start
    size = 1
    is_oriented[start] = True
    while size > 0:
        size -= 1
        t = stack[size]
        for i in range(3):
            neighbour = neighbors[t, i]
            if neighbour < 0 or is_oriented[neighbour]:
                continue
            v = triangles[t, (i + 1) % 3]
            w = triangles[t, (i + 2) % 3]
            for j in range(3):
                if (
                    triangles[neighbour, j] == v
                    and triangles[neighbour, (j + 1) % 3] == w
                ):
                    _flip_triangle(triangles, neighbors, neighbour)
                    break
            is_oriented[neighbour] = True
            stack[size] = neighbour
            size += 1


@kernel
def _flip_triangle(triangles: Index, neighbors: Index, t: int) -> None:
    triangles[t, 1], triangles[t, 2] = triangles[t, 2], triangles[t, 1]
    neighbors[t, 1], neighbors[t, 2] = neighbors[t, 2], neighbors[t, 1]


@kernel
def opposite_half_edges(triangles: Index, neighbors: Index) -> Index:
    """Opposite of each half-edge 3 t + i (side of triangle t opposite to vertex i)."""
    opposite = np.full(3 * triangles.shape[0], -1, np.int64)
    for t in range(triangles.shape[0]):
        for i in range(3):
            neighbour = neighbors[t, i]
            a = triangles[t, (i + 1) % 3]
            b = triangles[t, (i + 2) % 3]
            for j in range(3):
                if (
                    triangles[neighbour, (j + 1) % 3] == b
                    and triangles[neighbour, (j + 2) % 3] == a
                ):
                    opposite[3 * t + i] = 3 * neighbour + j
    return opposite


@kernel
def planar_regions(
    points: Array, triangles: Index, neighbors: Index, tolerance: float
) -> Index:
    """Planar region of each triangle, larger seeds first; tolerance 0 joins none."""
    count = triangles.shape[0]
    if tolerance <= 0.0:
        return np.arange(count)
    vectors, areas = area_vectors(points, triangles)
    surface = Surface(points, triangles, neighbors, vectors, areas)
    is_isolated = _isolated_triangles(surface, tolerance)
    region = np.full(count, -1, np.int64)
    queue = np.empty(count, np.int64)
    plane = np.empty(PLANE)
    number = 0
    for seed in falling_order(areas):
        if region[seed] >= 0:
            continue
        if is_isolated[seed]:
            region[seed] = number
            number += 1
            continue
        if areas[seed] == 0.0:
            # A triangle without area has no plane of its own; its largest neighbour
            # takes it.
            largest = seed
            for i in range(3):
                neighbour = neighbors[seed, i]
                if neighbour >= 0 and areas[neighbour] > areas[largest]:
                    largest = neighbour
            if region[largest] >= 0:
                region[seed] = region[largest]
                continue
        _grow_region(surface, region, queue, plane, seed, number, tolerance)
        number += 1
    return region


@kernel
def _isolated_triangles(surface: Surface, tolerance: float) -> Flags:
    """Whether no neighbour of a triangle (M,) lies in its plane.

    Most triangles of a curved surface are such, and need no search for the largest
    seed.
    """
    neighbors = surface.neighbors
    areas = surface.areas
    is_isolated = np.zeros(areas.shape[0], np.bool_)
    plane = np.empty(PLANE)
    for t in range(areas.shape[0]):
        if areas[t] == 0.0:
            continue
        plane[:] = 0.0
        _add_to_plane(surface, plane, t)
        has_neighbour = False
        for i in range(3):
            neighbour = neighbors[t, i]
            has_neighbour = has_neighbour or (
                neighbour >= 0 and _is_near_plane(surface, plane, neighbour, tolerance)
            )
        is_isolated[t] = not has_neighbour
    return is_isolated


@inlined
def _grow_region(
    surface: Surface,
    region: Index,
    queue: Index,
    plane: Array,
    seed: int,
    number: int,
    tolerance: float,
) -> None:
    """Fill a region from its seed; `queue` and `plane` are scratch."""
    plane[:] = 0.0
    _add_to_plane(surface, plane, seed)
    region[seed] = number
    queue[0] = seed
    size = 1
    has_grown = True
    # A triangle turned away while the plane was still rough gets a second look at the
    # end.
    while has_grown:
        has_grown = False
        k = 0
        while k < size:
            t = queue[k]
            k += 1
            for i in range(3):
                neighbour = surface.neighbors[t, i]
                if neighbour < 0 or region[neighbour] >= 0:
                    continue
                if not _is_near_plane(surface, plane, neighbour, tolerance):
                    continue
                _add_to_plane(surface, plane, neighbour)
                region[neighbour] = number
                queue[size] = neighbour
                size += 1
                has_grown = True


@inlined
def _add_to_plane(surface: Surface, plane: Array, t: int) -> None:
    area = surface.areas[t]
    centroid = scale(centroid_of(surface.points, surface.triangles, t), area)
    write_vector(
        plane,
        NORMAL,
        add(read_vector(plane, NORMAL), point_at(surface.vectors, t)),
    )
    write_vector(plane, CENTROID, add(read_vector(plane, CENTROID), centroid))
    plane[AREA] += area


@inlined
def _is_near_plane(surface: Surface, plane: Array, t: int, tolerance: float) -> bool:
    """Whether a triangle lies in the plane gathered so far.

    Its own normal is not asked: where Qhull cuts a facet of many corners into
    triangles, some are slivers and some fold back, and their area vectors still sum up
    to the facet's.
    """
    normal = read_vector(plane, NORMAL)
    total = plane[AREA]
    size = length(normal)
    if size == 0.0 or total == 0.0:
        return False
    centroid = divide(read_vector(plane, CENTROID), total)
    for j in range(3):
        point = point_at(surface.points, surface.triangles[t, j])
        if abs(dot(subtract(point, centroid), normal)) > tolerance * size:
            return False
    return True
