"""From hull triangles to a convex body: faces, sides and their distances from the origin.

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
from ..vectors import cross, divide, dot, length, point_at, solid_angle, subtract
from .coplanar import opposite_half_edges, orient_triangles, planar_regions
from .polygons import corner_loops, pair_sides, polygon_planes


class BodyArrays(NamedTuple):
    """A convex body about its centre of mass; lengths in units of the caller's points."""

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

    `adjacent[t, i]` lies opposite to vertex i. False where merging at this tolerance gives no
    convex polyhedron around the origin.
    """
    triangles = simplices.copy()
    neighbors = adjacent.copy()
    orient_triangles(points, triangles, neighbors)
    opposite = opposite_half_edges(triangles, neighbors)
    region = planar_regions(points, triangles, neighbors, tolerance)
    valid, face_start, first, side_of = corner_loops(
        triangles, region, opposite, points.shape[0]
    )
    if not valid:
        return False, _nothing()
    corner = np.empty(first.shape[0], np.int64)
    for k in range(first.shape[0]):
        corner[k] = triangles[first[k] // 3, (first[k] + 1) % 3]
    valid, twin, face, follow = pair_sides(face_start, corner, first, side_of, opposite)
    normal, distance, area = polygon_planes(points, face_start, corner)
    if not valid or distance.min() <= 0.0:
        return False, _nothing()
    inset, start, stop, reach, radius = _side_lengths(
        points, face_start, corner, face, twin, normal, distance
    )
    angle = _face_angles(
        points, face_start, corner, distance, inset, start, stop, reach, radius
    )
    return True, BodyArrays(
        face_start,
        corner,
        face,
        twin,
        follow,
        normal,
        distance,
        area,
        angle,
        inset,
        start,
        stop,
        reach,
        radius,
    )


@kernel
def _nothing() -> BodyArrays:
    index = np.zeros(0, np.int64)
    number = np.zeros(0)
    return BodyArrays(
        index,
        index,
        index,
        index,
        index,
        np.zeros((0, 3)),
        number,
        number,
        number,
        number,
        number,
        number,
        number,
        number,
    )


@kernel
def _side_lengths(
    points: Array,
    face_start: Index,
    corner: Index,
    face: Index,
    twin: Index,
    normal: Array,
    distance: Array,
) -> tuple[Array, Array, Array, Array, Array]:
    """Inset, start, stop and reach of every side, and the radius of every point.

    An edge lies along the difference of its corners, and along the line where its two planes meet.
    Coordinates with an error eta turn the first by eta over its length and the second by eta over
    the sine of the planes' angle, so the better of the two is taken.
    """
    sides = corner.shape[0]
    inset = np.empty(sides)
    start = np.empty(sides)
    stop = np.empty(sides)
    reach = np.empty(sides)
    radius = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        radius[i] = length(point_at(points, i))
    # Places far apart in memory are best fetched in a loop that does little else.
    beyond = np.empty(sides, np.int64)
    for k in range(sides):
        beyond[k] = face[twin[k]]
    for f in range(face_start.shape[0] - 1):
        begin = face_start[f]
        end = face_start[f + 1]
        n = point_at(normal, f)
        d = distance[f]
        w = point_at(points, corner[begin])
        for k in range(begin, end):
            v = w
            w = point_at(points, corner[k + 1 if k + 1 < end else begin])
            m = point_at(normal, beyond[k])
            along = subtract(w, v)
            meeting = cross(n, m)
            size = length(along)
            sine = length(meeting)
            if sine > size:
                along = divide(meeting, sine)
                s = (distance[beyond[k]] - dot(n, m) * d) / sine
            else:
                along = divide(along, size)
                # n x e points into the polygon; n . (v x e) = -v . (n x e)
                s = dot(n, cross(v, along))
            inset[k] = s
            # From the plane, so that no side of a merged face comes closer than the face itself.
            reach[k] = math.sqrt(d * d + s * s)
            start[k] = -dot(v, along)
            stop[k] = dot(w, along)
    return inset, start, stop, reach, radius


@kernel
def _face_angles(
    points: Array,
    face_start: Index,
    corner: Index,
    distance: Array,
    inset: Array,
    start: Array,
    stop: Array,
    reach: Array,
    radius: Array,
) -> Array:
    """Solid angle of every face, by the form that keeps its digits.

    With the foot inside, the right triangles of its sides all count one way; with the foot outside
    they cancel, and the sum of products by Van Oosterom and Strackee keeps more digits.
    """
    angle = np.zeros(face_start.shape[0] - 1)
    for f in range(angle.shape[0]):
        begin = face_start[f]
        end = face_start[f + 1]
        inside = True
        for k in range(begin, end):
            inside = inside and inset[k] >= 0.0
        total = 0.0
        if inside:
            d = distance[f]
            for k in range(begin, end):
                q = reach[k]
                s = inset[k]
                v = radius[corner[k]]
                w = radius[corner[k + 1 if k + 1 < end else begin]]
                total += 2.0 * math.atan(s * start[k] / ((d + q) * (q + v)))
                total += 2.0 * math.atan(s * stop[k] / ((d + q) * (q + w)))
        else:
            p = point_at(points, corner[begin])
            for k in range(begin + 1, end - 1):
                total += solid_angle(
                    p, point_at(points, corner[k]), point_at(points, corner[k + 1])
                )
        angle[f] = total
    return angle
