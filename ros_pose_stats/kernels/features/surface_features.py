"""Planar regions and corners of a surface, measured."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..array_types import Array, Fixed2, FixedIndex2, Index
from ..body.coplanar import planar_regions
from ..compilation import entry_kernel, inlined, kernel
from ..mesh.edges import neighbours
from ..mesh.measures import area_vectors, centroid_of
from ..sorting import falling_order
from ..vectors import divided, plus, point_at, read_row, scaled, write_row

# columns of the regions (G, 7) and of the sums that they are made of
CENTROID: Final = 0  # 0, 1, 2; in a sum times the area
NORMAL: Final = 3    # 3, 4, 5: times the size; in a sum times the area
SIZE: Final = 6      # square root of the area; in a sum the area
AREA: Final = 6
REGION: Final = 7


@entry_kernel
def regions_and_corners(points: Fixed2, triangles: FixedIndex2,
                        tolerance: float) -> tuple[Array, Index]:
    """Planar regions of a closed surface and the vertices where at least three of them meet.

    `points` (V, 3); `triangles` (T, 3); `tolerance`: coplanarity, in the unit of the points.
    Returns `regions` (G, 7): centroid, normal times size and size (square root of the area),
    largest first. Regions without area are left out; `corners` (C,): numbers of vertices.
    """
    region = planar_regions(points, triangles, neighbours(triangles), tolerance)
    sums = _sums(points, triangles, region)
    return _largest_first(sums), _corners(triangles, region, sums, points.shape[0])


@kernel
def _sums(points: Array, triangles: Index, region: Index) -> Array:
    """Area-weighted centroid, area vector and area (G, 7) of the regions."""
    count = 0
    for t in range(region.shape[0]):
        count = max(count, region[t] + 1)
    vectors, areas = area_vectors(points, triangles)
    sums = np.zeros((count, REGION))
    for t in range(region.shape[0]):
        g = region[t]
        moment = scaled(centroid_of(points, triangles, t), areas[t])
        write_row(sums, g, CENTROID, plus(read_row(sums, g, CENTROID), moment))
        write_row(sums, g, NORMAL, plus(read_row(sums, g, NORMAL), point_at(vectors, t)))
        sums[g, AREA] += areas[t]
    return sums


@kernel
def _largest_first(sums: Array) -> Array:
    order = falling_order(sums[:, AREA].copy())
    count = 0
    for g in order:
        if sums[g, AREA] == 0.0:
            break
        count += 1
    regions = np.empty((count, REGION))
    for i in range(count):
        g = order[i]
        size = math.sqrt(sums[g, AREA])
        write_row(regions, i, CENTROID, divided(read_row(sums, g, CENTROID), sums[g, AREA]))
        write_row(regions, i, NORMAL, divided(read_row(sums, g, NORMAL), size))
        regions[i, SIZE] = size
    return regions


@kernel
def _corners(triangles: Index, region: Index, sums: Array, points: int) -> Index:
    """Vertices that touch at least three regions with an area."""
    touched = np.full((points, 2), -1, np.int64)
    corner, count = np.zeros(points, np.bool_), 0
    for t in range(triangles.shape[0]):
        g = region[t]
        if sums[g, AREA] == 0.0:
            continue
        for i in range(3):
            v = triangles[t, i]
            if _meets_third(touched, v, g) and not corner[v]:
                corner[v] = True
                count += 1
    found = np.empty(count, np.int64)
    place = 0
    for v in range(points):
        if corner[v]:
            found[place] = v
            place += 1
    return found


@inlined
def _meets_third(touched: Index, v: int, g: int) -> bool:
    """Note the first two regions that a vertex touches; tell whether this is another one."""
    for k in range(2):
        if touched[v, k] < 0:
            touched[v, k] = g
        if touched[v, k] == g:
            return False
    return True
