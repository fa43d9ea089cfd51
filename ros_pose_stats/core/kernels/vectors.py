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

"""Vectors in space, kept in registers; all of this is inlined into the kernels.

Sums run from the left to the right and nothing is fused, so that a formula written with
these rounds as it does written out by components.
"""

import math
from typing import NamedTuple

import numpy as np

from .array_types import Array, Index
from .compilation import inlined, kernel


class Vec3(NamedTuple):
    """A vector by its components."""

    x: float
    y: float
    z: float


@inlined
def read_vector(values: Array, first: int) -> Vec3:
    """Three numbers of an array (n,), from `first` on."""
    return Vec3(values[first], values[first + 1], values[first + 2])


@inlined
def read_row(table: Array, row: int | np.uint64, first: int) -> Vec3:
    """Three numbers in a row of an array (n, m), from the column `first` on."""
    return Vec3(table[row, first], table[row, first + 1], table[row, first + 2])


@inlined
def point_at(points: Array, i: int) -> Vec3:
    """Row i of an array (n, 3)."""
    return Vec3(points[i, 0], points[i, 1], points[i, 2])


@inlined
def triangle_at(points: Array, triangles: Index, t: int) -> tuple[Vec3, Vec3, Vec3]:
    """Corners of triangle t of an array (m, 3) of numbers of points."""
    return (
        point_at(points, triangles[t, 0]),
        point_at(points, triangles[t, 1]),
        point_at(points, triangles[t, 2]),
    )


@inlined
def write_vector(values: Array, first: int, a: Vec3) -> None:
    """Set three numbers of an array (n,), from `first` on."""
    values[first] = a.x
    values[first + 1] = a.y
    values[first + 2] = a.z


@inlined
def write_row(table: Array, row: int, first: int, a: Vec3) -> None:
    """Set three numbers in a row of an array (n, m), from the column `first` on."""
    table[row, first] = a.x
    table[row, first + 1] = a.y
    table[row, first + 2] = a.z


@inlined
def add(a: Vec3, b: Vec3) -> Vec3:
    """Sum."""
    return Vec3(a.x + b.x, a.y + b.y, a.z + b.z)


@inlined
def subtract(a: Vec3, b: Vec3) -> Vec3:
    """Difference."""
    return Vec3(a.x - b.x, a.y - b.y, a.z - b.z)


@inlined
def scale(a: Vec3, factor: float) -> Vec3:
    """Product with a number."""
    return Vec3(a.x * factor, a.y * factor, a.z * factor)


@inlined
def divide(a: Vec3, divisor: float) -> Vec3:
    """Quotient by a number."""
    return Vec3(a.x / divisor, a.y / divisor, a.z / divisor)


@inlined
def products(a: Vec3, b: Vec3) -> Vec3:
    """Product by components, as of principal moments and an angular velocity."""
    return Vec3(a.x * b.x, a.y * b.y, a.z * b.z)


@inlined
def quotients(a: Vec3, b: Vec3) -> Vec3:
    """Quotient by components, as of an angular momentum and principal moments."""
    return Vec3(a.x / b.x, a.y / b.y, a.z / b.z)


@inlined
def dot(a: Vec3, b: Vec3) -> float:
    """Scalar product."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def dot_from(start: float, a: Vec3, b: Vec3) -> float:
    """A number, plus the scalar product term by term."""
    return start + a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a: Vec3, b: Vec3) -> Vec3:
    """Vector product."""
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def length(a: Vec3) -> float:
    """Length, by products: Python's power rounds by the C library without numba."""
    return math.sqrt(a.x * a.x + a.y * a.y + a.z * a.z)


@inlined
def transform(matrix: Array, a: Vec3) -> Vec3:
    """Product of a matrix (3, 3) and a vector."""
    return Vec3(
        dot(point_at(matrix, 0), a),
        dot(point_at(matrix, 1), a),
        dot(point_at(matrix, 2), a),
    )


@kernel
def inverse_of(matrix: Array) -> Array:
    """Inverse (3, 3) of a regular matrix (3, 3), by cofactors."""
    cofactors = np.empty((3, 3))
    for row in range(3):
        next_row = (row + 1) % 3
        last_row = (row + 2) % 3
        for column in range(3):
            next_column = (column + 1) % 3
            last_column = (column + 2) % 3
            cofactors[column, row] = (
                matrix[next_row, next_column] * matrix[last_row, last_column]
                - matrix[next_row, last_column] * matrix[last_row, next_column]
            )
    determinant = (
        matrix[0, 0] * cofactors[0, 0]
        + matrix[0, 1] * cofactors[1, 0]
        + matrix[0, 2] * cofactors[2, 0]
    )
    cofactors /= determinant
    return cofactors


@inlined
def area_vector(p: Vec3, q: Vec3, r: Vec3) -> Vec3:
    """Area of a triangle along its normal: half the vector product of two sides."""
    return scale(cross(subtract(q, p), subtract(r, p)), 0.5)


@inlined
def solid_angle(p: Vec3, q: Vec3, r: Vec3) -> float:
    """Signed solid angle of a triangle seen from the origin, steradians.

    The arctangent form of Van Oosterom and Strackee (1983); it keeps full precision for
    small triangles, where the form by arc cosines does not.
    """
    lp = length(p)
    lq = length(q)
    lr = length(r)
    denominator = lp * lq * lr + dot(p, q) * lr + dot(p, r) * lq + dot(q, r) * lp
    return 2.0 * math.atan2(dot(p, cross(q, r)), denominator)
