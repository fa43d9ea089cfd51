"""Areas and centroids of triangles, and the tetrahedra between them and the origin."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..array_types import Array, Fixed2, FixedIndex2, Index
from ..compilation import entry_kernel, inlined, kernel
from ..vectors import (
    Vec3,
    area_vector,
    cross,
    divided,
    dot,
    length,
    plus,
    scaled,
    times,
    triangle_at,
    write_row,
    write_vector,
)

# the moments (10,) of a solid: integrals of
VOLUME: Final = 0   # 1
FIRST: Final = 1    # x, y, z
SQUARES: Final = 4  # xx, yy, zz
MIXED: Final = 7    # xy, xz, yz
MOMENTS: Final = 10


@kernel
def area_vectors(points: Array, triangles: Index) -> tuple[Array, Array]:
    """Area along the normal (M, 3) and area (M,) of triangles (M, 3)."""
    count = triangles.shape[0]
    vectors, areas = np.empty((count, 3)), np.empty(count)
    for t in range(count):
        area = area_vector(*triangle_at(points, triangles, t))
        write_row(vectors, t, 0, area)
        areas[t] = length(area)
    return vectors, areas


@inlined
def centroid_of(points: Array, triangles: Index, t: int) -> Vec3:
    """Centroid of a triangle."""
    a, b, c = triangle_at(points, triangles, t)
    return divided(plus(plus(a, b), c), 3.0)


@entry_kernel
def tetrahedra(points: Fixed2, triangles: FixedIndex2) -> Array:
    """Six times the signed volumes (T,) of tetrahedra from the origin to triangles (T, 3)."""
    volumes = np.empty(triangles.shape[0])
    for t in range(triangles.shape[0]):
        volumes[t] = _six_volumes(*triangle_at(points, triangles, t))
    return volumes


@entry_kernel
def solid_moments(points: Fixed2, triangles: FixedIndex2) -> Array:
    """Integrals of 1, x, y, z, xx, yy, zz, xy, xz and yz over the inside of a closed surface.

    `points` (V, 3): of size one, about the middle; `triangles` (T, 3): wound outward; what inward
    ones enclose counts negative. Returns (10,): the sums over the tetrahedra are compensated
    (Neumaier 1974): their errors do not grow with the number of triangles.
    """
    total, lost, term = np.zeros(MOMENTS), np.zeros(MOMENTS), np.empty(MOMENTS)
    for t in range(triangles.shape[0]):
        _set_moments(*triangle_at(points, triangles, t), term)
        for k in range(MOMENTS):
            grown = total[k] + term[k]
            if abs(total[k]) >= abs(term[k]):
                lost[k] += (total[k] - grown) + term[k]
            else:
                lost[k] += (term[k] - grown) + total[k]
            total[k] = grown
    return total + lost


@inlined
def _six_volumes(a: Vec3, b: Vec3, c: Vec3) -> float:
    return dot(a, cross(b, c))


@inlined
def _set_moments(a: Vec3, b: Vec3, c: Vec3, term: Array) -> None:
    """Moments of the tetrahedron of three corners and the origin."""
    volume = _six_volumes(a, b, c) / 6.0
    total = plus(plus(a, b), c)
    squares = plus(plus(plus(times(a, a), times(b, b)), times(c, c)), times(total, total))
    second = 0.05 * volume
    term[VOLUME] = volume
    write_vector(term, FIRST, scaled(total, 0.25 * volume))
    write_vector(term, SQUARES, scaled(squares, second))
    term[MIXED] = second * (a.x * a.y + b.x * b.y + c.x * c.y + total.x * total.y)
    term[MIXED + 1] = second * (a.x * a.z + b.x * b.z + c.x * c.z + total.x * total.z)
    term[MIXED + 2] = second * (a.y * a.z + b.y * b.z + c.y * c.z + total.y * total.z)
