"""Planar regions and corners of a surface, and moments of the regions.

A sum of products of components is symmetric in them, so it is kept by monomials: of the
1, 3, 9, 27 and 81 products of up to four components of (x, y, z) 1, 3, 6, 10 and 15
differ.
"""

import math

import numpy as np

from ...tolerances import SYMMETRY
from ..array_types import Array, Fixed2, FixedIndex2, Index
from ..body.coplanar import planar_regions
from ..compilation import entry_kernel, inlined, kernel
from ..mesh.connections import triangle_neighbours
from ..mesh.measures import area_vectors, centroid_of
from ..sorting import falling_order
from ..vectors import Vec3, add, divide, dot, point_at, read_row, scale, write_row

# columns of the regions (G, 7) and of the sums that they are made of
CENTROID = 0  # 0, 1, 2; in a sum times the area
NORMAL = 3  # 3, 4, 5: times the size; in a sum times the area
SIZE = 6  # square root of the area; in a sum the area
AREA = 6
REGION = 7

SMALLEST_AREA = SYMMETRY * SYMMETRY
"""Area below which a region is none: of corners on one line rounding makes the normal.
"""


@entry_kernel
def regions_and_corners(
    points: Fixed2, triangles: FixedIndex2, tolerance: float
) -> tuple[Array, Index]:
    """Planar regions (G, 7), largest first, and vertices where three or more meet.

    Centroid, normal times size and size (square root of the area); none below
    `SMALLEST`.
    """
    region = planar_regions(
        points, triangles, triangle_neighbours(triangles), tolerance
    )
    sums = _sum_regions(points, triangles, region)
    return _order_regions(sums), _find_corners(triangles, region, sums, points.shape[0])


@kernel
def _sum_regions(points: Array, triangles: Index, region: Index) -> Array:
    """Area-weighted centroid, area vector and area (G, 7) of the regions."""
    count = 0
    for t in range(region.shape[0]):
        count = max(count, region[t] + 1)
    vectors, areas = area_vectors(points, triangles)
    sums = np.zeros((count, REGION))
    for t in range(region.shape[0]):
        g = region[t]
        moment = scale(centroid_of(points, triangles, t), areas[t])
        write_row(sums, g, CENTROID, add(read_row(sums, g, CENTROID), moment))
        write_row(sums, g, NORMAL, add(read_row(sums, g, NORMAL), point_at(vectors, t)))
        sums[g, AREA] += areas[t]
    return sums


@kernel
def _order_regions(sums: Array) -> Array:
    order = falling_order(sums[:, AREA].copy())
    count = 0
    for g in order:
        if sums[g, AREA] < SMALLEST_AREA:
            break
        count += 1
    regions = np.empty((count, REGION))
    for i in range(count):
        g = order[i]
        size = math.sqrt(sums[g, AREA])
        write_row(
            regions, i, CENTROID, divide(read_row(sums, g, CENTROID), sums[g, AREA])
        )
        write_row(regions, i, NORMAL, divide(read_row(sums, g, NORMAL), size))
        regions[i, SIZE] = size
    return regions


@kernel
def _find_corners(triangles: Index, region: Index, sums: Array, points: int) -> Index:
    """Vertices that touch at least three regions of `SMALLEST` area or more."""
    touched_regions = np.full((points, 2), -1, np.int64)
    is_corner = np.zeros(points, np.bool_)
    count = 0
    for t in range(triangles.shape[0]):
        g = region[t]
        if sums[g, AREA] < SMALLEST_AREA:
            continue
        for i in range(3):
            v = triangles[t, i]
            if _meets_third(touched_regions, v, g) and not is_corner[v]:
                is_corner[v] = True
                count += 1
    corners = np.empty(count, np.int64)
    position = 0
    for v in range(points):
        if is_corner[v]:
            corners[position] = v
            position += 1
    return corners


@inlined
def _meets_third(touched_regions: Index, v: int, g: int) -> bool:
    """Note the first two regions that a vertex touches; tell whether it is a third."""
    for k in range(2):
        if touched_regions[v, k] < 0:
            touched_regions[v, k] = g
        if touched_regions[v, k] == g:
            return False
    return True


# How many products of components are the same monomial, in the order of
# `_write_monomials`.
_MULTIPLICITY = np.concatenate(
    (
        [1.0],
        [1.0, 1.0, 1.0],
        [1.0, 2.0, 2.0, 1.0, 2.0, 1.0],
        [1.0, 3.0, 3.0, 3.0, 6.0, 3.0, 1.0, 3.0, 3.0, 1.0],
        [1.0, 4.0, 4.0, 6.0, 12.0, 6.0, 4.0, 12.0, 12.0, 4.0, 1.0, 4.0, 6.0, 4.0, 1.0],
    )
)

# Where each degree begins in that order.
_DEGREE = (0, 1, 4, 10, 20, 35)

# columns of the moments (S, 7) along a direction u
HEIGHTS = 0  # 0, 1, 2: sums over the regions of A (c·u)^k for k = 2, 3, 4
FLOWS = 3  # 3 ... 6: of A² (n·u) (c·u)^k for k = 0, 1, 2, 3


@entry_kernel
def moments_along(regions: Fixed2, directions: Fixed2) -> Array:
    """Moments (S, 7) of regions along directions, unchanged where both are turned.

    Sums over the regions, of centroid c, normal n and area A, of A (c·u)^k for k = 2,
    3, 4, and of A² (n·u) (c·u)^k for k = 0, 1, 2, 3.
    """
    areas = np.zeros(35)
    flows = np.zeros((3, 20))
    terms = np.empty(35)
    for g in range(regions.shape[0]):
        _write_monomials(read_row(regions, g, CENTROID), terms)
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
        _write_monomials(direction, terms)
        for k in range(4):
            for m in range(_DEGREE[k], _DEGREE[k + 1]):
                flow = dot(direction, Vec3(flows[0, m], flows[1, m], flows[2, m]))
                moments[s, FLOWS + k] += _MULTIPLICITY[m] * terms[m] * flow
        for k in range(2, 5):
            for m in range(_DEGREE[k], _DEGREE[k + 1]):
                moments[s, HEIGHTS + k - 2] += _MULTIPLICITY[m] * terms[m] * areas[m]
    return moments


@inlined
def _write_monomials(a: Vec3, terms: Array) -> None:
    """Set `terms` (35,) to the monomials of degree 0 to 4, each from a lower one."""
    terms[0] = 1.0
    for degree in range(1, 5):
        lower = _DEGREE[degree - 1]
        begin = _DEGREE[degree]
        count = begin - lower
        for m in range(count):
            terms[begin + m] = a.x * terms[lower + m]
        # The last `degree` of the lower ones are free of x, the very last of y too.
        for m in range(degree):
            terms[begin + count + m] = a.y * terms[begin - degree + m]
        terms[begin + count + degree] = a.z * terms[begin - 1]
