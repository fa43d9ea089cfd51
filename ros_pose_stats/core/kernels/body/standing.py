"""How a body stands on the plate: its rotations, its top and its outline."""

import math

import numpy as np

from ...tolerances import COPLANAR, SAME_POINT
from ..array_types import Array, Fixed1, Fixed2
from ..compilation import entry_kernel, kernel
from ..elementary import sine_cosine
from ..sorting import stable_order
from ..vectors import add, cross, dot, point_at, read_vector, scale
from .convex_body import BodyArrays

POLE = 1e-6
"""Closer than this to +z the axis of the smallest rotation would be rounding noise."""

STEPS = 180
"""Of half a degree; a polygon of 192 sides rises by at most 0.00013 between them."""


@entry_kernel
def can_roll(points: Fixed2, down: Fixed1, axis: Fixed1, height: float) -> bool:
    """Whether a body can turn by 90 degrees about an axis with its origin that low.

    Turns both ways count together; `down` (3,): what points down at first.
    """
    first_down = read_vector(down, 0)
    axis_direction = read_vector(axis, 0)
    perpendicular = cross(axis_direction, first_down)
    fixed = scale(axis_direction, dot(axis_direction, first_down))
    free_steps = 0
    for sign in (1.0, -1.0):
        for step in range(1, STEPS + 1):
            sine, cosine = sine_cosine(sign * step * (0.5 * math.pi / STEPS))
            turned_down = add(
                add(scale(first_down, cosine), scale(perpendicular, sine)),
                scale(fixed, 1.0 - cosine),
            )
            height_reached = -math.inf
            for i in range(points.shape[0]):
                height_reached = max(
                    height_reached, dot(point_at(points, i), turned_down)
                )
            if height_reached > height:
                break
            free_steps += 1
    return free_steps >= STEPS


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
