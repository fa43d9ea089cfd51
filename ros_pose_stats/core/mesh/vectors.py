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

"""Products and lengths of 3-vectors, component by component.

A matrix product rounds differently from one processor to the next, and with the number
of rows; single additions and multiplications do not.
"""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.body.standing import matrices_of, quaternions_down
from ..kernels.mesh.measures import bounds
from ..records import Array, Corners


def turn_vectors(vectors: Array, matrix: Array) -> Array:
    """Product of rows (n, 3) with a matrix (3, 3): `vectors @ matrix`."""
    x = vectors[:, :1]
    y = vectors[:, 1:2]
    z = vectors[:, 2:]
    return np.asarray(x * matrix[0] + y * matrix[1] + z * matrix[2])


def lengths(vectors: Array) -> Array:
    """Lengths (n,) of vectors (n, 3)."""
    x, y, z = vectors.T
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def unit_vectors(vectors: Array) -> Array:
    """Vectors (n, 3) scaled to length one; zeros stay."""
    length = lengths(vectors)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0)[:, None])


def cross(a: Array, b: Array) -> Array:
    """Vector products of vectors, each (n, 3) or (3,), quickly."""
    x, y, z = a.T
    u, v, w = b.T
    return np.array((y * w - z * v, z * u - x * w, x * v - y * u)).T


def length(vector: Array) -> float:
    """Length of a vector (3,)."""
    x, y, z = vector.tolist()
    return math.sqrt(x * x + y * y + z * z)


def components_along(vectors: Array, axis: Array) -> Array:
    """Components (n,) of vectors (n, 3) along an axis."""
    x, y, z = vectors.T
    return np.asarray(x * axis[0] + y * axis[1] + z * axis[2])


def area_vectors(points: Array, triangles: Corners) -> Array:
    """Normals (T, 3) of triangles, twice as long as their areas are large."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))


def loop_area(corners: Array) -> Array:
    """Normal of a loop (n, 3), as long as its area is large."""
    spokes = corners - corners[0]
    crosses: Array = np.cross(spokes, np.roll(spokes, -1, axis=0))
    return np.asarray(crosses.sum(axis=0) / 2.0)


def loop_normal(corners: Array) -> Array:
    """Unit normal of a loop (n, 3); zeros where it has no area."""
    return np.asarray(unit_vectors(loop_area(corners)[None])[0])


def surface_area(points: Array, triangles: Corners) -> float:
    """Area of triangles (T, 3)."""
    return float(lengths(area_vectors(points, triangles)).sum()) / 2.0


class UnitPoints(NamedTuple):
    """Points about the centre of their bounding box, of size one."""

    points: Array  # (N, 3); `(original - center) / size`
    center: Array  # (3,); of the bounding box, metres
    size: float  # its largest extent, metres


def to_unit_size(points: Array) -> UnitPoints:
    """Bring points (N, 3) to size one, about the centre of their bounding box."""
    points = np.ascontiguousarray(points)
    low, high = bounds(points)
    center = low + 0.5 * (high - low)
    size = float((high - low).max())
    return UnitPoints((points - center) / size, center, size)


def scatter(points: Array) -> Array:
    """Mean products (3, 3) of the components of points (n, 3) about their mean."""
    rows = np.ascontiguousarray((points - points.sum(axis=0) / len(points)).T)
    products = rows[[0, 1, 2, 0, 0, 1]] * rows[[0, 1, 2, 1, 2, 2]]
    xx, yy, zz, xy, xz, yz = (products.sum(axis=1) / len(points)).tolist()
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def resting_quaternions(downs: Array) -> Array:
    """Smallest rotations (P, 4), x y z w, that take each `down` (P, 3) to -z.

    Of the part frame in the plate frame. At +z the half turn about the part's x axis is
    taken.
    """
    return quaternions_down(np.array(downs, dtype=np.float64, order="C"))


def rotation_matrices(quaternions: Array) -> Array:
    """Rotation matrices (P, 3, 3) of unit quaternions (P, 4), x y z w."""
    return matrices_of(np.array(quaternions, dtype=np.float64, order="C"))
