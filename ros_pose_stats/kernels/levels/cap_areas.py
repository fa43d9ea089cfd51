"""Centroid solid angles of the reachable set on a face, in closed form.

On a face, {r < E} is the part of the polygon inside a circle about the foot of the centre
of mass; on the sphere, {R < E} is what the caps {u : v·u >= E} of the corners leave free.
Both are cut into the right spherical triangles with corners n (the face's normal), Q/|Q|
(foot on a side) and v/|v| (corner) of `body`, taken with the sign of s·a: the legs are
b = atan(s/d) between n and Q, and c = atan(a/q) between Q and v. The area tau of such a
triangle follows from tan(tau/2) = tan(b/2) tan(c/2) = s a / ((d + q)(q + v)).

While E grows, a triangle's share of the reachable set goes through these stages:

==============  =================================  =========================================
stage           {r < E}                            {R < E}
==============  =================================  =========================================
E <= d          0                                  0
d < E <= q      t (1 - d/E), a sector about n      tau - t (1 - E/v) - bend, a sector about
                                                   v cut by the far leg
q < E < v       t (1 - d/E) + bend                 tau - t (1 - E/v)
E >= v          tau                                tau
==============  =================================  =========================================

with t the triangle's angle at n (for r) or at v (for R), and `bend` where the circle
crosses the leg opposite to its centre.
"""

from __future__ import annotations

import math

import numpy as np

from ..array_types import Array, Index
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, inlined, kernel
from .right_triangles import RightTriangles, measure_triangles


@kernel
def bend_r(leg: float, d: float, q: float, level: float) -> float:
    """Correction to the sector where the circle about n crosses the side; q < level."""
    chord = math.sqrt((level - q) * (level + q))
    return (2.0 * math.atan(leg * chord / ((d + q) * (q + level)))
            - math.atan2(chord, leg) * ((level - d) / level))


@kernel
def bend_R(leg: float, v: float, q: float, level: float) -> float:
    """Correction to the sector where the circle about v crosses the dual arc; level < q."""
    chord = math.sqrt((q - level) * (q + level))
    return (2.0 * math.atan(leg * chord / ((q + v) * (q + level)))
            - math.atan2(chord * v, leg * level) * ((v - level) / v))


@kernel
def faces_below(faces: Index, begin: int, end: int, body: BodyArrays, triangles: RightTriangles,
                level: float, of_R: bool) -> float:
    """Centroid solid angle of the reachable set on the faces `faces[begin:end]`.

    That of {r < level} on the faces, or of {R < level} next to their normals.
    """
    face_start = body.face_start
    enters, fills, full = triangles.enters, triangles.fills, triangles.full
    total = 0.0
    for j in range(begin, end):
        f = faces[j]
        if level <= enters[f]:
            continue
        if level >= fills[f]:
            total += full[f]
            continue
        for k in range(face_start[f], face_start[f + 1]):
            total = _add_side(total, triangles, k, level, of_R)
    return total


@inlined
def _add_side(total: float, triangles: RightTriangles, k: int, level: float,
              of_R: bool) -> float:
    """Add the shares of both triangles of a polygon side, stage by stage."""
    turn, leg, foot = triangles.turn, triangles.leg, triangles.foot
    bends = 0.0
    for i in range(2 * k, 2 * k + 2):
        sense = math.copysign(1.0, turn[i])
        if level >= triangles.done[i]:
            total += triangles.after[i]
        elif of_R:
            v = triangles.far[i]
            total += triangles.whole[i] - turn[i] * ((v - level) / v)
            if level < foot[i]:
                total -= sense * bend_R(leg[i], v, foot[i], level)
        else:
            total += turn[i] * ((level - triangles.near[i]) / level)
            bends += sense
    # Both triangles of a side bend alike for r, each in its own sense.
    if bends != 0.0 and level > foot[2 * k]:
        total += bends * bend_r(leg[2 * k], triangles.near[2 * k], foot[2 * k], level)
    return total


@entry_kernel
def areas_below(body: BodyArrays, level: float, of_R: bool) -> Array:
    """Centroid solid angle of the reachable set on each face, steradians.

    Returns (F,): of {r < level} on the face, or of {R < level} next to its normal.
    """
    triangles = measure_triangles(body, np.array([level]), of_R)
    faces = np.arange(body.distance.shape[0])
    angles = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        angles[f] = faces_below(faces, f, f + 1, body, triangles, level, of_R)
    return angles
