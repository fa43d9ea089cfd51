"""Triangles of a hull gathered into planar faces.

A region grows from its largest triangle over the neighbours whose vertices lie within the
tolerance of the plane of all triangles gathered so far. That plane is kept as an area
vector and an area-weighted centroid, so that a fan of slivers (the cap of a finely
tessellated cylinder, rounded to float32) settles on the right plane while it grows.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .compilation import entry_kernel, kernel
from .vectors import area_vector

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@kernel
def orient(points: Array, triangles: Index, neighbors: Index) -> None:
    """Wind every triangle counter-clockwise seen from outside, in place.

    The triangle that stands clearest of the origin (which is inside) decides; the others
    follow over shared edges, so that slivers whose own orientation is rounding noise agree.
    `neighbors[t, i]` stays the triangle opposite to vertex i.
    """
    count = triangles.shape[0]
    best, start = -1.0, 0
    for t in range(count):
        p = points[triangles[t, 0]]
        x, y, z = area_vector(p, points[triangles[t, 1]], points[triangles[t, 2]])
        volume = x * p[0] + y * p[1] + z * p[2]
        if abs(volume) > best:
            best, start = abs(volume), t
        if volume < 0.0:
            _flip(triangles, neighbors, t)
    seen = np.zeros(count, np.bool_)
    stack = np.empty(count, np.int64)
    stack[0], size = start, 1
    seen[start] = True
    while size > 0:
        size -= 1
        t = stack[size]
        for i in range(3):
            n = neighbors[t, i]
            if n < 0 or seen[n]:
                continue
            a, b = triangles[t, (i + 1) % 3], triangles[t, (i + 2) % 3]
            for j in range(3):
                if triangles[n, j] == a and triangles[n, (j + 1) % 3] == b:
                    _flip(triangles, neighbors, n)
                    break
            seen[n] = True
            stack[size] = n
            size += 1


@kernel
def _flip(triangles: Index, neighbors: Index, t: int) -> None:
    triangles[t, 1], triangles[t, 2] = triangles[t, 2], triangles[t, 1]
    neighbors[t, 1], neighbors[t, 2] = neighbors[t, 2], neighbors[t, 1]


@kernel
def twins(triangles: Index, neighbors: Index) -> Index:
    """Opposite of each half-edge 3 t + i (the side of triangle t opposite to vertex i)."""
    opposite = np.full(3 * triangles.shape[0], -1, np.int64)
    for t in range(triangles.shape[0]):
        for i in range(3):
            n = neighbors[t, i]
            a, b = triangles[t, (i + 1) % 3], triangles[t, (i + 2) % 3]
            for j in range(3):
                if triangles[n, (j + 1) % 3] == b and triangles[n, (j + 2) % 3] == a:
                    opposite[3 * t + i] = 3 * n + j
    return opposite


@kernel
def planar_regions(points: Array, triangles: Index, neighbors: Index, tolerance: float) -> Index:
    """Number of the planar region of each triangle.

    Parameters
    ----------
    points : (H, 3) array
    triangles, neighbors : (M, 3) arrays
        Oriented, as `orient` leaves them; a neighbour of -1 is none.
    tolerance : float
        Distance of a vertex from its region's plane; 0 keeps every triangle apart.

    Returns
    -------
    (M,) array of int
        Regions numbered from 0, larger seeds first.
    """
    count = triangles.shape[0]
    vectors = np.empty((count, 3))
    areas = np.empty(count)
    for t in range(count):
        x, y, z = area_vector(points[triangles[t, 0]], points[triangles[t, 1]],
                              points[triangles[t, 2]])
        vectors[t, 0], vectors[t, 1], vectors[t, 2] = x, y, z
        areas[t] = math.sqrt(x * x + y * y + z * z)
    region = np.full(count, -1, np.int64)
    if tolerance <= 0.0:
        return np.arange(count)
    order = np.argsort(-areas, kind="mergesort")
    queue = np.empty(count, np.int64)
    number = 0
    for seed in order:
        if region[seed] >= 0:
            continue
        if areas[seed] == 0.0:
            # A triangle without area has no plane of its own; its largest neighbour takes it.
            best = seed
            for i in range(3):
                n = neighbors[seed, i]
                if n >= 0 and areas[n] > areas[best]:
                    best = n
            if region[best] >= 0:
                region[seed] = region[best]
                continue
        _grow(points, triangles, neighbors, vectors, areas, region, queue, seed, number, tolerance)
        number += 1
    return region


@kernel
def _grow(points: Array, triangles: Index, neighbors: Index, vectors: Array, areas: Array,
          region: Index, queue: Index, seed: int, number: int, tolerance: float) -> None:
    plane = np.zeros(6)  # area vector and area-weighted sum of centroids
    total = _gather(points, triangles, vectors, areas, plane, 0.0, seed)
    region[seed] = number
    queue[0], size = seed, 1
    grown = True
    # A triangle turned away while the plane was still rough gets a second look at the end.
    while grown:
        grown = False
        k = 0
        while k < size:
            t = queue[k]
            k += 1
            for i in range(3):
                n = neighbors[t, i]
                if n < 0 or region[n] >= 0:
                    continue
                if not _near_plane(points, triangles, plane, total, n, tolerance):
                    continue
                total = _gather(points, triangles, vectors, areas, plane, total, n)
                region[n] = number
                queue[size] = n
                size += 1
                grown = True


@kernel
def _gather(points: Array, triangles: Index, vectors: Array, areas: Array, plane: Array,
            total: float, t: int) -> float:
    for c in range(3):
        plane[c] += vectors[t, c]
        centroid = (points[triangles[t, 0], c] + points[triangles[t, 1], c]
                    + points[triangles[t, 2], c]) / 3.0
        plane[3 + c] += areas[t] * centroid
    return float(total + areas[t])


@kernel
def _near_plane(points: Array, triangles: Index, plane: Array, total: float, t: int,
                tolerance: float) -> bool:
    """Whether a triangle lies in the plane gathered so far.

    Its own normal is not asked: where Qhull cuts a facet of many corners into triangles, some
    are slivers and some fold back, and their area vectors still sum up to the facet's.
    """
    length = math.sqrt(plane[0] ** 2 + plane[1] ** 2 + plane[2] ** 2)
    if length == 0.0 or total == 0.0:
        return False
    for j in range(3):
        p = points[triangles[t, j]]
        off = ((p[0] - plane[3] / total) * plane[0] + (p[1] - plane[4] / total) * plane[1]
               + (p[2] - plane[5] / total) * plane[2])
        if abs(off) > tolerance * length:
            return False
    return True


@entry_kernel
def surface_regions(points: Array, triangles: Index, neighbors: Index, tolerance: float) -> Index:
    """`planar_regions` of any closed surface, convex or not, for callers outside the kernels."""
    return planar_regions(points, triangles, neighbors, tolerance)
