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

"""How a body stands on the plate: its rotations, its top and its outline."""

import math

import numpy as np

from ...tolerances import COPLANAR, SAME_POINT
from ..array_types import Array, Fixed1, Fixed2, FixedIndex1, Flags
from ..compilation import entry_kernel, inlined, kernel
from ..sorting import stable_order
from ..vectors import dot, point_at, read_vector
from .convex_body import BodyArrays

POLE = 1e-6
"""Closer than this to +z the axis of the smallest rotation would be rounding noise."""

LEAN = 0.05
"""How far a part may lean while it rolls: cosine of its axis to the vertical. A bolt
that lies on head and thread leans by .02 as the thread's point of contact moves."""


@entry_kernel
def faces_on_roll(
    body: BodyArrays,
    run: FixedIndex1,
    lowest: int,
    axis: Fixed1,
    height: float,
    run_height: float,
) -> Flags:
    """Faces (F,) that a body rolls over about an axis, its origin no higher than that.

    It begins on the face `lowest` and may lean by `LEAN`, as a thread does. Between
    faces of one run (F,) it may rise to `run_height`, as over a tooth.
    """
    axis_direction = read_vector(axis, 0)
    first_lean = dot(point_at(body.normal, lowest), axis_direction)
    is_reached = np.zeros(body.distance.shape[0], np.bool_)
    is_reached[lowest] = True
    queue = np.empty(body.distance.shape[0], np.int64)
    queue[0] = lowest
    size = 1
    position = 0
    while position < size:
        face = queue[position]
        position += 1
        for k in range(body.face_start[face], body.face_start[face + 1]):
            neighbour = body.face[body.twin[k]]
            lean = dot(point_at(body.normal, neighbour), axis_direction)
            if is_reached[neighbour] or abs(lean - first_lean) > LEAN:
                continue
            is_one_run = run[face] >= 0 and run[face] == run[neighbour]
            if _height_over(body, k) <= (run_height if is_one_run else height):
                is_reached[neighbour] = True
                queue[size] = neighbour
                size += 1
    return is_reached


@inlined
def _height_over(body: BodyArrays, k: int) -> float:
    """Greatest height of the origin on the way over a polygon side."""
    twin = body.twin[k]
    if body.inset[k] > 0.0 and body.inset[twin] > 0.0:
        return float(max(body.reach[k], body.reach[twin]))
    return float(max(body.distance[body.face[k]], body.distance[body.face[twin]]))


@entry_kernel
def quaternions_down(downs: Fixed2) -> Array:
    """Quaternions (P, 4), x y z w, of the smallest rotations of (P, 3) to -z."""
    quaternions = np.zeros((downs.shape[0], 4))
    for i in range(downs.shape[0]):
        x, y, z = downs[i]
        if z > 0.0 and math.sqrt(x * x + y * y) < POLE:
            # Half a turn about x first, then the small rotation from (x, -y, -z).
            quaternions[i, 0] = 1.0 + z
            quaternions[i, 2] = -x
            quaternions[i, 3] = -y
        else:
            # 1 - z without losing digits near +z
            turn = (x * x + y * y) / (1.0 + z) if z > 0.0 else 1.0 - z
            quaternions[i, 0] = -y
            quaternions[i, 1] = x
            quaternions[i, 3] = turn
        quaternions[i] /= math.sqrt((quaternions[i] * quaternions[i]).sum())
    return quaternions


@entry_kernel
def matrices_of(quaternions: Fixed2) -> Array:
    """Rotation matrices (P, 3, 3) of unit quaternions (P, 4), x y z w."""
    matrices = np.empty((quaternions.shape[0], 3, 3))
    for i in range(quaternions.shape[0]):
        x, y, z, w = quaternions[i]
        matrices[i, 0] = (
            1 - 2 * (y * y + z * z),
            2 * (x * y - z * w),
            2 * (x * z + y * w),
        )
        matrices[i, 1] = (
            2 * (x * y + z * w),
            1 - 2 * (x * x + z * z),
            2 * (y * z - x * w),
        )
        matrices[i, 2] = (
            2 * (x * z - y * w),
            2 * (y * z + x * w),
            1 - 2 * (x * x + y * y),
        )
    return matrices


@entry_kernel
def tops(points: Fixed2, downs: Fixed2) -> Array:
    """Extent (P,) of the points against each direction (P, 3) from the origin."""
    extents = np.empty(downs.shape[0])
    for p in range(downs.shape[0]):
        lowest = np.inf
        for i in range(points.shape[0]):
            lowest = min(lowest, dot(point_at(points, i), point_at(downs, p)))
        extents[p] = -lowest
    return extents


@entry_kernel
def silhouette(points: Fixed2, body: BodyArrays, rotation: Fixed2) -> Array:
    """Convex outline (k, 2) along the plate's normal, counter-clockwise."""
    up = point_at(rotation, 2)
    on_outline = np.zeros(points.shape[0], np.bool_)
    for k in range(body.twin.shape[0]):
        facing = dot(point_at(body.normal, body.face[k]), up)
        facing_across = dot(point_at(body.normal, body.face[body.twin[k]]), up)
        # Wider than any edge-on face is off, by rounding or merging: more points do no
        # harm.
        if facing >= -10.0 * COPLANAR and facing_across <= 10.0 * COPLANAR:
            on_outline[body.corner[k]] = True
            on_outline[body.corner[body.twin[k]]] = True
    projected = np.empty((on_outline.sum(), 2))
    k = 0
    for i in range(points.shape[0]):
        if on_outline[i]:
            for c in range(2):
                projected[k, c] = dot(point_at(points, i), point_at(rotation, c))
            k += 1
    return _hull_2d(projected)


@kernel
def _hull_2d(points: Array) -> Array:
    """Counter-clockwise hull by Andrew's monotone chain, then thinned out."""
    count = points.shape[0]
    by_y = points[stable_order(points[:, 1])]
    ordered = by_y[stable_order(by_y[:, 0])]
    chain = np.empty((2 * count, 2))
    size = 0
    for sweep in range(2):
        floor = size + 1
        for i in range(count):
            p = ordered[i] if sweep == 0 else ordered[count - 1 - i]
            while size > floor and _turn_at(chain[size - 2], chain[size - 1], p) <= 0.0:
                size -= 1
            chain[size] = p
            size += 1
        size -= 1
    return _thin_out(chain[:size])


@kernel
def _thin_out(chain: Array) -> Array:
    """Drop corners that are doubled or on a straight line, but for rounding."""
    distinct = np.empty_like(chain)
    size = 0
    for i in range(chain.shape[0]):
        if _gap(chain[i], chain[i - 1]) >= SAME_POINT:
            distinct[size] = chain[i]
            size += 1
    corners = np.empty_like(chain)
    count = 0
    for i in range(size):
        predecessor = corners[count - 1] if count > 0 else distinct[(i - 1) % size]
        successor = distinct[(i + 1) % size]
        length = _gap(predecessor, distinct[i]) + _gap(distinct[i], successor)
        if _turn_at(predecessor, distinct[i], successor) >= SAME_POINT * length:
            corners[count] = distinct[i]
            count += 1
    return corners[:count].copy()


@kernel
def _gap(a: Array, b: Array) -> float:
    return float(max(abs(a[0] - b[0]), abs(a[1] - b[1])))


@kernel
def _turn_at(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
