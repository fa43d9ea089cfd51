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

from ..array_types import Fixed2, FixedIndex2
from ..compilation import entry_kernel, inlined, kernel
from ..sorting import falling_order
from ..vectors import area_vector

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flag = NDArray[np.bool_]


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
    if tolerance <= 0.0:
        return np.arange(count)
    vectors, areas = area_vectors(points, triangles)
    alone = _alone(points, triangles, neighbors, vectors, areas, tolerance)
    region = np.full(count, -1, np.int64)
    queue = np.empty(count, np.int64)
    plane = np.empty(7)
    number = 0
    for seed in falling_order(areas):
        if region[seed] >= 0:
            continue
        if alone[seed]:
            region[seed] = number
            number += 1
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
        _grow(points, triangles, neighbors, vectors, areas, region, queue, plane, seed, number,
              tolerance)
        number += 1
    return region


@kernel
def _alone(points: Array, triangles: Index, neighbors: Index, vectors: Array, areas: Array,
           tolerance: float) -> Flag:
    """Whether no neighbour of a triangle (M,) lies in its plane.

    Most triangles of a curved surface are such; going through them in their own order spares
    a search from one end of the memory to the other for each seed.
    """
    alone = np.zeros(triangles.shape[0], np.bool_)
    plane = np.empty(7)
    for t in range(triangles.shape[0]):
        if areas[t] == 0.0:
            continue
        plane[:] = 0.0
        _gather(points, triangles, vectors, areas, plane, t)
        found = False
        for i in range(3):
            n = neighbors[t, i]
            found = found or (n >= 0 and _near_plane(points, triangles, plane, n, tolerance))
        alone[t] = not found
    return alone


@kernel
def area_vectors(points: Array, triangles: Index) -> tuple[Array, Array]:
    """Area along the normal (M, 3) and area (M,) of triangles (M, 3)."""
    count = triangles.shape[0]
    vectors, areas = np.empty((count, 3)), np.empty(count)
    for t in range(count):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        px, py, pz = points[p, 0], points[p, 1], points[p, 2]
        ax, ay, az = points[q, 0] - px, points[q, 1] - py, points[q, 2] - pz
        bx, by, bz = points[r, 0] - px, points[r, 1] - py, points[r, 2] - pz
        x, y, z = 0.5 * (ay * bz - az * by), 0.5 * (az * bx - ax * bz), 0.5 * (ax * by - ay * bx)
        vectors[t, 0], vectors[t, 1], vectors[t, 2] = x, y, z
        areas[t] = math.sqrt(x * x + y * y + z * z)
    return vectors, areas


@inlined
def _grow(points: Array, triangles: Index, neighbors: Index, vectors: Array, areas: Array,
          region: Index, queue: Index, plane: Array, seed: int, number: int,
          tolerance: float) -> None:
    """Fill a region from its seed; `plane` is scratch.

    Area vector, area-weighted sum of centroids and sum of areas of what is gathered.
    """
    plane[:] = 0.0
    _gather(points, triangles, vectors, areas, plane, seed)
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
                if not _near_plane(points, triangles, plane, n, tolerance):
                    continue
                _gather(points, triangles, vectors, areas, plane, n)
                region[n] = number
                queue[size] = n
                size += 1
                grown = True


@inlined
def _gather(points: Array, triangles: Index, vectors: Array, areas: Array, plane: Array,
            t: int) -> None:
    p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    for c in range(3):
        plane[c] += vectors[t, c]
        centroid = (points[p, c] + points[q, c] + points[r, c]) / 3.0
        plane[3 + c] += areas[t] * centroid
    plane[6] += areas[t]


@inlined
def _near_plane(points: Array, triangles: Index, plane: Array, t: int, tolerance: float) -> bool:
    """Whether a triangle lies in the plane gathered so far.

    Its own normal is not asked: where Qhull cuts a facet of many corners into triangles, some
    are slivers and some fold back, and their area vectors still sum up to the facet's.
    """
    nx, ny, nz, total = plane[0], plane[1], plane[2], plane[6]
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0.0 or total == 0.0:
        return False
    mx, my, mz = plane[3] / total, plane[4] / total, plane[5] / total
    for j in range(3):
        p = triangles[t, j]
        off = (points[p, 0] - mx) * nx + (points[p, 1] - my) * ny + (points[p, 2] - mz) * nz
        if abs(off) > tolerance * length:
            return False
    return True


@entry_kernel
def surface_regions(points: Fixed2, triangles: FixedIndex2, neighbors: FixedIndex2,
                    tolerance: float) -> Index:
    """`planar_regions` of any closed surface, convex or not, for callers outside the kernels."""
    return planar_regions(points, triangles, neighbors, tolerance)
