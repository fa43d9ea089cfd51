"""Tetrahedra between the origin and the triangles of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .array_types import Array2, Index2
from .compilation import entry_kernel, inlined

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@inlined
def _six_volumes(points: Array, a: int, b: int, c: int) -> float:
    ax, ay, az = points[a, 0], points[a, 1], points[a, 2]
    bx, by, bz = points[b, 0], points[b, 1], points[b, 2]
    cx, cy, cz = points[c, 0], points[c, 1], points[c, 2]
    return float(ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz)
                 + az * (bx * cy - by * cx))


@entry_kernel
def tetrahedra(points: Array2, triangles: Index2) -> Array:
    """Six times the signed volumes (T,) of tetrahedra from the origin to triangles (T, 3)."""
    volumes = np.empty(triangles.shape[0])
    for t in range(triangles.shape[0]):
        volumes[t] = _six_volumes(points, triangles[t, 0], triangles[t, 1], triangles[t, 2])
    return volumes


@entry_kernel
def weighted_corners(points: Array2, triangles: Index2) -> tuple[Array, Array, Array]:
    """What the volume integrals over the tetrahedra are sums of.

    Parameters
    ----------
    points : (V, 3) array
    triangles : (T, 3) array

    Returns
    -------
    volumes : (T,) array
        Six times the signed volumes.
    corners : (4, T, 3) array
        First, second and third corners of the triangles, and the sums of the three.
    weighted : (4, T, 3) array
        These times `volumes`.
    """
    count = triangles.shape[0]
    volumes = np.empty(count)
    corners, weighted = np.empty((4, count, 3)), np.empty((4, count, 3))
    for t in range(count):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        volume = _six_volumes(points, a, b, c)
        volumes[t] = volume
        for k in range(3):
            p, q, r = points[a, k], points[b, k], points[c, k]
            total = p + q + r
            corners[0, t, k], corners[1, t, k] = p, q
            corners[2, t, k], corners[3, t, k] = r, total
            weighted[0, t, k], weighted[1, t, k] = p * volume, q * volume
            weighted[2, t, k], weighted[3, t, k] = r * volume, total * volume
    return volumes, corners, weighted
