"""How much of a body's turning is gathered in few corners.

A corner's angle defect, 2 pi less the angles of its faces there, is its share of the 4 pi by
which a convex body turns. The sum of the squares of these shares is one over the number of
equal corners. Here shares that lie within a reach of each other count as one corner, the less
the farther they are apart: so a corner that is cut off by a hair, or one more on a straight
edge, changes nothing, as it would with the plain sum.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .body import BodyArrays
from .compilation import entry_kernel, kernel
from .sorting import falling_order

Array = NDArray[np.float64]


@entry_kernel
def corner_crowding(points: Array, body: BodyArrays, reaches: Array) -> Array:
    """Sum over all pairs of corners of both shares times (1 - (distance / reach)^2)^2.

    Parameters
    ----------
    points : (H, 3) array
        Hull points about the centre of mass, at most 1 away from it.
    body : BodyArrays
    reaches : (n,) array
        Rising, in the points' unit; nothing counts from there on.

    Returns
    -------
    (n,) array
        From one over the number of corners, if they are equal and far apart, to 1.
    """
    share = corner_shares(points, body)
    order = falling_order(points[:, 0] + 1.0)
    order = order[share[order] > 0.0]
    x, y, z = points[order, 0], points[order, 1], points[order, 2]
    share = share[order]
    found, within = np.zeros(reaches.shape[0]), 1.0 / (reaches * reaches)
    farthest = reaches[-1]
    for i in range(order.shape[0]):
        found += share[i] * share[i]
        for j in range(i + 1, order.shape[0]):
            if x[i] - x[j] >= farthest:
                break
            square = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 + (z[i] - z[j]) ** 2
            if square < farthest * farthest:
                for n in range(reaches.shape[0]):
                    near = max(1.0 - square * within[n], 0.0)
                    found[n] += 2.0 * share[i] * share[j] * near * near
    return found


@kernel
def corner_shares(points: Array, body: BodyArrays) -> Array:
    """Angle defect (H,) of every point over 4 pi; 0 for those that are no corners."""
    share = np.zeros(points.shape[0])
    for f in range(body.distance.shape[0]):
        begin, end = body.face_start[f], body.face_start[f + 1]
        for k in range(begin, end):
            before = k - 1 if k > begin else end - 1
            after = k + 1 if k + 1 < end else begin
            at = body.corner[k]
            share[at] += _angle(points[body.corner[before]], points[at],
                                points[body.corner[after]])
    for v in range(share.shape[0]):
        if share[v] > 0.0:
            share[v] = max(0.5 - share[v] / (4.0 * math.pi), 0.0)
    return share


@kernel
def _angle(p: Array, at: Array, q: Array) -> float:
    """Angle at a corner between the sides to p and q."""
    ax, ay, az = p[0] - at[0], p[1] - at[1], p[2] - at[2]
    bx, by, bz = q[0] - at[0], q[1] - at[1], q[2] - at[2]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return math.atan2(math.sqrt(x * x + y * y + z * z), ax * bx + ay * by + az * bz)
