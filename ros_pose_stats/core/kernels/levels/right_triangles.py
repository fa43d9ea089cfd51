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

"""The right triangles that a body is cut into, measured for the level sets of r or R.

On a face, {r < E} is the part of the polygon inside a circle about the foot of the
centre of mass; on the sphere, {R < E} is what the caps {u : v·u >= E} of the corners
leave free. Both are cut into the right spherical triangles with corners n (the face's
normal), Q/|Q| (foot on a side) and v/|v| (corner) of `body`, taken with the sign of
s·a: the legs are b = atan(s/d) between n and Q, and c = atan(a/q) between Q and v. The
area tau of such a triangle follows from tan(tau/2) = tan(b/2) tan(c/2) = s a / ((d +
q)(q + v)).

While E grows, a triangle's share of the reachable set goes through these stages:

==============  ========================  ===============================
stage           {r < E}                   {R < E}
==============  ========================  ===============================
E <= d          0                         0
d < E <= q      t (1 - d/E), a sector     tau - t (1 - E/v) - bend, a
                about n                   sector about v cut by the far leg
q < E < v       t (1 - d/E) + bend        tau - t (1 - E/v)
E >= v          tau                       tau
==============  ========================  ===============================

with t the triangle's angle at n (for r) or at v (for R), and `bend` where the circle
crosses the leg opposite to its centre.

For R the triangles around one corner make up the directions in which that corner is the
lowest point, its cell. Once R < E in all of the cell, which for most corners is long
before E = v, their sum is the cell's area; it is then counted with one triangle of the
cell's lowest face, and the others count 0.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Flags
from ..body.convex_body import BodyArrays
from ..compilation import inlined, kernel
from ..vectors import cross, dot, dot_from, point_at


class RightTriangles(NamedTuple):
    """The right triangles of a body: 2 k at the start of side k, 2 k + 1 at its end."""

    area: Array  # (2N,) signed area tau
    turn: Array  # (2N,) signed angle t
    distance: Array  # (2N,) d
    reach: Array  # (2N,) q
    radius: Array  # (2N,) v
    leg: Array  # (2N,) |s| for r, |a| for R: the leg that the circle may cross
    final_level: Array  # (2N,) level from which on the triangle counts a fixed area
    final_area: Array  # (2N,) that area
    entry_level: Array  # (F,) level at which a face enters the reachable set
    full_level: Array  # (F,) level from which on all its triangles are done
    full_area: Array  # (F,) their sum then
    is_cut: Flags  # (F,) whether a wanted level lies between; else not measured


@kernel
def measure_triangles(body: BodyArrays, levels: Array, of_R: bool) -> RightTriangles:
    """Measure the triangles of the faces that some of the rising levels cut."""
    count = 2 * body.twin.shape[0]
    faces = body.distance.shape[0]
    # Columns of one table: few triangles are measured, and these touch few pages of
    # memory.
    table = np.empty((count, 8))
    triangles = RightTriangles(
        table[:, 0],
        table[:, 1],
        table[:, 2],
        table[:, 3],
        table[:, 4],
        table[:, 5],
        table[:, 6],
        table[:, 7],
        np.empty(faces),
        np.zeros(faces),
        np.zeros(faces),
        np.empty(faces, np.bool_),
    )
    if of_R:
        _write_limits_R(body, levels[-1], triangles)
    else:
        _write_limits_r(body, triangles)
    for f in range(faces):
        cut = _first_above(levels, triangles.entry_level[f])
        triangles.is_cut[f] = (
            cut < levels.shape[0] and levels[cut] < triangles.full_level[f]
        )
        if triangles.is_cut[f]:
            for k in range(body.face_start[f], body.face_start[f + 1]):
                _measure_side(body, k, body.distance[f], of_R, triangles)
    return triangles


@inlined
def _first_above(levels: Array, threshold: float) -> int:
    """Number of the first of the rising levels that is above a value."""
    low = 0
    high = levels.shape[0]
    while low < high:
        middle = (low + high) // 2
        if levels[middle] > threshold:
            high = middle
        else:
            low = middle + 1
    return low


@inlined
def _measure_side(
    body: BodyArrays, k: int, d: float, of_R: bool, triangles: RightTriangles
) -> None:
    """Both triangles of a polygon side on a face at distance d."""
    q = body.reach[k]
    s = body.inset[k]
    v = body.radius[body.corner[k]]
    w = body.radius[body.corner[body.twin[k]]]
    _measure_triangle(triangles, 2 * k, d, q, v, s, body.start[k], of_R)
    _measure_triangle(triangles, 2 * k + 1, d, q, w, s, body.stop[k], of_R)


@kernel
def _measure_triangle(
    triangles: RightTriangles,
    i: int,
    d: float,
    q: float,
    v: float,
    s: float,
    a: float,
    of_R: bool,
) -> None:
    triangles.distance[i] = d
    triangles.reach[i] = q
    triangles.radius[i] = v
    triangles.area[i] = 2.0 * math.atan(s * a / ((d + q) * (q + v)))
    if of_R:
        triangles.leg[i] = abs(a)
        turn = math.atan2(abs(s) * v, abs(a) * d)
    else:
        triangles.leg[i] = abs(s)
        turn = math.atan2(abs(a), abs(s))
        triangles.final_level[i] = v
        triangles.final_area[i] = triangles.area[i]
    triangles.turn[i] = turn if s * a > 0.0 else -turn


@kernel
def _write_limits_r(body: BodyArrays, triangles: RightTriangles) -> None:
    for f in range(body.distance.shape[0]):
        nearest = math.inf
        farthest = 0.0
        is_foot_inside = True
        for k in range(body.face_start[f], body.face_start[f + 1]):
            v = body.radius[body.corner[k]]
            farthest = max(farthest, v)
            is_foot_inside = is_foot_inside and body.inset[k] >= 0.0
            nearest = min(
                nearest,
                body.reach[k] if body.start[k] > 0.0 and body.stop[k] > 0.0 else v,
            )
        triangles.full_level[f] = farthest
        triangles.entry_level[f] = body.distance[f] if is_foot_inside else nearest
        triangles.full_area[f] = body.angle[f]


@kernel
def _write_limits_R(
    body: BodyArrays, highest: float, triangles: RightTriangles
) -> None:
    """Close the cell of each corner, and put its area where it is counted."""
    is_seen = np.zeros(body.radius.shape[0], np.bool_)
    triangles.entry_level[:] = body.distance
    for k in range(body.corner.shape[0]):
        if is_seen[body.corner[k]]:
            continue
        is_seen[body.corner[k]] = True
        top_level, lowest = _highest_in_cell(body, k)
        _close_cell(body, k, top_level, triangles)
        if top_level <= highest:
            area = _cell_area(body, k)
            triangles.final_area[2 * lowest] = area
            triangles.full_area[body.face[lowest]] += area


@inlined
def _next_around(body: BodyArrays, side: int) -> int:
    """Next side that starts at the corner where a side starts."""
    return int(body.next_side[body.twin[side]])


@inlined
def _highest_in_cell(body: BodyArrays, k: int) -> tuple[float, int]:
    """Highest R around the corner where side k starts, and the lowest face's side."""
    distance = body.distance
    face = body.face
    top_level = 0.0
    lowest = k
    is_peak = True
    side = k
    for _ in range(face.shape[0]):
        top_level = max(top_level, distance[face[side]])
        if body.inset[side] > 0.0 and body.inset[body.twin[side]] > 0.0:
            top_level = max(top_level, body.reach[side])
        is_peak = is_peak and body.start[side] >= 0.0
        if distance[face[side]] < distance[face[lowest]]:
            lowest = side
        side = _next_around(body, side)
        if side == k:
            break
    return body.radius[body.corner[k]] if is_peak else top_level, lowest


@inlined
def _close_cell(
    body: BodyArrays, k: int, top_level: float, triangles: RightTriangles
) -> None:
    """Let the triangles around the start of side k count 0 from `top_level` on."""
    side = k
    for _ in range(body.face.shape[0]):
        f = body.face[side]
        previous = side - 1 if side > body.face_start[f] else body.face_start[f + 1] - 1
        for i in (2 * side, 2 * previous + 1):
            triangles.final_level[i] = top_level
            triangles.final_area[i] = 0.0
        triangles.full_level[f] = max(triangles.full_level[f], top_level)
        side = _next_around(body, side)
        if side == k:
            break


@kernel
def _cell_area(body: BodyArrays, k: int) -> float:
    """Solid angle of the spherical polygon of the normals around a corner."""
    normal = body.normal
    face = body.face
    a = point_at(normal, face[k])
    side = _next_around(body, k)
    b = point_at(normal, face[side])
    side = _next_around(body, side)
    total = 0.0
    while side != k:
        c = point_at(normal, face[side])
        denominator = dot_from(dot_from(dot_from(1.0, a, b), b, c), c, a)
        total += 2.0 * math.atan2(dot(a, cross(b, c)), denominator)
        b = c
        side = _next_around(body, side)
    return abs(total)


@kernel
def bend_r(leg: float, d: float, q: float, level: float) -> float:
    """Correction to the sector where the circle about n crosses the side; q < level."""
    chord = math.sqrt((level - q) * (level + q))
    return 2.0 * math.atan(leg * chord / ((d + q) * (q + level))) - math.atan2(
        chord, leg
    ) * ((level - d) / level)


@kernel
def bend_R(leg: float, v: float, q: float, level: float) -> float:
    """Correction to the sector where the circle about v crosses the arc; level < q."""
    chord = math.sqrt((q - level) * (q + level))
    return 2.0 * math.atan(leg * chord / ((q + v) * (q + level))) - math.atan2(
        chord * v, leg * level
    ) * ((v - level) / v)
