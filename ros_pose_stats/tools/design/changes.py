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

"""A part with changed features: centre of mass, proportions and resting faces.

The outer shape is that of the convex hull: faces are moved by moving their planes. The
mass follows: stretching carries the material along, and a sliver that is added or cut
off has the part's mean density, its mass over the volume of its hull.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError, cKDTree

from ...base.errors import MeshError, RequestError
from ...core.kernels.mesh import measures, nearness
from ...core.mesh.hull import hull_of_corners
from ...core.mesh.vectors import lengths
from ...core.records import Array, DropScene, Index, Part
from ...core.resting import convex_body, poses

AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Feature:
    """One thing to be changed."""

    # `centre` (of mass, along an axis), `stretch` (along an axis) or `face` (the
    # resting face of a pose, outward)
    kind: Literal["centre", "stretch", "face"]
    axis: int = -1  # of the first two kinds; else -1
    poses: tuple[int, ...] = ()  # that rest on the face
    # (k,); faces of the body that are moved
    planes: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # (3,); middle of the face, in radii about the centre of mass
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    size: float = 0.0  # area of the face, in square radii

    @property
    def is_length(self) -> bool:
        """Whether its step is a length; else it is a fraction."""
        return self.kind != "stretch"


def find_features(resting: poses.RestingPoses) -> tuple[Feature, ...]:
    """Centre of mass along x, y, z, stretching along them, then resting faces."""
    equilibria = resting.equilibria
    body = resting.body
    clusters = resting.clusters
    features: dict[tuple[int, ...], Feature] = {}
    for pose, lowest in enumerate(clusters.lowest_face.tolist()):
        face = equilibria.faces[lowest]
        members = equilibria.faces[(clusters.pose == pose) & clusters.is_support]
        strips = np.unique(body.run_of_face[members])
        moved_faces = np.union1d(
            members, np.flatnonzero(np.isin(body.run_of_face, strips[strips >= 0]))
        )
        key = tuple(moved_faces.tolist())
        resting_poses = features[key].poses if key in features else ()
        features[key] = Feature(
            "face",
            poses=(*resting_poses, pose),
            planes=moved_faces,
            anchor=body.polygon(face).mean(axis=0),
            size=float(body.arrays.area[moved_faces].sum()),
        )
    axes = [Feature(kind, axis) for kind in ("centre", "stretch") for axis in range(3)]
    return (*axes, *features.values())


def check_reach(name: str, length: float, radius: float) -> None:
    """Raise RequestError for a length of a change that is none."""
    if not 0.0 < length <= 0.5 * radius:
        raise RequestError(
            f"a {name} above 0 and at most {500.0 * radius:.3g} mm, half the "
            "part's radius",
            f"{1e3 * length:.3g} mm",
            f"give one, for instance {50.0 * radius:.2g}mm, or leave it out",
        )


class ChangedPart(NamedTuple):
    """A changed part."""

    # its convex hull with its mass properties, in the frame of the part before
    part: Part
    origin: Index  # (F,); face of the body before that each face of its body was


class DesignSpace:
    """A part and all that can be changed on it; `resting` is of the part as it is."""

    def __init__(self, part: Part, scene: DropScene | None = None) -> None:
        part.require_known_error("changes of a part")
        self.part = part
        self.scene = scene or DropScene()
        self.resting = poses.poses_in(part, self.scene)
        self.body = self.resting.body
        self.features = find_features(self.resting)
        self._corners = np.ascontiguousarray(
            self.body.points[np.unique(self.body.arrays.corner)]
        )
        self._hull = hull_of_corners(self._corners)
        self._moments = _moments_of(self._corners, self._hull[0])

    def change(self, steps: ArrayLike) -> ChangedPart:
        """Make the part with features changed by steps (n,), of faces outward.

        They are in metres, those of stretching fractions.
        """
        values = np.asarray(steps, dtype=np.float64)
        stretch = 1.0 + values[3:6]
        arrays = self.body.arrays
        corners = self._corners * stretch
        hull = self._hull
        normals = arrays.normal / stretch
        size = lengths(normals)
        normals = normals / size[:, None]
        distances = arrays.distance / size
        # In masses and radii before: the material is carried along, and a sliver that
        # is added or cut off has the mean density.
        linear = np.diag(stretch)
        inertia = self.resting.inertia
        mass = 1.0
        center: Array = np.zeros(3)
        second = linear @ (0.5 * np.trace(inertia) * np.eye(3) - inertia) @ linear
        if values[6:].any():
            for feature, value in zip(self.features[6:], values[6:], strict=True):
                distances[feature.planes] += value / self.body.radius
            corners = corners_of_planes(normals, distances, corners)
            hull = hull_of_corners(corners)
            volume, first, squares = self._moments
            volume_ratio = float(np.linalg.det(linear))
            density = 1.0 / (volume * volume_ratio)
            changed_moments = _moments_of(corners, hull[0])
            mass += density * (changed_moments[0] - volume_ratio * volume)
            if mass <= 0.0:
                raise MeshError(
                    "a part of which something is left",
                    "one that was cut away",
                    "change the part less",
                )
            center = (
                density * (changed_moments[1] - volume_ratio * linear @ first) / mass
            )
            second = second + density * (
                changed_moments[2] - volume_ratio * linear @ squares @ linear
            )
            second = second - mass * np.outer(center, center)
        return self._build_part(
            corners,
            hull,
            normals,
            center + values[:3] / self.body.radius,
            mass,
            np.trace(second) * np.eye(3) - second,
        )

    def change_feature(self, number: int, step: float) -> ChangedPart:
        """Make the part with one changed feature; see `change`."""
        steps = np.zeros(len(self.features))
        steps[number] = step
        return self.change(steps)

    def _build_part(
        self,
        corners: Array,
        hull: tuple[Index, Index],
        normals: Array,
        center: Array,
        mass: float,
        inertia: Array,
    ) -> ChangedPart:
        """The hull as a part, with its body, which is not to be rounded once more."""
        part = self.part
        old_body = self.body
        points = corners - center
        farthest = float(lengths(points).max())
        points /= farthest
        points.flags.writeable = False
        arrays, tolerance = convex_body.build_polyhedron(
            points, *hull, part.rounding / old_body.radius
        )
        # A body has no two faces in one plane.
        origin = np.asarray(cKDTree(normals).query(arrays.normal)[1], dtype=np.int64)
        runs = tuple(
            replace(
                run,
                center=(run.center - center) / farthest,
                radius=run.radius / farthest,
            )
            for run in old_body.runs
        )
        body = convex_body.ConvexBody(
            old_body.radius * farthest,
            points,
            arrays,
            tolerance,
            runs,
            old_body.run_of_face[origin],
            old_body.rounded,
            old_body.thinned,
        )
        vertices = part.center_of_mass + old_body.radius * corners
        fans = fan_triangles(body)
        changed_part = Part(
            part.part_id,
            vertices,
            fans.astype(np.uint32),
            vertices,
            fans,
            part.mass * mass,
            part.center_of_mass + old_body.radius * center,
            inertia * (part.mass * old_body.radius**2),
            part.warnings,
            part.rounding,
            unit=part.unit,
            unit_guessed=part.unit_guessed,
            bodies=part.bodies,
        )
        convex_body.keep_body(changed_part, body, self.scene.round_sides)
        return ChangedPart(changed_part, origin)


def _moments_of(corners: Array, triangles: Index) -> tuple[float, Array, Array]:
    """Volume, first moment (3,) and second moment (3, 3) of the inside of a hull."""
    inward = np.linalg.det(corners[triangles] - corners.mean(axis=0)) < 0.0
    outward = np.where(inward[:, None], triangles[:, ::-1], triangles)
    volume, x, y, z, xx, yy, zz, xy, xz, yz = measures.solid_moments(
        np.ascontiguousarray(corners), outward
    ).tolist()
    return (
        volume,
        np.array([x, y, z]),
        np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
    )


SNAP_DISTANCE = 2e-5
"""Corners this close, in radii, to one that was there before are that corner. Where
more than three faces meet in rounded coordinates, their planes miss each other by as
much."""

SAME_CORNER = 1e-9  # new corners this close are one


def corners_of_planes(normals: Array, distances: Array, corners_before: Array) -> Array:
    """Corners (C, 3) of the body about the origin that planes bound.

    `normals` (K, 3): outward; `distances` (K,); `before` (H, 3): corners before the
    change.
    """
    if distances.min() <= 0.0:
        raise MeshError(
            "faces around the centre of mass",
            "a face that was moved beyond it",
            "change the part less",
        )
    open_error = MeshError(
        "planes that bound a body", "planes that leave it open", "change the part less"
    )
    try:
        dual = np.unique(ConvexHull(normals / distances[:, None]).equations, axis=0)
    except QhullError as error:
        raise open_error from error
    if dual[:, 3].max() >= 0.0:
        raise open_error
    corners = dual[:, :3] / -dual[:, 3:]
    gap, nearest = cKDTree(corners_before).query(
        corners, distance_upper_bound=SNAP_DISTANCE
    )
    is_old = np.isfinite(gap)
    new_corners = np.ascontiguousarray(corners[~is_old])
    if len(new_corners):
        first_copies = nearness.first_of_coincident(
            new_corners, new_corners.min(axis=0), SAME_CORNER
        )
        new_corners = new_corners[np.unique(first_copies)]
    return np.ascontiguousarray(
        np.concatenate((corners_before[np.unique(nearest[is_old])], new_corners))
    )


def fan_triangles(body: convex_body.ConvexBody) -> Index:
    """Triangles (T, 3) of the faces of a body, wound outward, each face a fan."""
    arrays = body.arrays
    side = np.arange(len(arrays.corner))
    first = arrays.face_start[arrays.face]
    last = arrays.face_start[arrays.face + 1] - 1
    inner_side = side[(first < side) & (side < last)]
    sides = np.stack((first[inner_side], inner_side, inner_side + 1), axis=1)
    return np.asarray(arrays.corner[sides])
