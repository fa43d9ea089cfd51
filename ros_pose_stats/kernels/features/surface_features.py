"""Planar regions and corners of a surface, measured."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed2, FixedIndex2
from ..body.coplanar import area_vectors, planar_regions
from ..compilation import entry_kernel, kernel
from ..mesh.edges import neighbours
from ..sorting import falling_order

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@entry_kernel
def regions_and_corners(points: Fixed2, triangles: FixedIndex2,
                        tolerance: float) -> tuple[Array, Index]:
    """Planar regions of a closed surface and the vertices where at least three of them meet.

    Parameters
    ----------
    points : (V, 3) array
    triangles : (T, 3) array
    tolerance : float
        Coplanarity, in the unit of the points.

    Returns
    -------
    regions : (G, 7) array
        Centroid, normal times size and size (square root of the area), largest first. Regions
        without area are left out.
    corners : (C,) array
        Numbers of vertices.
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
    sums = np.zeros((count, 7))
    for t in range(region.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        g = region[t]
        for k in range(3):
            centroid = (points[a, k] + points[b, k] + points[c, k]) / 3.0
            sums[g, k] += centroid * areas[t]
            sums[g, 3 + k] += vectors[t, k]
        sums[g, 6] += areas[t]
    return sums


@kernel
def _largest_first(sums: Array) -> Array:
    order = falling_order(sums[:, 6].copy())
    count = 0
    for g in order:
        if sums[g, 6] == 0.0:
            break
        count += 1
    regions = np.empty((count, 7))
    for i in range(count):
        g = order[i]
        area = sums[g, 6]
        size = math.sqrt(area)
        for k in range(3):
            regions[i, k] = sums[g, k] / area
            regions[i, 3 + k] = sums[g, 3 + k] / size
        regions[i, 6] = size
    return regions


@kernel
def _corners(triangles: Index, region: Index, sums: Array, points: int) -> Index:
    """Vertices that touch at least three regions with an area."""
    touched = np.full((points, 2), -1, np.int64)
    corner, count = np.zeros(points, np.bool_), 0
    for t in range(triangles.shape[0]):
        g = region[t]
        if sums[g, 6] == 0.0:
            continue
        for i in range(3):
            v = triangles[t, i]
            if touched[v, 0] < 0:
                touched[v, 0] = g
            elif touched[v, 0] != g:
                if touched[v, 1] < 0:
                    touched[v, 1] = g
                elif touched[v, 1] != g and not corner[v]:
                    corner[v] = True
                    count += 1
    found = np.empty(count, np.int64)
    place = 0
    for v in range(points):
        if corner[v]:
            found[place] = v
            place += 1
    return found
