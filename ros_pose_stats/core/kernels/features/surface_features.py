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

"""A surface with what its facets stand for, and motions that carry it into itself.

Planar regions of triangles are the facets. Where some of them follow each other round a
curve, the curve bulges out between their edges by a chord's error: another division of
the same curve may be off by as much, and lean as much. Nothing else may.
"""

import math
from typing import NamedTuple

import numpy as np

from ...tolerances import SYMMETRY
from ..array_types import (
    Array,
    Array1,
    Array2,
    Fixed1,
    Fixed2,
    FixedIndex1,
    FixedIndex2,
    Index,
    Index1,
    Index2,
)
from ..body.coplanar import planar_regions
from ..compilation import entry_kernel, inlined, kernel
from ..mesh.connections import find_representative, join_sets, triangle_neighbours
from ..mesh.measures import area_vectors, centroid_of
from ..mesh.triangle_tree import (
    TriangleTree,
    is_in_box,
    square_distance,
    triangle_tree,
)
from ..sorting import falling_order
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    length,
    point_at,
    read_row,
    read_vector,
    scale,
    subtract,
    transform,
    triangle_at,
    write_row,
)

# columns of the regions (G, 7)
CENTROID = 0  # 0, 1, 2
NORMAL = 3  # 3, 4, 5
AREA = 6
REGION = 7

SMALLEST_AREA = SYMMETRY * SYMMETRY
"""Area below which a region is none: of corners on one line rounding makes the normal.
"""

STEEPEST = 0.43
"""Turn in radians, that of a 15-gon and a little, up to which facets are on a curve."""

COARSE = 0.2
"""Turn from which on facets must be as wide as each other: a 32-gon has 0.196, and
errors of half a percent of the radius."""

WIDER = 2.2
EVEN = 1.2
"""How much wider than the next one a facet of a fine and of a coarse curve may be."""

FEWEST_ON_CURVE = 4
"""Facets of a curve."""

MOST_ON_FACET = 64
"""Triangles of a facet on a curve; a wider plane is none."""

CHORD_ERROR = 0.15
"""Chord's error over width and turn: an eighth, and some for uneven facets."""

LEAN = 0.6
"""Angle between a facet and its curve, over the turn: half, and some likewise."""


class Surface(NamedTuple):
    """A surface, and what its triangles stand for."""

    points: Array2  # (V, 3)
    triangles: Index2  # (T, 3)
    facet: Index1  # (T,) planar region of each triangle
    regions: Array2  # (G, 7) centroid, normal and area of each
    slack: Array1  # (G,) how far the curve that it stands for is off
    lean: Array1  # (G,) by how much its normal is off, radians
    sample: Index1  # (M,) triangle of each region, or -1 - vertex where regions meet


@entry_kernel
def surface_of(
    points: Fixed2, triangles: FixedIndex2, flatness: float, tolerance: float
) -> Surface:
    """Surface of points (V, 3) and outward triangles (T, 3).

    `flatness`: of its planar regions; `tolerance`: of places.
    """
    neighbours = triangle_neighbours(triangles)
    facet = planar_regions(points, triangles, neighbours, flatness)
    vectors, areas = area_vectors(points, triangles)
    regions, widths = _measure_regions(points, triangles, vectors, areas, facet)
    slack = np.zeros(regions.shape[0])
    lean = np.zeros(regions.shape[0])
    _find_curves(points, triangles, neighbours, facet, regions, slack, lean)
    for g in range(regions.shape[0]):
        # Coordinates that are off by the tolerance turn narrow regions.
        lean[g] += 2.0 * tolerance / max(widths[g], 1e-12)
    return Surface(
        points.copy(),
        triangles.copy(),
        facet,
        regions,
        slack,
        lean,
        _choose_samples(triangles, facet, regions, areas, points.shape[0]),
    )


@entry_kernel
def tree_of(surface: Surface) -> TriangleTree:
    """The triangles of a surface in boxes, by which `first_stray` looks for places."""
    margins = np.empty(surface.facet.shape[0])
    for t in range(margins.shape[0]):
        margins[t] = surface.slack[surface.facet[t]]
    return triangle_tree(surface.points, surface.triangles, margins)


@kernel
def _measure_regions(
    points: Array, triangles: Index, vectors: Array, areas: Array, facet: Index
) -> tuple[Array, Array]:
    """Centroid, normal and area (G, 7), and greatest height of a triangle (G,)."""
    count = 0
    for t in range(facet.shape[0]):
        count = max(count, facet[t] + 1)
    regions = np.zeros((count, REGION))
    widths = np.zeros(count)
    for t in range(facet.shape[0]):
        g = facet[t]
        moment = scale(centroid_of(points, triangles, t), areas[t])
        write_row(regions, g, CENTROID, add(read_row(regions, g, CENTROID), moment))
        normal = add(read_row(regions, g, NORMAL), point_at(vectors, t))
        write_row(regions, g, NORMAL, normal)
        regions[g, AREA] += areas[t]
        a, b, c = triangle_at(points, triangles, t)
        longest = max(
            length(subtract(b, a)), max(length(subtract(c, b)), length(subtract(a, c)))
        )
        if longest > 0.0:
            widths[g] = max(widths[g], 2.0 * areas[t] / longest)
    for g in range(count):
        area = regions[g, AREA]
        normal = read_row(regions, g, NORMAL)
        size = length(normal)
        if area > 0.0 and size > 0.0:
            write_row(
                regions, g, CENTROID, divide(read_row(regions, g, CENTROID), area)
            )
            write_row(regions, g, NORMAL, divide(normal, size))
    return regions, widths


@kernel
def _find_curves(
    points: Array,
    triangles: Index,
    neighbours: Index,
    facet: Index,
    regions: Array,
    slack: Array,
    lean: Array,
) -> None:
    """Set how far facets on curves are off them, in place."""
    count = regions.shape[0]
    begin, members = _members_of(facet, count)
    curve = np.arange(count)
    for t in range(facet.shape[0]):
        g = facet[t]
        for i in range(3):
            neighbour = neighbours[t, i]
            if neighbour < t or facet[neighbour] == g:
                continue
            h = facet[neighbour]
            turn = length(
                subtract(read_row(regions, g, NORMAL), read_row(regions, h, NORMAL))
            )
            if turn > STEEPEST:
                continue
            if begin[g + 1] - begin[g] > MOST_ON_FACET:
                continue
            if begin[h + 1] - begin[h] > MOST_ON_FACET:
                continue
            v = point_at(points, triangles[t, (i + 1) % 3])
            w = point_at(points, triangles[t, (i + 2) % 3])
            if length(subtract(w, v)) == 0.0:
                continue
            line = divide(subtract(w, v), length(subtract(w, v)))
            first = _width_from(points, triangles, begin, members, g, v, line)
            second = _width_from(points, triangles, begin, members, h, v, line)
            widest = max(first, second)
            ratio = WIDER if turn < COARSE else EVEN
            if widest > ratio * min(first, second):
                continue
            join_sets(curve, g, h)
            for r in (g, h):
                slack[r] = max(slack[r], CHORD_ERROR * turn * widest)
                lean[r] = max(lean[r], LEAN * turn)
    facets = np.zeros(count, np.int64)
    for g in range(count):
        facets[find_representative(curve, g)] += 1
    for g in range(count):
        if facets[find_representative(curve, g)] < FEWEST_ON_CURVE:
            slack[g] = lean[g] = 0.0


@kernel
def _members_of(facet: Index, count: int) -> tuple[Index, Index]:
    """Where the triangles of each region begin, and these one after the other."""
    begin = np.zeros(count + 1, np.int64)
    for t in range(facet.shape[0]):
        begin[facet[t] + 1] += 1
    for g in range(count):
        begin[g + 1] += begin[g]
    position = begin.copy()
    members = np.empty(facet.shape[0], np.int64)
    for t in range(facet.shape[0]):
        members[position[facet[t]]] = t
        position[facet[t]] += 1
    return begin, members


@inlined
def _width_from(
    points: Array,
    triangles: Index,
    begin: Index,
    members: Index,
    g: int,
    origin: Vec3,
    line: Vec3,
) -> float:
    """Greatest distance of a region's corners from the line of an edge."""
    widest_square = 0.0
    for k in range(begin[g], begin[g + 1]):
        for j in range(3):
            offset = subtract(point_at(points, triangles[members[k], j]), origin)
            across = cross(offset, line)
            widest_square = max(widest_square, dot(across, across))
    return math.sqrt(widest_square)


@kernel
def _choose_samples(
    triangles: Index, facet: Index, regions: Array, areas: Array, vertices: int
) -> Index:
    """Largest triangle of each region, largest region first, then vertices of edges."""
    count = regions.shape[0]
    largest = np.full(count, -1, np.int64)
    region_of_vertex = np.full(vertices, -1, np.int64)
    on_edge = np.zeros(vertices, np.bool_)
    for t in range(facet.shape[0]):
        g = facet[t]
        if regions[g, AREA] < SMALLEST_AREA:
            continue
        if largest[g] < 0 or areas[t] > areas[largest[g]]:
            largest[g] = t
        for i in range(3):
            v = triangles[t, i]
            on_edge[v] = on_edge[v] or (
                region_of_vertex[v] >= 0 and region_of_vertex[v] != g
            )
            region_of_vertex[v] = g
    order = falling_order(regions[:, AREA].copy())
    sample = np.empty(count + vertices, np.int64)
    size = 0
    for g in order:
        if largest[g] >= 0:
            sample[size] = largest[g]
            size += 1
    for v in range(vertices):
        if on_edge[v]:
            sample[size] = -1 - v
            size += 1
    return sample[:size].copy()


@entry_kernel
def first_stray(
    surface: Surface,
    tree: TriangleTree,
    motion: Fixed2,
    shift: Fixed1,
    chosen: FixedIndex1,
    tolerance: float,
) -> int:
    """First of the chosen samples that a motion takes off the surface, or -1.

    `motion` (3, 3): a rotation or reflection; `shift` (3,): what follows it.
    """
    offset = read_vector(shift, 0)
    for i in chosen:
        t = surface.sample[i]
        if t < 0:
            point = point_at(surface.points, -1 - t)
            normal = Vec3(0.0, 0.0, 0.0)
            facet = -1
        else:
            point = centroid_of(surface.points, surface.triangles, t)
            facet = surface.facet[t]
            normal = transform(motion, read_row(surface.regions, facet, NORMAL))
        point = add(transform(motion, point), offset)
        if not _is_on_surface(surface, tree, point, normal, facet, tolerance):
            return i
    return -1


@inlined
def _is_on_surface(
    surface: Surface,
    tree: TriangleTree,
    point: Vec3,
    normal: Vec3,
    facet: int,
    tolerance: float,
) -> bool:
    """Whether the surface has a place there that faces as a facet (-1: any) does."""
    own_slack = surface.slack[facet] if facet >= 0 else 0.0
    own_lean = surface.lean[facet] if facet >= 0 else math.inf
    node = 0
    last = tree.skip[0]
    while node < last:
        if not is_in_box(tree, node, point, tolerance + own_slack):
            node = tree.skip[node]
            continue
        for k in range(max(tree.begin[node], 0), tree.end[node]):
            t = tree.order[k]
            g = surface.facet[t]
            reach = tolerance + max(own_slack, surface.slack[g])
            turn = subtract(normal, read_row(surface.regions, g, NORMAL))
            if length(turn) > own_lean + surface.lean[g]:
                continue
            a, b, c = triangle_at(surface.points, surface.triangles, t)
            if square_distance(point, a, b, c) <= reach * reach:
                return True
        node += 1
    return False
