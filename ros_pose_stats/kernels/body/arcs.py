"""Arcs along which a part rolls over its edges, measured in the metric of its motion.

While an edge of the hull is down, `down` lies on the great circle between the normals of the
edge's two faces. Q, the foot of the centre of mass on the edge's line, parts this arc into two
halves, one a face; x is the angle from Q towards the face and R = q cos x. On either side of
the arc another corner is the lowest point, so that crossing it means an impact. An arc counts by
the turn at that impact: the angle between the impulses at both corners, in the metric of the
inertia. Where a corner divides an edge, the turns over its two pieces add up to that over the
whole, so that a corner more or less on a straight edge changes nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compilation import kernel
from .convex_body import BodyArrays

Array = NDArray[np.float64]

# Gauss-Legendre points and weights on [-1, 1].
_POINTS = (-0.861136311594053, -0.339981043584856, 0.339981043584856, 0.861136311594053)
_WEIGHTS = (0.347854845137454, 0.652145154862546, 0.652145154862546, 0.347854845137454)

AT_THE_TOP = 1.0 - 1e-13
"""Level over an arc's highest point from which on it is all below: the angle there changes with
the root of the level, and would make much of the rounding of saddles that tie."""

SHORTEST = 1e-24
"""Square of the sine of an arc below which it is none: rounding would give its direction."""


class Arcs(NamedTuple):
    """The half arc of every polygon side, on the side of its face."""

    near: Array   # (N,) smallest x
    far: Array    # (N,) largest x; nothing is there unless it is above `near`
    bottom: Array  # (N,) lowest R
    top: Array    # (N,) highest R
    foot: Array   # (N, 3) unit vector to Q
    along: Array  # (N, 3) unit vector square to it, towards the face's normal
    whole: Array  # (N, 2) its turn summed over the angle, and over the length


@kernel
def make_arcs(points: Array, body: BodyArrays, inertia: Array, inverse: Array) -> Arcs:
    """Measure all half arcs.

    Parameters
    ----------
    points : (H, 3) array
        Hull points about the centre of mass.
    body : BodyArrays
    inertia, inverse : (3, 3) arrays
        Central inertia over the mass, in the square of the points' unit, and its inverse.
    """
    count = body.twin.shape[0]
    arcs = Arcs(np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count),
                np.zeros((count, 3)), np.zeros((count, 3)),
                np.zeros((count, 2)))
    for k in range(count):
        f, t = body.face[k], body.twin[k]
        g = body.face[t]
        arcs.near[k] = max(0.0, -math.atan2(body.inset[t], body.distance[g]))
        arcs.far[k] = max(0.0, math.atan2(body.inset[k], body.distance[f]))
        if arcs.far[k] <= arcs.near[k]:
            continue
        arcs.bottom[k] = body.reach[k] * math.cos(arcs.far[k])
        arcs.top[k] = body.reach[k] * math.cos(arcs.near[k]) * AT_THE_TOP
        v, w = points[body.corner[k]], points[body.corner[t]]
        length = body.start[k] + body.stop[k]
        part = body.start[k] / length
        for i in range(3):
            arcs.foot[k, i] = (v[i] + part * (w[i] - v[i])) / body.reach[k]
        away = 0.0
        for i in range(3):
            away += body.normal[f, i] * arcs.foot[k, i]
        size = 0.0
        for i in range(3):
            arcs.along[k, i] = body.normal[f, i] - away * arcs.foot[k, i]
            size += arcs.along[k, i] ** 2
        if size < SHORTEST:
            arcs.far[k] = arcs.near[k]
            continue
        for i in range(3):
            arcs.along[k, i] /= math.sqrt(size)
        swept, rolled = arc_sums(k, arcs.near[k], points, body, arcs, inertia, inverse)
        arcs.whole[k, 0], arcs.whole[k, 1] = swept, rolled
    return arcs


@kernel
def arc_sums(k: int, near: float, points: Array, body: BodyArrays, arcs: Arcs, inertia: Array,
             inverse: Array) -> tuple[float, float]:
    """Turn summed over the angle and over the length of a half arc from x = `near` on."""
    v, w = points[body.corner[k]], points[body.corner[body.twin[k]]]
    foot, along, q = arcs.foot[k], arcs.along[k], body.reach[k]
    middle, half = 0.5 * (arcs.far[k] + near), 0.5 * (arcs.far[k] - near)
    swept = rolled = 0.0
    down, turn = np.empty(3), np.empty(3)
    for i in range(4):
        x = middle + half * _POINTS[i]
        cosine, sine = math.cos(x), math.sin(x)
        for j in range(3):
            down[j] = cosine * foot[j] + sine * along[j]
            turn[j] = cosine * along[j] - sine * foot[j]
        speed = math.sqrt((q * sine) ** 2 + _rotation(down, turn, inertia))
        turned = half * _WEIGHTS[i] * _turn(down, v, w, inverse)
        swept += turned
        rolled += turned * speed
    return swept, rolled


@kernel
def _form(matrix: Array, ax: float, ay: float, az: float, bx: float, by: float,
          bz: float) -> float:
    """Product a M b."""
    return float(ax * (matrix[0, 0] * bx + matrix[0, 1] * by + matrix[0, 2] * bz)
                 + ay * (matrix[1, 0] * bx + matrix[1, 1] * by + matrix[1, 2] * bz)
                 + az * (matrix[2, 0] * bx + matrix[2, 1] * by + matrix[2, 2] * bz))


@kernel
def _rotation(p: Array, t: Array, inertia: Array) -> float:
    """Twice the rotational energy, over the mass, of moving `down` = p at velocity t.

    The part does not turn about the vertical: p I w = 0.
    """
    x, y, z = p[1] * t[2] - p[2] * t[1], p[2] * t[0] - p[0] * t[2], p[0] * t[1] - p[1] * t[0]
    about = _form(inertia, p[0], p[1], p[2], x, y, z)
    return (_form(inertia, x, y, z, x, y, z)
            - about * about / _form(inertia, p[0], p[1], p[2], p[0], p[1], p[2]))


@kernel
def _turn(p: Array, v: Array, w: Array, inverse: Array) -> float:
    """Angle between the impulses at both corners, in the metric of the inertia."""
    ax, ay, az = v[1] * p[2] - v[2] * p[1], v[2] * p[0] - v[0] * p[2], v[0] * p[1] - v[1] * p[0]
    bx, by, bz = w[1] * p[2] - w[2] * p[1], w[2] * p[0] - w[0] * p[2], w[0] * p[1] - w[1] * p[0]
    first = 1.0 + _form(inverse, ax, ay, az, ax, ay, az)
    second = 1.0 + _form(inverse, bx, by, bz, bx, by, bz)
    both = 1.0 + _form(inverse, ax, ay, az, bx, by, bz)
    return math.atan2(math.sqrt(max(0.0, first * second - both * both)), both)
