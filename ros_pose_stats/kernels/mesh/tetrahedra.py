"""Tetrahedra between the origin and the triangles of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed2, FixedIndex2
from ..compilation import entry_kernel, inlined

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
def tetrahedra(points: Fixed2, triangles: FixedIndex2) -> Array:
    """Six times the signed volumes (T,) of tetrahedra from the origin to triangles (T, 3)."""
    volumes = np.empty(triangles.shape[0])
    for t in range(triangles.shape[0]):
        volumes[t] = _six_volumes(points, triangles[t, 0], triangles[t, 1], triangles[t, 2])
    return volumes


@entry_kernel
def solid_moments(points: Fixed2, triangles: FixedIndex2) -> Array:
    """Integrals of 1, x, y, z, xx, yy, zz, xy, xz and yz over the inside of a closed surface.

    Parameters
    ----------
    points : (V, 3) array
        Of size one, about the middle.
    triangles : (T, 3) array
        Wound outward; what inward ones enclose counts negative.

    Returns
    -------
    (10,) array
        The sums over the tetrahedra are compensated (Neumaier 1974): their errors do not grow with
        the number of triangles.
    """
    total, lost, term = np.zeros(10), np.zeros(10), np.empty(10)
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        volume = _six_volumes(points, a, b, c) / 6.0
        term[0] = volume
        _moments(volume, points[a, 0], points[b, 0], points[c, 0], points[a, 1], points[b, 1],
                 points[c, 1], points[a, 2], points[b, 2], points[c, 2], term)
        for k in range(10):
            grown = total[k] + term[k]
            if abs(total[k]) >= abs(term[k]):
                lost[k] += (total[k] - grown) + term[k]
            else:
                lost[k] += (term[k] - grown) + total[k]
            total[k] = grown
    return total + lost


@inlined
def _moments(volume: float, ax: float, bx: float, cx: float, ay: float, by: float, cy: float,
             az: float, bz: float, cz: float, term: Array) -> None:
    """First and second moments of the tetrahedron of three corners and the origin."""
    sx, sy, sz = ax + bx + cx, ay + by + cy, az + bz + cz
    first, second = 0.25 * volume, 0.05 * volume
    term[1], term[2], term[3] = first * sx, first * sy, first * sz
    term[4] = second * (ax * ax + bx * bx + cx * cx + sx * sx)
    term[5] = second * (ay * ay + by * by + cy * cy + sy * sy)
    term[6] = second * (az * az + bz * bz + cz * cz + sz * sz)
    term[7] = second * (ax * ay + bx * by + cx * cy + sx * sy)
    term[8] = second * (ax * az + bx * bz + cx * cz + sx * sz)
    term[9] = second * (ay * az + by * bz + cy * cz + sy * sz)
