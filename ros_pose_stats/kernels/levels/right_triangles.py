"""The right triangles that a body is cut into, measured for the level sets of r or R.

See `cap_areas` for what they are. For R the triangles around one corner make up the
directions in which that corner is the lowest point, its cell. Once R < E in all of the cell,
which for most corners is long before E = v, their sum is the cell's area; it is then counted
with one triangle of the cell's lowest face, and the others count 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..body.convex_body import BodyArrays
from ..compilation import inlined, kernel

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Flags(NamedTuple):
    """The right triangles of a body, two a polygon side (2 k at its start, 2 k + 1 at its end)."""

    whole: Array   # (2N,) signed area tau
    turn: Array    # (2N,) signed angle t
    near: Array    # (2N,) d
    foot: Array    # (2N,) q
    far: Array     # (2N,) v
    leg: Array     # (2N,) |s| for r, |a| for R: the leg that the circle may cross
    done: Array    # (2N,) level from which on the triangle counts a fixed area
    after: Array   # (2N,) that area
    enters: Array  # (F,) level at which a face enters the reachable set
    fills: Array   # (F,) level from which on all its triangles are done
    full: Array    # (F,) their sum then
    partial: NDArray[np.bool_]  # (F,) whether a wanted level lies between; else not measured


@kernel
def make_flags(body: BodyArrays, levels: Array, of_R: bool) -> Flags:
    """Measure the triangles of the faces that some of the (rising) levels cut through."""
    count, faces = 2 * body.twin.shape[0], body.distance.shape[0]
    # Columns of one table: few triangles are measured, and these touch few pages of memory.
    table = np.empty((count, 8))
    flags = Flags(table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4], table[:, 5],
                  table[:, 6], table[:, 7], np.empty(faces), np.zeros(faces), np.zeros(faces),
                  np.empty(faces, np.bool_))
    if of_R:
        _limits_R(body, levels[-1], flags)
    else:
        _limits_r(body, flags)
    for f in range(faces):
        cut = _first_above(levels, flags.enters[f])
        flags.partial[f] = cut < levels.shape[0] and levels[cut] < flags.fills[f]
        if flags.partial[f]:
            for k in range(body.face_start[f], body.face_start[f + 1]):
                v, w = body.radius[body.corner[k]], body.radius[body.corner[body.twin[k]]]
                _measure(flags, 2 * k, body.distance[f], body.reach[k], v, body.inset[k],
                         body.start[k], of_R)
                _measure(flags, 2 * k + 1, body.distance[f], body.reach[k], w, body.inset[k],
                         body.stop[k], of_R)
    return flags


@inlined
def _first_above(levels: Array, value: float) -> int:
    """Number of the first of the rising levels that is above a value."""
    low, high = 0, levels.shape[0]
    while low < high:
        middle = (low + high) // 2
        if levels[middle] > value:
            high = middle
        else:
            low = middle + 1
    return low


@kernel
def _measure(flags: Flags, i: int, d: float, q: float, v: float, s: float, a: float,
             of_R: bool) -> None:
    flags.near[i], flags.foot[i], flags.far[i] = d, q, v
    flags.whole[i] = 2.0 * math.atan(s * a / ((d + q) * (q + v)))
    if of_R:
        flags.leg[i] = abs(a)
        turn = math.atan2(abs(s) * v, abs(a) * d)
    else:
        flags.leg[i] = abs(s)
        turn = math.atan2(abs(a), abs(s))
        flags.done[i], flags.after[i] = v, flags.whole[i]
    flags.turn[i] = turn if s * a > 0.0 else -turn


@kernel
def _limits_r(body: BodyArrays, flags: Flags) -> None:
    for f in range(body.distance.shape[0]):
        nearest, farthest = math.inf, 0.0
        inside = True
        for k in range(body.face_start[f], body.face_start[f + 1]):
            v = body.radius[body.corner[k]]
            farthest = max(farthest, v)
            inside = inside and body.inset[k] >= 0.0
            nearest = min(nearest,
                          body.reach[k] if body.start[k] > 0.0 and body.stop[k] > 0.0 else v)
        flags.fills[f] = farthest
        flags.enters[f] = body.distance[f] if inside else nearest
        flags.full[f] = body.angle[f]


@kernel
def _ring(face_start: Index, face: Index, twin: Index) -> Index:
    """Next side (N,) that starts at the corner where a side starts, all the way round."""
    ring = np.empty(twin.shape[0], np.int64)
    for k in range(twin.shape[0]):
        other = twin[k]
        f = face[other]
        ring[k] = other + 1 if other + 1 < face_start[f + 1] else face_start[f]
    return ring


@kernel
def _limits_R(body: BodyArrays, highest: float, flags: Flags) -> None:
    """Walk around each corner: highest R in its cell, its area and its lowest face."""
    face_start, face, twin, corner = body.face_start, body.face, body.twin, body.corner
    inset, start, reach, distance = body.inset, body.start, body.reach, body.distance
    done, after, fills = flags.done, flags.after, flags.fills
    ring = _ring(face_start, face, twin)
    seen = np.zeros(body.radius.shape[0], np.bool_)
    flags.enters[:] = distance
    for k in range(twin.shape[0]):
        if seen[corner[k]]:
            continue
        seen[corner[k]] = True
        top, lowest, peak = 0.0, k, True
        side = k
        for _ in range(twin.shape[0]):
            other = twin[side]
            top = max(top, distance[face[side]])
            if inset[side] > 0.0 and inset[other] > 0.0:
                top = max(top, reach[side])
            peak = peak and start[side] >= 0.0
            if distance[face[side]] < distance[face[lowest]]:
                lowest = side
            side = ring[side]
            if side == k:
                break
        if peak:
            top = body.radius[corner[k]]
        for _ in range(twin.shape[0]):
            f = face[side]
            before = side - 1 if side > face_start[f] else face_start[f + 1] - 1
            done[2 * side] = done[2 * before + 1] = top
            after[2 * side] = after[2 * before + 1] = 0.0
            fills[f] = max(fills[f], top)
            side = ring[side]
            if side == k:
                break
        if top <= highest:
            area = _cell_area(body.normal, face, ring, k)
            after[2 * lowest] = area
            flags.full[face[lowest]] += area


@kernel
def _cell_area(normal: Array, face: Index, ring: Index, k: int) -> float:
    """Solid angle of the spherical polygon of the normals around a corner."""
    a = face[k]
    ax, ay, az = normal[a, 0], normal[a, 1], normal[a, 2]
    side = ring[k]
    b = face[side]
    bx, by, bz = normal[b, 0], normal[b, 1], normal[b, 2]
    side = ring[side]
    total = 0.0
    while side != k:
        c = face[side]
        cx, cy, cz = normal[c, 0], normal[c, 1], normal[c, 2]
        triple = (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz)
                  + az * (bx * cy - by * cx))
        below = (1.0 + ax * bx + ay * by + az * bz + bx * cx + by * cy + bz * cz
                 + cx * ax + cy * ay + cz * az)
        total += 2.0 * math.atan2(triple, below)
        bx, by, bz = cx, cy, cz
        side = ring[side]
    return abs(total)
