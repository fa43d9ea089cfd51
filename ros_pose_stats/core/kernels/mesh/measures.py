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

"""Areas and moments of triangles and what they enclose; extents of points."""

import math

import numpy as np

from ..array_types import Array, Fixed2, FixedIndex2, Index
from ..compilation import entry_kernel, inlined, kernel
from ..vectors import (
    Vec3,
    add,
    area_vector,
    cross,
    divide,
    dot,
    length,
    point_at,
    products,
    scale,
    subtract,
    triangle_at,
    write_row,
    write_vector,
)

# the moments (10,) of a solid: integrals of
VOLUME = 0  # 1
FIRST = 1  # x, y, z
SQUARES = 4  # xx, yy, zz
MIXED = 7  # xy, xz, yz
MOMENTS = 10


@kernel
def area_vectors(points: Array, triangles: Index) -> tuple[Array, Array]:
    """Area along the normal (M, 3) and area (M,) of triangles (M, 3)."""
    count = triangles.shape[0]
    vectors = np.empty((count, 3))
    areas = np.empty(count)
    for t in range(count):
        area = area_vector(*triangle_at(points, triangles, t))
        write_row(vectors, t, 0, area)
        areas[t] = length(area)
    return vectors, areas


@inlined
def centroid_of(points: Array, triangles: Index, t: int) -> Vec3:
    """Centroid of a triangle."""
    a, b, c = triangle_at(points, triangles, t)
    return divide(add(add(a, b), c), 3.0)


@entry_kernel
def tetrahedra(points: Fixed2, triangles: FixedIndex2) -> Array:
    """Six times the signed volumes (T,) of tetrahedra from the origin to triangles."""
    volumes = np.empty(triangles.shape[0])
    for t in range(triangles.shape[0]):
        volumes[t] = _six_volumes(*triangle_at(points, triangles, t))
    return volumes


@entry_kernel
def solid_moments(points: Fixed2, triangles: FixedIndex2) -> Array:
    """Integrals of 1, x, y, z, xx, yy, zz, xy, xz, yz within a closed surface.

    The sums over the tetrahedra are compensated (Neumaier 1974): their errors do not
    grow with the number of triangles.
    """
    total = np.zeros(MOMENTS)
    correction = np.zeros(MOMENTS)
    term = np.empty(MOMENTS)
    for t in range(triangles.shape[0]):
        _write_moments(*triangle_at(points, triangles, t), term)
        for k in range(MOMENTS):
            total_after = total[k] + term[k]
            if abs(total[k]) >= abs(term[k]):
                correction[k] += (total[k] - total_after) + term[k]
            else:
                correction[k] += (term[k] - total_after) + total[k]
            total[k] = total_after
    return total + correction


@inlined
def _six_volumes(a: Vec3, b: Vec3, c: Vec3) -> float:
    return dot(a, cross(b, c))


@inlined
def _write_moments(a: Vec3, b: Vec3, c: Vec3, term: Array) -> None:
    """Moments of the tetrahedron of three corners and the origin."""
    volume = _six_volumes(a, b, c) / 6.0
    total = add(add(a, b), c)
    squares = add(
        add(add(products(a, a), products(b, b)), products(c, c)),
        products(total, total),
    )
    second = 0.05 * volume
    term[VOLUME] = volume
    write_vector(term, FIRST, scale(total, 0.25 * volume))
    write_vector(term, SQUARES, scale(squares, second))
    term[MIXED] = second * (a.x * a.y + b.x * b.y + c.x * c.y + total.x * total.y)
    term[MIXED + 1] = second * (a.x * a.z + b.x * b.z + c.x * c.z + total.x * total.z)
    term[MIXED + 2] = second * (a.y * a.z + b.y * b.z + c.y * c.z + total.y * total.z)


@entry_kernel
def bounds(points: Fixed2) -> tuple[Array, Array]:
    """Lowest and highest coordinates (3,) of points (N, 3), N at least 1."""
    low = np.empty(3)
    high = np.empty(3)
    for c in range(3):
        lowest = highest = points[0, c]
        for i in range(points.shape[0]):
            lowest = min(lowest, points[i, c])
            highest = max(highest, points[i, c])
        low[c] = lowest
        high[c] = highest
    return low, high


@entry_kernel
def coordinate_digits(points: Fixed2) -> tuple[float, bool]:
    """Largest coordinate but for its sign, and whether all are float32 numbers."""
    largest = 0.0
    is_single = True
    for i in range(points.shape[0]):
        for c in range(3):
            largest = max(largest, abs(points[i, c]))
            is_single = is_single and np.float32(points[i, c]) == points[i, c]
    return largest, is_single


@entry_kernel
def thinness(points: Fixed2) -> float:
    """Smallest extent of points of size one over their longest line; 0 if flat.

    The thickness is measured across the plane of the longest line and the point
    farthest from it, so that it does not depend on how the points lie in their frame.
    """
    first = 0
    last = 0
    largest = 0.0
    for c in range(3):
        lowest = 0
        highest = 0
        for i in range(points.shape[0]):
            if points[i, c] < points[lowest, c]:
                lowest = i
            if points[i, c] > points[highest, c]:
                highest = i
        extent = points[highest, c] - points[lowest, c]
        if extent > largest:
            first = lowest
            last = highest
            largest = extent
    first_point = point_at(points, first)
    line = subtract(point_at(points, last), first_point)
    longest = length(line)
    line = divide(line, longest)
    farthest = Vec3(0.0, 0.0, 0.0)
    widest = 0.0
    for i in range(points.shape[0]):
        offset = subtract(point_at(points, i), first_point)
        offset = subtract(offset, scale(line, dot(offset, line)))
        square = dot(offset, offset)
        if square > widest:
            farthest = offset
            widest = square
    width = math.sqrt(widest)
    if width == 0.0:
        return 0.0
    normal = divide(cross(line, farthest), width)
    lowest_offset = math.inf
    highest_offset = -math.inf
    for i in range(points.shape[0]):
        height = dot(point_at(points, i), normal)
        lowest_offset = min(lowest_offset, height)
        highest_offset = max(highest_offset, height)
    return min(width, highest_offset - lowest_offset) / longest
