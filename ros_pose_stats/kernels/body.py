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

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compilation import entry_kernel, kernel
from .coplanar import orient, planar_regions, twins
from .polygons import corner_loops, pair_sides, planes
from .vectors import dot, norm, solid_angle

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class BodyArrays(NamedTuple):
    """A convex body about its centre of mass; lengths in units of the caller's points."""

    face_start: Index  # (F + 1,) first side of each face
    corner: Index      # (N,) hull point where a side starts, counter-clockwise
    face: Index        # (N,) face of a side
    twin: Index        # (N,) the same edge seen from the neighbour
    normal: Array      # (F, 3) outward
    distance: Array    # (F,) of the face's plane
    area: Array        # (F,)
    angle: Array       # (F,) centroid solid angle, steradians
    inset: Array       # (N,) s
    start: Array       # (N,) a at the side's first corner
    stop: Array        # (N,) a at its last corner
    reach: Array       # (N,) q
    radius: Array      # (H,) |v| of every hull point


@entry_kernel
def build_body(points: Array, simplices: Index, adjacent: Index,
               tolerance: float) -> tuple[bool, BodyArrays]:
    """Merge coplanar hull triangles into faces and measure them.

    Parameters
    ----------
    points : (H, 3) array
        Hull points relative to the centre of mass.
    simplices, adjacent : (M, 3) arrays
        Triangles of the hull; `adjacent[t, i]` lies opposite to vertex i.
    tolerance : float
        Coplanarity, in the unit of the points.

    Returns
    -------
    valid : bool
        False where merging at this tolerance gives no convex polyhedron around the origin.
    body : BodyArrays
    """
    triangles, neighbors = simplices.copy(), adjacent.copy()
    orient(points, triangles, neighbors)
    opposite = twins(triangles, neighbors)
    region = planar_regions(points, triangles, neighbors, tolerance)
    valid, face_start, first, side_of = corner_loops(triangles, region, opposite, points.shape[0])
    if not valid:
        return False, _nothing()
    corner = np.empty(first.shape[0], np.int64)
    for k in range(first.shape[0]):
        corner[k] = triangles[first[k] // 3, (first[k] + 1) % 3]
    valid, twin, face = pair_sides(face_start, corner, first, side_of, opposite)
    normal, distance, area = planes(points, face_start, corner)
    if not valid or distance.min() <= 0.0:
        return False, _nothing()
    inset, start, stop, reach, radius = _side_lengths(points, corner, face, twin, normal,
                                                       distance)
    angle = _face_angles(points, face_start, corner, distance, inset, start, stop, reach)
    return True, BodyArrays(face_start, corner, face, twin, normal, distance, area, angle,
                            inset, start, stop, reach, radius)


@kernel
def _nothing() -> BodyArrays:
    index, number = np.zeros(0, np.int64), np.zeros(0)
    return BodyArrays(index, index, index, index, np.zeros((0, 3)), number, number, number,
                      number, number, number, number, number)


@kernel
def _side_lengths(points: Array, corner: Index, face: Index, twin: Index, normal: Array,
                  distance: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Inset, start, stop and reach of every side, and the radius of every point.

    An edge lies along the difference of its corners, and along the line where its two planes
    meet. Coordinates with an error eta turn the first by eta over its length and the second
    by eta over the sine of the planes' angle, so the better of the two is taken. (Of two
    corners 1e-7 apart the difference says nothing, and a foot far away would be put on the
    wrong side.)
    """
    sides = corner.shape[0]
    inset, start = np.empty(sides), np.empty(sides)
    stop, reach = np.empty(sides), np.empty(sides)
    radius = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        radius[i] = norm(points[i])
    for k in range(sides):
        n, m = normal[face[k]], normal[face[twin[k]]]
        v, w = points[corner[k]], points[corner[twin[k]]]
        ex, ey, ez = w[0] - v[0], w[1] - v[1], w[2] - v[2]
        length = math.sqrt(ex * ex + ey * ey + ez * ez)
        lx, ly = n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2]
        lz = n[0] * m[1] - n[1] * m[0]
        sine = math.sqrt(lx * lx + ly * ly + lz * lz)
        if sine > length:
            ex, ey, ez = lx / sine, ly / sine, lz / sine
            inset[k] = (distance[face[twin[k]]] - dot(n, m) * distance[face[k]]) / sine
        else:
            ex, ey, ez = ex / length, ey / length, ez / length
            cx, cy, cz = v[1] * ez - v[2] * ey, v[2] * ex - v[0] * ez, v[0] * ey - v[1] * ex
            # n x e points into the polygon; n . (v x e) = -v . (n x e)
            inset[k] = n[0] * cx + n[1] * cy + n[2] * cz
        # From the plane, so that no side of a merged face comes closer than the face itself.
        reach[k] = math.sqrt(distance[face[k]] ** 2 + inset[k] ** 2)
        start[k] = -(v[0] * ex + v[1] * ey + v[2] * ez)
        stop[k] = w[0] * ex + w[1] * ey + w[2] * ez
    return inset, start, stop, reach, radius


@kernel
def _face_angles(points: Array, face_start: Index, corner: Index, distance: Array,
                 inset: Array, start: Array, stop: Array, reach: Array) -> Array:
    """Solid angle of every face, by the form that keeps its digits.

    With the foot inside, the right triangles of its sides all count one way; a long face
    close by would lose digits in Van Oosterom and Strackee's sum of products. With the foot
    outside it is the other way round: the right triangles cancel.
    """
    angle = np.zeros(face_start.shape[0] - 1)
    for f in range(angle.shape[0]):
        begin, end = face_start[f], face_start[f + 1]
        if inset[begin:end].min() >= 0.0:
            d = distance[f]
            for k in range(begin, end):
                q, s = reach[k], inset[k]
                v = norm(points[corner[k]])
                w = norm(points[corner[k + 1 if k + 1 < end else begin]])
                angle[f] += 2.0 * math.atan(s * start[k] / ((d + q) * (q + v)))
                angle[f] += 2.0 * math.atan(s * stop[k] / ((d + q) * (q + w)))
        else:
            p = points[corner[begin]]
            for k in range(begin + 1, end - 1):
                angle[f] += solid_angle(p, points[corner[k]], points[corner[k + 1]])
    return angle
