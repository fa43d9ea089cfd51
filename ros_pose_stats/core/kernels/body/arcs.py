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

"""Arcs along which a part rolls over its edges, measured in the metric of its motion.

While an edge of the hull is down, `down` lies on the great circle between the normals
of the edge's two faces. Q, the foot of the centre of mass on the edge's line, parts
this arc into two halves, one a face; x is the angle from Q towards the face and R = q
cos x. On either side of the arc another corner is the lowest point, so that crossing it
means an impact. An arc counts by the turn at that impact: the angle between the
impulses at both corners, in the metric of the inertia. Where a corner divides an edge,
the turns over its two pieces add up to that over the whole, so that a corner more or
less on a straight edge changes nothing.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array
from ..compilation import inlined, kernel
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    inverse_of,
    point_at,
    scale,
    subtract,
    transform,
    write_row,
)
from .convex_body import BodyArrays

# Gauss-Legendre points and weights on [-1, 1].
_POINTS = (-0.861136311594053, -0.339981043584856, 0.339981043584856, 0.861136311594053)
_WEIGHTS = (0.347854845137454, 0.652145154862546, 0.652145154862546, 0.347854845137454)

TOP_SHARE = 1.0 - 1e-13
"""Level over an arc's highest point from which on it is all below.

The angle there changes with the root of the level, and would make much of the rounding
of saddles that tie.
"""

SHORTEST_ARC = 1e-24
"""Squared sine of an arc below which it is none: rounding gives its direction."""

# columns of sums over arcs (2,)
OVER_ANGLE = 0  # its turn over the angle
OVER_LENGTH = 1  # and over the length
SUMS = 2


class Arcs(NamedTuple):
    """The half arc of every polygon side, on the side of its face."""

    lean: Array  # (N,) angle from the face's normal to Q, negative outside of the face
    begin: Array  # (N,) smallest x
    end: Array  # (N,) largest x; nothing is there unless it is above `begin`
    bottom: Array  # (N,) lowest R
    top: Array  # (N,) highest R
    foot: Array  # (N, 3) unit vector to Q
    tangent: Array  # (N, 3) unit vector square to it, towards the face's normal
    points: Array  # (H, 3) hull points of the body
    body: BodyArrays
    inertia: Array  # (3, 3) over the mass
    inverse: Array  # (3, 3) of that


@kernel
def make_arcs(points: Array, body: BodyArrays, inertia: Array, highest: float) -> Arcs:
    """Measure the half arcs that begin below the highest level; others are none.

    `inertia` (3, 3): over the mass.
    """
    count = body.twin.shape[0]
    arcs = Arcs(
        np.empty(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        points,
        body,
        inertia,
        inverse_of(inertia),
    )
    for k in range(count):
        arcs.lean[k] = math.atan2(body.inset[k], body.distance[body.face[k]])
    for k in range(count):
        f = body.face[k]
        t = body.twin[k]
        arcs.begin[k] = max(0.0, -arcs.lean[t])
        arcs.end[k] = max(0.0, arcs.lean[k])
        if arcs.end[k] <= arcs.begin[k]:
            continue
        arcs.bottom[k] = body.reach[k] * math.cos(arcs.end[k])
        arcs.top[k] = body.reach[k] * math.cos(arcs.begin[k]) * TOP_SHARE
        if highest < min(arcs.bottom[k], arcs.top[k]):
            arcs.end[k] = arcs.begin[k]
            continue
        v = point_at(points, body.corner[k])
        w = point_at(points, body.corner[t])
        share = body.start[k] / (body.start[k] + body.stop[k])
        foot = divide(add(v, scale(subtract(w, v), share)), body.reach[k])
        normal = point_at(body.normal, f)
        tangent = subtract(normal, scale(foot, dot(normal, foot)))
        tangent_square = dot(tangent, tangent)
        if tangent_square < SHORTEST_ARC:
            arcs.end[k] = arcs.begin[k]
            continue
        write_row(arcs.foot, k, 0, foot)
        write_row(arcs.tangent, k, 0, divide(tangent, math.sqrt(tangent_square)))
    return arcs


@inlined
def add_arc(sums: Array, arcs: Arcs, k: int, begin: float) -> None:
    """Add what a half arc has from x = `begin` on to sums (SUMS,)."""
    body = arcs.body
    v = point_at(arcs.points, body.corner[k])
    w = point_at(arcs.points, body.corner[body.twin[k]])
    foot = point_at(arcs.foot, k)
    tangent = point_at(arcs.tangent, k)
    center = 0.5 * (arcs.end[k] + begin)
    half = 0.5 * (arcs.end[k] - begin)
    angle = path_length = 0.0
    for i in range(4):
        x = center + half * _POINTS[i]
        cosine = math.cos(x)
        sine = math.sin(x)
        down = add(scale(foot, cosine), scale(tangent, sine))
        turn = subtract(scale(tangent, cosine), scale(foot, sine))
        speed = math.sqrt(
            (body.reach[k] * sine) ** 2 + _rotational_energy(down, turn, arcs.inertia)
        )
        turn_share = half * _WEIGHTS[i] * _impulse_angle(down, v, w, arcs.inverse)
        angle += turn_share
        path_length += turn_share * speed
    sums[OVER_ANGLE] += angle
    sums[OVER_LENGTH] += path_length


@inlined
def _rotational_energy(down: Vec3, turn: Vec3, inertia: Array) -> float:
    """Twice the rotational energy, over the mass, of moving `down`; p I w = 0."""
    spin = cross(down, turn)
    momentum = dot(down, transform(inertia, spin))
    return dot(spin, transform(inertia, spin)) - momentum * momentum / dot(
        down, transform(inertia, down)
    )


@inlined
def _impulse_angle(down: Vec3, v: Vec3, w: Vec3, inverse: Array) -> float:
    """Angle between the impulses at both corners, in the metric of the inertia."""
    a = cross(v, down)
    b = cross(w, down)
    response_v = 1.0 + dot(a, transform(inverse, a))
    response_w = 1.0 + dot(b, transform(inverse, b))
    response_vw = 1.0 + dot(a, transform(inverse, b))
    square = response_v * response_w - response_vw * response_vw
    return math.atan2(math.sqrt(max(0.0, square)), response_vw)
