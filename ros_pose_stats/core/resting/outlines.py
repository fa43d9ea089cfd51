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

"""True outlines of a part at rest: its shadow, and its section at a height."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...base import errors
from .. import tolerances
from ..kernels.mesh import facing
from ..mesh import arrays, vectors
from ..records import Array, Index, Part, StablePose
from . import convex_body

if TYPE_CHECKING:
    from manifold3d import CrossSection, Manifold

Polygon = tuple[Array, ...]
# Of length in a radius: polygons are kept to 1e-8 of one, and needles are thin.
UNITS = 1e4

FOLDED = 1e-6
"""Share of the surface from which on triangles that lie on each other count: a modeller
takes ten times as long, but knows which of them a face is made of."""


def outline_at(
    part: Part, pose: StablePose, height: float | None = None
) -> tuple[Polygon, ...]:
    """Outline of a part at rest in a pose, as seen from above or at a height.

    Unlike `pose.outline`, which is that of the convex hull, it shows bays and holes. It
    is that of the surface as the file has it, closed where the mesh was open.

    Parameters
    ----------
    part : Part
    pose : StablePose
        One of its poses, from `estimate`, `simulate` or `resting_poses`.
    height : float, optional
        Above the plate, metres: the section just above that height. Default: the
        silhouette.

    Returns
    -------
    tuple of polygons
        The largest first; each is a tuple of rings (k, 2) in the plate frame, metres:
        the boundary counter-clockwise from above, then holes clockwise. Empty at
        heights where nothing of the part is.

    Raises
    ------
    RequestError
        If `part` or `pose` are something else, or the height is no finite number.
    MeshError
        If a section is asked for of a part whose surface is not closed, as that of
        every Part from a mesh is.
    """
    if not isinstance(part, Part) or not isinstance(pose, StablePose):
        raise errors.RequestError(
            "a Part and one of its poses",
            f"{type(part).__name__} and {type(pose).__name__}",
            "take a pose of estimate(part).poses",
        )
    level = None if height is None else arrays.number_or_nan(height)
    if level is not None and not np.isfinite(level):
        raise errors.RequestError(
            "a height above the plate in metres",
            f"{height!r}",
            "leave it out for the silhouette",
        )
    unit = unit_of(part)
    if level is None:
        (outline,) = shadows(part, [pose])
    else:
        level /= unit
        rotation = vectors.rotation_matrices(pose.orientation[None])[0]
        points = vectors.turn_vectors(_points(part), rotation.T)
        points[:, 2] += pose.height / unit
        points[np.abs(points[:, 2] - level) <= _flatness(part), 2] = level
        outline = _without_spurs(_solid(part, points).slice(level), part)
    polygons = sorted(outline.decompose(), key=lambda polygon: -polygon.area())
    return tuple(
        _rings(polygon, unit) for polygon in polygons if not polygon.is_empty()
    )


def shadows(part: Part, poses: Sequence[StablePose]) -> "list[CrossSection]":
    """Silhouettes of a part in some poses, plate frame, in `unit_of` the part."""
    points = _points(part)
    rotations = vectors.rotation_matrices(
        np.array([pose.orientation for pose in poses]).reshape(-1, 4)
    )
    neighbours, folded = facing.neighbours_across(points, part.surface_triangles)
    if folded > FOLDED:
        solid = _solid(part, points)
        motions = np.pad(rotations, ((0, 0), (0, 0), (0, 1)))  # none moves the part
        outlines = [solid.transform(motion).project() for motion in motions]
    else:
        outlines = [
            _shadow(points, part.surface_triangles, neighbours, rotation)
            for rotation in rotations
        ]
    return [_without_spurs(outline, part) for outline in outlines]


def _shadow(
    points: Array, triangles: Index, neighbours: Index, rotation: Array
) -> "CrossSection":
    """What the triangles that face up cover, however often."""
    from manifold3d import CrossSection, FillRule

    corners, ends = facing.loops_facing(
        points, triangles, neighbours, rotation[2].copy()
    )
    seen = vectors.turn_vectors(points[corners], rotation.T)[:, :2].copy()
    return CrossSection(np.split(seen, ends[:-1]), FillRule.Positive)


def unit_of(part: Part) -> float:
    """Metres a unit of length in which outlines are computed."""
    return convex_body.body_of(part, 0).radius / UNITS


def _points(part: Part) -> Array:
    """The part about its centre of mass, as its file has it, in `unit_of` the part."""
    return np.asarray(
        (part.surface_vertices - part.center_of_mass) / unit_of(part), np.float64
    )


def _flatness(part: Part) -> float:
    """How far corners of a flat face may be off it."""
    return UNITS * (convex_body.body_of(part, 0).tolerance or tolerances.COPLANAR)


def _without_spurs(outline: "CrossSection", part: Part) -> "CrossSection":
    """Without what walls leave that stand upright but for rounding: it has no width."""
    from manifold3d import JoinType  # only outlines need it

    step = min(_flatness(part), UNITS * tolerances.COPLANAR)
    return (
        outline.offset(-step, JoinType.Miter, 2.0)
        .offset(step, JoinType.Miter, 2.0)
        .simplify(step)
    )


def _solid(part: Part, points: Array) -> "Manifold":
    from manifold3d import Error, Manifold, Mesh64

    solid = Manifold(
        Mesh64(
            vert_properties=points, tri_verts=part.surface_triangles.astype(np.uint64)
        )
    )
    if solid.status() != Error.NoError:
        raise errors.MeshError(
            "a closed surface",
            f"one that is none ({solid.status().name})",
            "make the part with load_part or part_from_mesh",
        )
    return solid


def _rings(polygon: "CrossSection", unit: float) -> Polygon:
    """Rings of one polygon in metres, its boundary first: holes have areas below 0."""

    def double_area(ring: Array) -> float:
        x, y = ring.T
        return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())

    rings = map(np.asarray, polygon.to_polygons())
    return tuple(ring * unit for ring in sorted(rings, key=double_area, reverse=True))


def area_and_length(outline: Array) -> tuple[float, float]:
    """Area and length of a polygon's boundary."""
    x, y = outline.T
    following_corner = np.roll(outline, -1, axis=0)
    return (
        0.5 * abs(float(x @ following_corner[:, 1] - y @ following_corner[:, 0])),
        float(np.hypot(*(following_corner - outline).T).sum()),
    )
