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

"""From hull triangles to a convex body: faces, sides and their distances.

Everything that the estimators need of a side e of face f is three lengths. With the
centre of mass at the origin, P the foot of the perpendicular on the face, Q the foot on
the side's line and v the corner where the side starts:

- inset  s: signed distance of P from the side, positive inside the polygon;
- start  a: signed distance from v to Q along the side (`stop` for the far corner);
- reach  q: distance |Q|, with q² = d² + s² and |v|² = q² + a².

The triangle P Q v has its right angle at Q; projected on the unit sphere it is a right
spherical triangle with corners n (normal of the face), Q/|Q| and v/|v|.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Array1, Array2, Fixed2, FixedIndex2, Index, Index1
from ..compilation import entry_kernel, kernel
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    length,
    point_at,
    solid_angle,
    subtract,
    write_row,
)
from .coplanar import opposite_half_edges, orient_triangles, planar_regions
from .polygons import corner_loops


class BodyArrays(NamedTuple):
    """A convex body about its centre of mass, in units of the caller's points."""

    face_start: Index1  # (F + 1,) first side of each face
    corner: Index1  # (N,) hull point where a side starts, counter-clockwise
    face: Index1  # (N,) face of a side
    twin: Index1  # (N,) the same edge seen from the neighbour
    next_side: Index1  # (N,) the next side of the same face
    normal: Array2  # (F, 3) outward
    distance: Array1  # (F,) of the face's plane
    area: Array1  # (F,)
    angle: Array1  # (F,) centroid solid angle, steradians
    inset: Array1  # (N,) s
    start: Array1  # (N,) a at the side's first corner
    stop: Array1  # (N,) a at its last corner
    reach: Array1  # (N,) q
    radius: Array1  # (H,) |v| of every hull point


@entry_kernel
def build_body(
    points: Fixed2, simplices: FixedIndex2, adjacent: FixedIndex2, tolerance: float
) -> tuple[bool, BodyArrays]:
    """Merge coplanar hull triangles into faces and measure them.

    `adjacent[t, i]` lies opposite to vertex i. False where merging at this tolerance
    gives no convex polyhedron around the origin; the arrays then say nothing.
    """
    triangles = simplices.copy()
    neighbors = adjacent.copy()
    orient_triangles(points, triangles, neighbors)
    opposite = opposite_half_edges(triangles, neighbors)
    region = planar_regions(points, triangles, neighbors, tolerance)
    valid, face_start, first, side_of = corner_loops(
        triangles, region, opposite, points.shape[0]
    )
    body = _new_body(face_start, first.shape[0], points.shape[0])
    if not valid:
        return False, body
    for k in range(first.shape[0]):
        body.corner[k] = triangles[first[k] // 3, (first[k] + 1) % 3]
    if not _pair_sides(body, first, side_of, opposite):
        return False, body
    _measure_planes(points, body)
    if body.distance.min() <= 0.0:
        return False, body
    _measure_sides(points, body)
    _measure_angles(points, body)
    return True, body


@kernel
def _new_body(face_start: Index, sides: int, points: int) -> BodyArrays:
    """Body of that many polygon sides and hull points, still to be measured."""
    faces = face_start.shape[0] - 1
    return BodyArrays(
        face_start=face_start,
        corner=np.zeros(sides, np.int64),
        face=np.zeros(sides, np.int64),
        twin=np.zeros(sides, np.int64),
        next_side=np.zeros(sides, np.int64),
        normal=np.zeros((faces, 3)),
        distance=np.zeros(faces),
        area=np.zeros(faces),
        angle=np.zeros(faces),
        inset=np.zeros(sides),
        start=np.zeros(sides),
        stop=np.zeros(sides),
        reach=np.zeros(sides),
        radius=np.zeros(points),
    )


@kernel
def _pair_sides(
    body: BodyArrays, first: Index, side_of: Index, opposite: Index
) -> bool:
    """Fill in twin, face and next side; false where twins differ in their corners.

    `first`, `side_of`: as from `corner_loops`; `opposite`: twin of each half-edge.
    """
    corner = body.corner
    twin = body.twin
    next_side = body.next_side
    for f in range(body.face_start.shape[0] - 1):
        begin = body.face_start[f]
        end = body.face_start[f + 1]
        for k in range(begin, end):
            body.face[k] = f
            next_side[k] = k + 1 if k + 1 < end else begin
    for k in range(twin.shape[0]):
        twin[k] = side_of[opposite[first[k]]]
    for k in range(twin.shape[0]):
        t = twin[k]
        if t < 0 or twin[t] != k:
            return False
        if corner[k] != corner[next_side[t]] or corner[next_side[k]] != corner[t]:
            return False
    return True


@kernel
def _measure_planes(points: Array, body: BodyArrays) -> None:
    """Fill in Newell's normal, distance from the origin and area of each face."""
    corner = body.corner
    for f in range(body.distance.shape[0]):
        begin = body.face_start[f]
        end = body.face_start[f + 1]
        center = Vec3(0.0, 0.0, 0.0)
        for k in range(begin, end):
            center = add(center, point_at(points, corner[k]))
        center = divide(center, float(end - begin))
        normal = Vec3(0.0, 0.0, 0.0)
        for k in range(begin, end):
            p = point_at(points, corner[k])
            q = point_at(points, corner[k + 1 if k + 1 < end else begin])
            normal = add(normal, cross(subtract(p, center), subtract(q, center)))
        size = length(normal)
        body.area[f] = 0.5 * size
        if size == 0.0:
            body.distance[f] = -1.0
            continue
        normal = divide(normal, size)
        write_row(body.normal, f, 0, normal)
        body.distance[f] = dot(normal, center)


@kernel
def _measure_sides(points: Array, body: BodyArrays) -> None:
    """Fill in inset, start, stop and reach of each side, and the radius of each point.

    An edge lies along the difference of its corners, and along the line where its two
    planes meet. Coordinates with an error eta turn the first by eta over its length and
    the second by eta over the sine of the planes' angle, so the better of the two is
    taken.
    """
    corner = body.corner
    normal = body.normal
    distance = body.distance
    for i in range(points.shape[0]):
        body.radius[i] = length(point_at(points, i))
    # Entries far apart in memory are best fetched in a loop that does little else.
    neighbour = np.empty(corner.shape[0], np.int64)
    for k in range(corner.shape[0]):
        neighbour[k] = body.face[body.twin[k]]
    for f in range(distance.shape[0]):
        begin = body.face_start[f]
        end = body.face_start[f + 1]
        n = point_at(normal, f)
        d = distance[f]
        w = point_at(points, corner[begin])
        for k in range(begin, end):
            v = w
            w = point_at(points, corner[k + 1 if k + 1 < end else begin])
            m = point_at(normal, neighbour[k])
            difference = subtract(w, v)
            meeting = cross(n, m)
            size = length(difference)
            sine = length(meeting)
            if sine > size:
                direction = divide(meeting, sine)
                s = (distance[neighbour[k]] - dot(n, m) * d) / sine
            else:
                direction = divide(difference, size)
                # n x e points into the polygon; n . (v x e) = -v . (n x e)
                s = dot(n, cross(v, direction))
            body.inset[k] = s
            # From the plane, so that no side of a merged face is closer than the face.
            body.reach[k] = math.sqrt(d * d + s * s)
            body.start[k] = -dot(v, direction)
            body.stop[k] = dot(w, direction)


@kernel
def _measure_angles(points: Array, body: BodyArrays) -> None:
    """Fill in the solid angle of each face, by the form that keeps its digits.

    With the foot inside, the right triangles of its sides all count one way; with the
    foot outside they cancel, and the sum of products by Van Oosterom and Strackee keeps
    more digits.
    """
    corner = body.corner
    for f in range(body.angle.shape[0]):
        begin = body.face_start[f]
        end = body.face_start[f + 1]
        is_foot_inside = True
        for k in range(begin, end):
            is_foot_inside = is_foot_inside and body.inset[k] >= 0.0
        total = 0.0
        if is_foot_inside:
            d = body.distance[f]
            for k in range(begin, end):
                q = body.reach[k]
                s = body.inset[k]
                v = body.radius[corner[k]]
                w = body.radius[corner[k + 1 if k + 1 < end else begin]]
                total += 2.0 * math.atan(s * body.start[k] / ((d + q) * (q + v)))
                total += 2.0 * math.atan(s * body.stop[k] / ((d + q) * (q + w)))
        else:
            p = point_at(points, corner[begin])
            for k in range(begin + 1, end - 1):
                total += solid_angle(
                    p, point_at(points, corner[k]), point_at(points, corner[k + 1])
                )
        body.angle[f] = total
