"""The toppling graph of the quasi-static estimators (section 4.B).

A part standing on an unstable face rolls over one of its sides onto a neighbour whose plane
is closer to the centre of mass, so that the graph has no cycle.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...tolerances import SAME_EDGE, TIP_MARGIN
from ..compilation import inlined, kernel
from .convex_body import BodyArrays
from .descent import end_of, is_lower

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@kernel
def toppling(points: Array, body: BodyArrays, beyond: Index,
             parent: Index) -> tuple[Index, Array]:
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
    face_start, corner = body.face_start, body.corner
    normal, distance, inset = body.normal, body.distance, body.inset
    faces = parent.shape[0]
    target = np.full((faces, 2), -1, np.int64)
    share = np.zeros((faces, 2))
    for f in range(faces):
        if parent[f] == f:
            continue
        _pierced(points, face_start, corner, beyond, normal, distance, inset, f, target)
        if target[f, 0] < 0:
            target[f, 0] = end_of(parent, f)
        if target[f, 1] < 0:
            share[f, 0] = 1.0
        else:
            share[f, 0] = share[f, 1] = 0.5
    return target, share


@inlined
def _pierced(points: Array, face_start: Index, corner: Index, beyond: Index, normal: Array,
             distance: Array, inset: Array, f: int, target: Index) -> None:
    """Find the side that the segment from centroid to foot leaves through."""
    begin, end = face_start[f], face_start[f + 1]
    nx, ny, nz = normal[f, 0], normal[f, 1], normal[f, 2]
    cx, cy, cz = polygon_centroid(points, corner, begin, end, nx, ny, nz)
    first, exit_side = math.inf, -1
    for k in range(begin, end):
        if inset[k] > TIP_MARGIN:
            continue
        v, w = corner[k], corner[k + 1 if k + 1 < end else begin]
        inside = _inset_of(points, v, w, nx, ny, nz, cx, cy, cz)
        if inside <= inset[k]:
            continue
        crossing = inside / (inside - inset[k])
        if crossing < first and is_lower(distance, beyond[k], f):
            first, exit_side = crossing, k
    if exit_side < 0:
        return
    target[f, 0] = beyond[exit_side]
    after = exit_side + 1 if exit_side + 1 < end else begin
    before = exit_side - 1 if exit_side > begin else end - 1
    # From the centroid to the foot of the centre of mass.
    d = distance[f]
    ux, uy, uz = d * nx - cx, d * ny - cy, d * nz - cz
    if _off_line(points, corner[after], nx, ny, nz, cx, cy, cz, ux, uy, uz) < SAME_EDGE:
        beside = after
    elif _off_line(points, corner[exit_side], nx, ny, nz, cx, cy, cz, ux, uy, uz) < SAME_EDGE:
        beside = before
    else:
        return
    other = beyond[beside]
    if is_lower(distance, other, f):
        target[f, 1] = other


@inlined
def _off_line(points: Array, p: int, nx: float, ny: float, nz: float, x: float, y: float,
              z: float, ux: float, uy: float, uz: float) -> float:
    """Distance of a point of a face from the line through x y z along u in the face."""
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    px, py, pz = points[p, 0] - x, points[p, 1] - y, points[p, 2] - z
    across = (nx * (uy * pz - uz * py) + ny * (uz * px - ux * pz)
              + nz * (ux * py - uy * px))
    return float(abs(across) / length)


@inlined
def polygon_centroid(points: Array, corner: Index, begin: int, end: int, nx: float, ny: float,
                     nz: float) -> tuple[float, float, float]:
    """Centroid of the area of the face with the corners `corner[begin:end]` and normal n."""
    p = corner[begin]
    px, py, pz = points[p, 0], points[p, 1], points[p, 2]
    total = sx = sy = sz = 0.0
    for k in range(begin + 1, end - 1):
        q, r = corner[k], corner[k + 1]
        ax, ay, az = points[q, 0] - px, points[q, 1] - py, points[q, 2] - pz
        bx, by, bz = points[r, 0] - px, points[r, 1] - py, points[r, 2] - pz
        weight = (nx * (ay * bz - az * by) + ny * (az * bx - ax * bz)
                  + nz * (ax * by - ay * bx))
        total += weight
        sx += weight * (ax + bx)
        sy += weight * (ay + by)
        sz += weight * (az + bz)
    return (px + sx / (3.0 * total), py + sy / (3.0 * total), pz + sz / (3.0 * total))


@inlined
def _inset_of(points: Array, v: int, w: int, nx: float, ny: float, nz: float, x: float, y: float,
              z: float) -> float:
    """Distance of a place on the face with normal n from its side from v to w, inside positive."""
    vx, vy, vz = points[v, 0], points[v, 1], points[v, 2]
    ex, ey, ez = points[w, 0] - vx, points[w, 1] - vy, points[w, 2] - vz
    length = math.sqrt(ex * ex + ey * ey + ez * ez)
    ix = ny * ez - nz * ey
    iy = nz * ex - nx * ez
    iz = nx * ey - ny * ex
    return float(((x - vx) * ix + (y - vy) * iy + (z - vz) * iz) / length)


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
