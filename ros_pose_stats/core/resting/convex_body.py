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

"""The convex hull of a part as a polyhedron with true faces.

A part rests on its convex hull, so this body is all that the estimators and the
simulation see of a part, besides its mass properties. Lengths are scaled by the part's
radius and positions are relative to the centre of mass, in part axes.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...base import errors
from .. import tolerances
from ..kernels.body.convex_body import BodyArrays, build_body
from ..kernels.principal_axes import principal_axes
from ..mesh.hull import Facets, hull_of_corners, hull_of_part
from ..mesh.vectors import lengths, scatter, unit_vectors
from ..records import Array, Index, Part
from . import reshaping, rims, round_surfaces, strips, thinning


@dataclass(frozen=True, eq=False)
class ConvexBody:
    """A convex polyhedron about its centre of mass, scaled to a radius of 1."""

    radius: float  # largest distance from the centre of mass to a vertex, metres
    # (H, 3); hull points; all but those on straight edges or inside faces are corners
    points: Array
    # faces as corner loops with their normals, distances, areas, solid angles and sides
    arrays: BodyArrays
    # coplanarity at which the faces were merged, as a fraction of the radius
    tolerance: float
    # its round and toothed runs; none where the body stands as in the file
    runs: tuple[rims.Run, ...]
    # (F,) int; number of the strip that a face belongs to, the facets between two runs
    # about one axis; -1 for a face of none
    run_of_face: Index
    rounded: int  # runs that were given other numbers of sides than in the file
    thinned: bool  # whether corners of a free form were left out

    @property
    def faces(self) -> int:
        """Number of planar faces."""
        return int(self.arrays.distance.shape[0])

    def polygon(self, face: int) -> Array:
        """Corners (k, 3) of a face, counter-clockwise seen from outside."""
        sides = slice(self.arrays.face_start[face], self.arrays.face_start[face + 1])
        return self.points[self.arrays.corner[sides]]

    def r(self, directions: Array) -> Array:
        """Distance from centre of mass to surface in directions (section 2.C)."""
        cosines = np.asarray(directions, dtype=np.float64) @ self.arrays.normal.T
        with np.errstate(divide="ignore"):
            distance = np.where(cosines > 0.0, self.arrays.distance / cosines, np.inf)
        return np.asarray(distance.min(axis=-1))

    def R(self, directions: Array) -> Array:  # noqa: N802 - the paper's name
        """Height of the centre of mass where directions point down (section 2.C)."""
        return np.asarray(
            (np.asarray(directions, dtype=np.float64) @ self.points.T).max(axis=-1)
        )


def foot_directions(body: ConvexBody, sides: Index) -> Array:
    """Directions (k, 3) of the points of sides nearest to the centre of mass."""
    begin = body.points[body.arrays.corner[sides]]
    end = body.points[body.arrays.corner[body.arrays.twin[sides]]]
    length = lengths(end - begin)[:, None]
    direction = (end - begin) / length
    foot = (
        begin
        + np.clip(-(begin * direction).sum(axis=1)[:, None], 0.0, length) * direction
    )
    return unit_vectors(foot)


def body_of(part: Part, round_sides: int) -> ConvexBody:
    """Convex body of a part, built once; `round_sides` 0 takes the file as it is."""
    return part.prepare(_build, round_sides)


def keep_body(part: Part, body: ConvexBody, round_sides: int) -> None:
    """Store a body that was made on another way, for `body_of` to return."""
    part.keep_all({(_build, round_sides): body})


def _build(part: Part, round_sides: int) -> ConvexBody:
    """Body with round surfaces as polygons, its radius the file's if that can be."""
    if not round_sides:
        return _body_of_file(part)
    original = body_of(part, 0)
    scale = original.radius
    points = original.points
    arrays = original.arrays
    tolerance = original.tolerance
    qhull = hull_of_part(part).qhull
    rounding = (
        round_surfaces.rounding_of(part, part.surface_vertices[qhull.vertices]) / scale
    )
    if rounding > part.rounding / scale:
        arrays, tolerance = build_polyhedron(points, *_triangles(qhull), rounding)
    groups = round_surfaces.find_groups(
        part, points, arrays, scale, rounding, round_sides
    )
    outline = reshaping.reshape(points, arrays, groups, round_sides)
    thinning.thin_out(outline, arrays, round_sides)
    if not (outline.changed or outline.added):
        return replace(
            original,
            arrays=arrays,
            tolerance=tolerance,
            runs=tuple(chain.as_run(1.0) for chain in outline.chains),
            run_of_face=strips.number_strips(points, arrays, groups, outline.chains),
        )
    points, chains = outline.compacted()
    # A rim off the centre of mass may reach a little farther between the corners of the
    # file.
    farthest = max(float(lengths(points).max()), 1.0)
    scaled = points / farthest
    scaled.flags.writeable = False
    if not outline.keeps.any():  # all are new, and none is rounded
        rounding = part.rounding / scale
    try:
        arrays, tolerance = build_polyhedron(scaled, *hull_of_corners(scaled), rounding)
    except errors.MeshError:
        # The centre of mass is closer to the surface than a facet's arc.
        return original
    return ConvexBody(
        scale * farthest,
        scaled,
        arrays,
        tolerance,
        tuple(chain.as_run(farthest) for chain in chains),
        strips.number_strips(points, arrays, groups, chains),
        outline.rounded,
        outline.changed,
    )


def _body_of_file(part: Part) -> ConvexBody:
    """Body as the file has it, about the centre of mass and in radii."""
    qhull, shift, unit = hull_of_part(part)
    points = qhull.points[qhull.vertices] + (shift - part.center_of_mass) / unit
    radius = float(lengths(points).max())
    points /= radius
    points.flags.writeable = False
    scale = radius * unit
    arrays, tolerance = build_polyhedron(
        points, *_triangles(qhull), part.rounding / scale
    )
    no_strips = np.full(len(arrays.area), -1)
    return ConvexBody(scale, points, arrays, tolerance, (), no_strips, 0, False)


def _triangles(qhull: Facets) -> tuple[Index, Index]:
    """Triangles and their neighbours in the numbering of the points on the hull."""
    number = np.empty(len(qhull.points), dtype=np.int64)
    number[qhull.vertices] = np.arange(len(qhull.vertices))
    return number[qhull.simplices], qhull.neighbors.astype(np.int64)


def build_polyhedron(
    points: Array, triangles: Index, neighbors: Index, rounding: float
) -> tuple[BodyArrays, float]:
    """Merge coplanar triangles.

    Where no polyhedron remains, repeat with smaller tolerances.
    """
    moment, _ = principal_axes(scatter(points))
    thickness = float(np.sqrt(max(moment[0], 0.0)))
    rounding = min(tolerances.COPLANAR_ROUNDINGS * rounding, tolerances.COPLANAR_MOST)
    largest = min(
        max(tolerances.COPLANAR, rounding), tolerances.COPLANAR_OF_THICKNESS * thickness
    )
    for tolerance in (largest, largest / 10.0, largest / 100.0, 0.0):
        valid, arrays = build_body(points, triangles, neighbors, tolerance)
        if valid:
            return arrays, tolerance
    raise errors.MeshError(
        "a convex hull that encloses the centre of mass",
        "faces through the centre of mass",
        "check the mesh and the given centre of mass",
    )
