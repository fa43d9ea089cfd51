"""The toppling graph of the quasi-static estimators (section 4.B).

A part standing on an unstable face rolls over one of its sides onto a neighbour whose plane
is closer to the centre of mass, so that the graph has no cycle.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..tolerances import SAME_EDGE, TIP_MARGIN
from .body import BodyArrays
from .compilation import kernel
from .descent import end_of, is_lower

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@kernel
def toppling(points: Array, body: BodyArrays, parent: Index) -> tuple[Index, Array]:
    """Toppling graph of the quasi-static estimator (section 4.B).

    An unstable face topples over the side pierced by the segment from its centroid to the
    foot of the centre of mass; where the segment leaves through a corner, both sides there
    take an even share.

    Returns
    -------
    target : (F, 2) array of int
        Faces that take the part, -1 for none.
    share : (F, 2) array
        Fractions, summing to 1 for unstable faces and to 0 for stable ones.
    """
    faces = parent.shape[0]
    target = np.full((faces, 2), -1, np.int64)
    share = np.zeros((faces, 2))
    for f in range(faces):
        if parent[f] == f:
            continue
        _pierced(points, body, f, target)
        if target[f, 0] < 0:
            target[f, 0] = end_of(parent, f)
        if target[f, 1] < 0:
            share[f, 0] = 1.0
        else:
            share[f, 0] = share[f, 1] = 0.5
    return target, share


@kernel
def _pierced(points: Array, body: BodyArrays, f: int, target: Index) -> None:
    """Find the side that the segment from centroid to foot leaves through."""
    begin, end = body.face_start[f], body.face_start[f + 1]
    cx, cy, cz = polygon_centroid(points, body, f)
    first, exit_side = math.inf, -1
    for k in range(begin, end):
        inside = _inset_of(points, body, k, cx, cy, cz)
        if body.inset[k] > TIP_MARGIN or inside <= body.inset[k]:
            continue
        crossing = inside / (inside - body.inset[k])
        if crossing < first and is_lower(body, body.face[body.twin[k]], f):
            first, exit_side = crossing, k
    if exit_side < 0:
        return
    target[f, 0] = body.face[body.twin[exit_side]]
    after = exit_side + 1 if exit_side + 1 < end else begin
    before = exit_side - 1 if exit_side > begin else end - 1
    if _off_line(points, body, f, body.corner[after], cx, cy, cz) < SAME_EDGE:
        beside = after
    elif _off_line(points, body, f, body.corner[exit_side], cx, cy, cz) < SAME_EDGE:
        beside = before
    else:
        return
    other = body.face[body.twin[beside]]
    if is_lower(body, other, f):
        target[f, 1] = other


@kernel
def _off_line(points: Array, body: BodyArrays, f: int, corner: int, x: float, y: float,
              z: float) -> float:
    """Distance of a corner from the line through the centroid and the foot of the face."""
    n, d = body.normal[f], body.distance[f]
    p = points[corner]
    ux, uy, uz = d * n[0] - x, d * n[1] - y, d * n[2] - z
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    px, py, pz = p[0] - x, p[1] - y, p[2] - z
    across = (n[0] * (uy * pz - uz * py) + n[1] * (uz * px - ux * pz)
              + n[2] * (ux * py - uy * px))
    return float(abs(across) / length)


@kernel
def polygon_centroid(points: Array, body: BodyArrays, f: int) -> tuple[float, float, float]:
    """Centroid of a face's area."""
    begin, end = body.face_start[f], body.face_start[f + 1]
    n = body.normal[f]
    p = points[body.corner[begin]]
    total = sx = sy = sz = 0.0
    for k in range(begin + 1, end - 1):
        q, r = points[body.corner[k]], points[body.corner[k + 1]]
        ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
        weight = (n[0] * (ay * bz - az * by) + n[1] * (az * bx - ax * bz)
                  + n[2] * (ax * by - ay * bx))
        total += weight
        sx += weight * (ax + bx)
        sy += weight * (ay + by)
        sz += weight * (az + bz)
    return (p[0] + sx / (3.0 * total), p[1] + sy / (3.0 * total), p[2] + sz / (3.0 * total))


@kernel
def _inset_of(points: Array, body: BodyArrays, k: int, x: float, y: float, z: float) -> float:
    """Distance of a point of the face from side k, positive inside."""
    v = points[body.corner[k]]
    w = points[body.corner[body.twin[k]]]
    n = body.normal[body.face[k]]
    ex, ey, ez = w[0] - v[0], w[1] - v[1], w[2] - v[2]
    length = math.sqrt(ex * ex + ey * ey + ez * ez)
    ix = n[1] * ez - n[2] * ey
    iy = n[2] * ex - n[0] * ez
    iz = n[0] * ey - n[1] * ex
    return float(((x - v[0]) * ix + (y - v[1]) * iy + (z - v[2]) * iz) / length)


@kernel
def settle(initial: Array, target: Index, share: Array) -> Array:
    """Carry initial probabilities of all faces down the toppling graph.

    Parameters
    ----------
    initial : (F,) array
    target, share : (F, 2) arrays
        As from `toppling`.

    Returns
    -------
    (F,) array
        Zero on unstable faces; the sum is that of `initial`.
    """
    faces = initial.shape[0]
    mass = initial.copy()
    waiting = np.zeros(faces, np.int64)
    for f in range(faces):
        for j in range(2):
            if target[f, j] >= 0:
                waiting[target[f, j]] += 1
    ready = np.empty(faces, np.int64)
    size = 0
    for f in range(faces):
        if waiting[f] == 0:
            ready[size] = f
            size += 1
    while size > 0:
        size -= 1
        f = ready[size]
        if target[f, 0] < 0:
            continue
        for j in range(2):
            g = target[f, j]
            if g >= 0:
                mass[g] += share[f, j] * mass[f]
                waiting[g] -= 1
                if waiting[g] == 0:
                    ready[size] = g
                    size += 1
        mass[f] = 0.0
    return mass
