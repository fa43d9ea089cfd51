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

"""The convex hull of a part, computed once.

Qhull works on points shifted to the centre of their bounding box and scaled to size
one: its own tolerances assume numbers of order one.

It handles coplanar points by merging facets, and each merge walks around the whole
facet: a ring of 1000 corners takes it 0.1 s, one of 25 000 minutes. Such a ring is seen
in a sample of the points: many of the sample's corners share a face too.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ...base import errors
from .. import tolerances
from ..kernels.mesh.measures import thinness
from ..records import Array, Corners, Index, Part
from .arrays import mask_of
from .vectors import UnitPoints, to_unit_size

CROWD = 1000
"""Corners of one face from which on Qhull takes longer for them than for as many other
points."""

_SAMPLE = 512  # most points of a sample
_CORNERS_IN_SAMPLE = 64  # of a face of `CROWD` corners, in a smaller sample
_FEW = 6  # corners of a face in the sample that chance alone may put there

CORNERS_SHAKEN = 1e-10
"""By how much corners of a body that was made here are moved while their hull is
found."""

# Points this close to a face, as a fraction of the size, are counted with it.
COUNTED = 1e-10


class Facets(NamedTuple):
    """The hull that Qhull found."""

    points: Array  # (N, 3); as given, not moved
    simplices: Corners  # (M, 3); triangles, wound either way
    neighbors: Corners  # (M, 3); triangle opposite to each corner
    equations: Array  # (M, 4); outward normal and offset of each triangle's plane
    volume: float
    vertices: Index  # points on the hull, rising


class Hull(NamedTuple):
    """A convex hull in shifted and scaled coordinates."""

    # Of `(points - shift) / scale`; its indices are those of the points given
    qhull: Facets
    shift: Array  # (3,); centre of the bounding box, metres
    scale: float  # largest extent of the bounding box, metres


def hull_of(scaled: UnitPoints) -> Hull:
    """Convex hull of points that were brought to unit size."""
    try:
        qhull = _facets(scaled.points)
    except (QhullError, ValueError) as error:
        raise _flat_points_error(scaled.points) from error
    return Hull(qhull, scaled.center, scaled.size)


def _flat_points_error(points: Array) -> errors.MeshError:
    return errors.MeshError(
        "points that span a volume",
        f"{len(points)} points in a plane or line",
        "check that the mesh is a solid part",
    )


def _facets(points: Array) -> Facets:
    """Run Qhull; on slightly moved points where a face is crowded."""
    # Points in a plane are no part, but would seem to be one once they are moved.
    if is_crowded(points) and thinness(points) >= tolerances.FLATTEST:
        for step in tolerances.SHAKEN:
            moves = np.random.default_rng(0).uniform(-step, step, points.shape)
            try:
                return _copy_facets(points, ConvexHull(points + moves))
            except QhullError:
                continue
    return _copy_facets(points, ConvexHull(points))


def _copy_facets(points: Array, qhull: ConvexHull) -> Facets:
    return Facets(
        points,
        qhull.simplices,
        qhull.neighbors,
        qhull.equations,
        float(qhull.volume),
        np.flatnonzero(mask_of(qhull.simplices, len(points))),
    )


def hull_of_corners(points: Array) -> tuple[Index, Index]:
    """Triangles (M, 3), and neighbours, of the hull of points that are all corners.

    For round ends with hundreds of corners points are moved, by less than merges
    triangles.
    """
    moves = np.random.default_rng(0).uniform(
        -CORNERS_SHAKEN, CORNERS_SHAKEN, points.shape
    )
    try:
        qhull = ConvexHull(points + moves)
    except QhullError as error:
        raise _flat_points_error(points) from error
    return qhull.simplices.astype(np.int64), qhull.neighbors.astype(np.int64)


def hull_of_part(part: Part) -> Hull:
    """Convex hull of a part's `surface_vertices`, kept as long as the part lives."""
    return part.prepare(_hull_of_surface)


def keep_hull(part: Part, hull: Hull) -> None:
    """Remember a hull that was computed from the part's `surface_vertices`."""
    part.keep_all({(_hull_of_surface,): hull})


def _hull_of_surface(part: Part) -> Hull:
    return hull_of(to_unit_size(part.surface_vertices))


def distance_to_hull(point: Array, hull: Hull) -> float:
    """How far a point is beyond the nearest hull plane, metres; negative inside."""
    planes = hull.qhull.equations
    with np.errstate(over="ignore"):
        position = (point - hull.shift) / hull.scale
        offset = float(np.abs(position).max())
    if offset > 1e9:
        # Perhaps too far to compute with, and the hull is as good as a point.
        return offset * hull.scale
    return float((planes[:, :3] @ position + planes[:, 3]).max() * hull.scale)


def is_crowded(points: Array) -> bool:
    """Whether a face of the hull of points of size one exceeds `CROWD` corners."""
    if len(points) <= CROWD:
        return False
    # A random sample, since regular steps might pick all points from one ring of a
    # mesh.
    size = min(_SAMPLE, _CORNERS_IN_SAMPLE * len(points) // CROWD)
    sample = np.random.default_rng(0).integers(len(points), size=size)
    try:
        hull = ConvexHull(points[sample])
    except QhullError:
        return True  # almost all points lie in one plane
    # All triangles of a face have its plane.
    planes, triangles = np.unique(hull.equations, axis=0, return_counts=True)
    largest_faces = np.argsort(-triangles, kind="stable")[:6]
    suspects = largest_faces[
        (triangles[largest_faces] + 2 > _FEW)
        & ((triangles[largest_faces] + 2) * len(points) > CROWD * size)
    ]
    return any(_count_corners_on(points, planes[k]) > CROWD for k in suspects.tolist())


def _count_corners_on(points: Array, plane: Array) -> int:
    """Corners of the polygon around the points on a plane.

    0 if other points lie beyond it.
    """
    heights = points @ plane[:3] + plane[3]
    if heights.max() > COUNTED:
        return 0
    face_points = points[heights > -COUNTED]
    projections = np.delete(face_points, int(np.abs(plane[:3]).argmax()), axis=1)
    sample = np.random.default_rng(0).integers(len(projections), size=_SAMPLE)
    try:
        # Where points lie all over a polygon, few of them are corners, in a sample as
        # in all.
        if (
            len(ConvexHull(projections[sample]).vertices) * len(projections)
            < CROWD * _SAMPLE
        ):
            return 0
        return len(ConvexHull(projections).vertices)
    except QhullError:
        return 0  # on a line
