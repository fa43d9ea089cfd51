"""Moments of a surface's planar regions along directions, up to the fourth order.

A sum of products of components is symmetric in them, so it is kept by monomials: of the 1, 3,
9, 27 and 81 products of up to four components of (x, y, z) 1, 3, 6, 10 and 15 differ.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..array_types import Array, Fixed2
from ..compilation import entry_kernel, inlined
from ..vectors import Vec3, dot, point_at, read_row
from .surface_features import CENTROID, NORMAL, SIZE

# How many products of components are the same monomial, in the order of `_monomials`.
_TIMES: Final = np.array(
    [1, 1, 1, 1, 1, 2, 2, 1, 2, 1, 1, 3, 3, 3, 6, 3, 1, 3, 3, 1,
     1, 4, 4, 6, 12, 6, 4, 12, 12, 4, 1, 4, 6, 4, 1], dtype=np.float64)

# Where each degree begins in that order.
_DEGREE: Final = (0, 1, 4, 10, 20, 35)

# columns of the moments (S, 7) along a direction u
HEIGHTS: Final = 0  # 0, 1, 2: sums over the regions of A (c·u)^k for k = 2, 3, 4
FLOWS: Final = 3    # 3 ... 6: of A² (n·u) (c·u)^k for k = 0, 1, 2, 3


@entry_kernel
def moments_along(regions: Fixed2, directions: Fixed2) -> Array:
    """Moments of regions along directions, the same for a turned surface and direction.

    `regions` (G, 7): centroid c, normal n times size and size (square root of the area A);
    `directions` (S, 3): unit vectors u. Returns (S, 7): sums over the regions of A (c·u)^k for k =
    2, 3, 4, and of A² (n·u) (c·u)^k for k = 0, 1, 2, 3.
    """
    areas, flows = np.zeros(35), np.zeros((3, 20))
    terms = np.empty(35)
    for g in range(regions.shape[0]):
        _monomials(read_row(regions, g, CENTROID), terms)
        size = regions[g, SIZE]
        area = size * size
        for m in range(35):
            areas[m] += area * terms[m]
        for i in range(3):
            flow = regions[g, NORMAL + i] * size * area
            for m in range(20):
                flows[i, m] += flow * terms[m]
    moments = np.zeros((directions.shape[0], 7))
    for s in range(directions.shape[0]):
        direction = point_at(directions, s)
        _monomials(direction, terms)
        for k in range(4):
            for m in range(_DEGREE[k], _DEGREE[k + 1]):
                flow = dot(direction, Vec3(flows[0, m], flows[1, m], flows[2, m]))
                moments[s, FLOWS + k] += _TIMES[m] * terms[m] * flow
        for k in range(2, 5):
            for m in range(_DEGREE[k], _DEGREE[k + 1]):
                moments[s, HEIGHTS + k - 2] += _TIMES[m] * terms[m] * areas[m]
    return moments


@inlined
def _monomials(a: Vec3, terms: Array) -> None:
    """Set `terms` (35,) to the monomials of degree 0 to 4; each from one of lower degree."""
    terms[0] = 1.0
    for degree in range(1, 5):
        lower, here = _DEGREE[degree - 1], _DEGREE[degree]
        count = here - lower
        for m in range(count):
            terms[here + m] = a.x * terms[lower + m]
        # The last `degree` of the lower ones are free of x, the very last of y too.
        for m in range(degree):
            terms[here + count + m] = a.y * terms[here - degree + m]
        terms[here + count + degree] = a.z * terms[here - 1]
