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

"""The stable poses of a part as records, before any probability.

`equilibria` are the faces that it can stand on, `clusters` joins those that a small
rise parts, and `records.shares` gives the poses their probabilities.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np

from ...base.errors import RequestError
from ..kernels.body.standing import silhouette, tops
from ..kernels.features import corner_crowding, split_features
from ..kernels.levels.splits import split_probabilities
from ..kernels.principal_axes import principal_axes
from ..mesh.vectors import lengths, resting_quaternions, rotation_matrices
from ..records import Array, DropScene, Index, Part, StablePose
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES, Numbering
from . import convex_body, symmetry
from .equilibria import (
    Clusters,
    Equilibria,
    equilibria_of,
    gather_clusters,
    spread,
    tilt_margins,
)
from .turns import measure_axis_offsets, measure_curves, rolling_axes, yaw_symmetries

CORNER_REACHES = np.array([0.05, 0.3125])
"""Distances, in radii, within which corners count as one: for edges and bevels, and for
shapes."""

OTHER_SIDES_HEIGHT = 0.01
OTHER_SIDES_TURN = 0.996
"""Share of its height, and cosine of an angle (5 degrees), within which a pose is the
same with another number of sides: facets of 48 lie 0.2 % nearer to the axis than the
surface."""


@dataclass(frozen=True, eq=False)
class RestingPoses:
    """Stable poses of a part at one cluster tolerance, by their `index`."""

    equilibria: Equilibria
    clusters: Clusters
    poses: tuple[StablePose, ...]  # without probabilities
    # (3, 3); central inertia in part axes over the mass and the squared radius
    inertia: Array
    symmetry: symmetry.PoseSymmetry  # none where no records were made

    @property
    def body(self) -> convex_body.ConvexBody:
        """Convex body of the part."""
        return self.equilibria.body

    @property
    def group(self) -> Index:
        """Poses (P,) of one number look alike: rotations of the part exchange them."""
        return self.symmetry.group

    @property
    def unit(self) -> Index:
        """Poses (P,) of one number are equally probable.

        Rotations or reflections of the body that is dropped exchange them, so that a
        unit is a group or several.
        """
        return self.symmetry.unit

    @property
    def symmetries(self) -> Index:
        """Poses (S, P) that each motion of that body puts in the place of the poses.

        The first leaves them; of probabilities T of moves from pose to pose those at
        (i, j) and (s[i], s[j]) are equal.
        """
        return self.symmetry.images

    @property
    def faces(self) -> Index:
        """Face (P,) of the body that each pose rests on, its lowest."""
        return self.equilibria.faces[self.clusters.lowest_face]

    @property
    def heights(self) -> Array:
        """Height (P,) of the centre of mass in each pose, in radii."""
        return self.equilibria.heights[self.clusters.lowest_face]

    @property
    def downs(self) -> Array:
        """Direction (P, 3) that points down in each pose."""
        return self.equilibria.downs[self.clusters.lowest_face]

    @cached_property
    def moments(self) -> Array:
        """Principal moments (3,) of `inertia`, rising."""
        return principal_axes(self.inertia)[0]

    @cached_property
    def passage_r(self) -> tuple[Array, Array]:
        """Component areas and node probabilities for r; see `split_probabilities`."""
        return self._passage(False)

    @cached_property
    def passage_R(self) -> tuple[Array, Array]:  # noqa: N802 - the paper's name
        """Component areas and node probabilities for R; see `split_probabilities`."""
        return self._passage(True)

    @cached_property
    def shape_features(self) -> Array:
        """Trace of `inertia`, its least and greatest share, highest split, lowest pose.

        (5,).
        """
        smallest, middle, largest = self.moments.tolist()
        trace = smallest + middle + largest
        levels = self.equilibria.arrays.tree.level[self.clusters.split]
        return _make_read_only(
            np.array(
                [
                    trace,
                    smallest / trace,
                    largest / trace,
                    levels.max(initial=0.0),
                    self.equilibria.heights.min(),
                ]
            )
        )

    @cached_property
    def split_features(self) -> Array:
        """Features of the components of each split.

        See `kernels.features.split_features`.
        """
        arrays = self.equilibria.arrays
        return split_features.split_features(
            self.body.points,
            self.body.arrays,
            arrays.stable,
            arrays.basin,
            arrays.tree,
            self.clusters.split,
            self.passage_r[0],
            self.passage_R[0],
            self.inertia,
        )

    @cached_property
    def corner_crowding(self) -> Array:
        """Crowding at each of `CORNER_REACHES`, (2,).

        See `kernels.features.corner_crowding`.
        """
        return corner_crowding.corner_crowding(
            self.body.points, self.body.arrays, CORNER_REACHES
        )

    @cached_property
    def axis_offsets(self) -> Array:
        """How far (P,) the centre of mass is beside the axis poses roll on, radii."""
        return measure_axis_offsets(self.body, self.pose_of_face, self.downs)

    @cached_property
    def curves(self) -> tuple[Array, Array]:
        """Share (P,) of curves in what leads to a pose, how far they lie across."""
        return measure_curves(
            self.body, self.inertia, self.pose_of_face, self.faces, self.downs
        )

    @property
    def pose_of_face(self) -> Index:
        """Pose (F,) to which each face descends."""
        equilibria = self.equilibria
        return self.clusters.pose[equilibria.rank][equilibria.arrays.basin]

    def is_numbered_like(self, other: "RestingPoses") -> bool:
        """Whether poses with round surfaces divided otherwise have one number.

        They must come in the same groups, as high, and on the same side where they do
        not roll.
        """
        if len(self.poses) != len(other.poses):
            return False
        return all(
            (pose.group, pose.rolls) == (other_pose.group, other_pose.rolls)
            and abs(pose.height - other_pose.height) <= OTHER_SIDES_HEIGHT * pose.height
            and (pose.rolls or float(pose.down @ other_pose.down) >= OTHER_SIDES_TURN)
            for pose, other_pose in zip(self.poses, other.poses, strict=True)
        )

    # R is the paper's name.
    def _passage(self, of_R: bool) -> tuple[Array, Array]:  # noqa: N803
        tree = self.equilibria.arrays.tree
        return split_probabilities(self.body.arrays, tree, self.clusters.split, of_R)

    def gather(self, stable: Array) -> Array:
        """Sum values of the stable faces (S,), by rising height, over poses (P,)."""
        sums = np.bincount(self.clusters.pose, stable, len(self.poses))
        return sums.astype(np.float64)


@dataclass(frozen=True, eq=False)
class PoseShape:
    """Contact polygon and outline of a body in one pose, computed on demand."""

    body: convex_body.ConvexBody
    face: int
    rotation: Array

    @cached_property
    def support_polygon(self) -> Array:
        """Contact polygon (k, 2), plate frame, metres, counter-clockwise from above."""
        polygon = self.body.polygon(self.face)[::-1] @ self.rotation[:2].T
        return _make_read_only(polygon * self.body.radius)

    @cached_property
    def outline(self) -> Array:
        """Convex silhouette (k, 2) in the plate frame, metres, counter-clockwise."""
        polygon = silhouette(self.body.points, self.body.arrays, self.rotation)
        return _make_read_only(polygon * self.body.radius)


def _make_read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array


def resting_poses(
    part: Part,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> RestingPoses:
    """Stable poses of a part, found once and kept as long as the part lives.

    Parameters
    ----------
    part : Part
    cluster_tolerance : float
        Least rise out of a pose as a share of its height; 0 keeps every stable face.
    round_sides : int
        Sides a turn of round surfaces; 0 takes the file as it is.

    Raises
    ------
    RequestError
        If `part` is no Part, or the tolerance is not from 0 to below 1.
    """
    return poses_in(
        part, DropScene(cluster_tolerance=cluster_tolerance, round_sides=round_sides)
    )


def poses_in(part: Part, scene: DropScene) -> RestingPoses:
    """The stable poses of a part in a scene."""
    if not isinstance(part, Part):
        raise RequestError(
            "a Part",
            f"{type(part).__name__}",
            "make one with load_part or part_from_mesh",
        )
    return part.prepare(_find, scene.numbering)


def bare_poses(part: Part, scene: DropScene) -> RestingPoses:
    """The same without records of the poses, symmetry and margins.

    Not kept for the next call.
    """
    if are_found(part, scene):
        return poses_in(part, scene)
    return _gather(part, scene.numbering)


def are_found(part: Part, scene: DropScene) -> bool:
    """Whether `poses_in` would answer at once."""
    return part.has_prepared(_find, scene.numbering)


def _find(part: Part, numbering: Numbering) -> RestingPoses:
    bare = _gather(part, numbering)
    surface = cache(partial(symmetry.surface_trial, part, bare.body))
    alike = symmetry.find_symmetry(part, bare.equilibria, bare.clusters, surface)
    poses = _make_records(part, bare, alike.group, surface)
    return replace(bare, poses=poses, symmetry=alike)


def _gather(part: Part, numbering: Numbering) -> RestingPoses:
    equilibria = equilibria_of(part, numbering.round_sides)
    radius = equilibria.body.radius
    clusters = gather_clusters(equilibria, numbering.cluster_tolerance)
    return RestingPoses(
        equilibria,
        clusters,
        (),
        part.inertia / (part.mass * radius * radius),
        symmetry.separate_poses(len(clusters.lowest_face)),
    )


def _along_plate(axes: Array, rotations: Array) -> Array:
    """Axes (P, 3) in part axes as unit vectors in the plate frame; zero stays zero."""
    turned = (rotations * axes[:, None, :]).sum(axis=2)
    turned[:, 2] = 0.0
    size = lengths(turned)[:, None]
    unit: Array = np.divide(turned, size, out=np.zeros_like(turned), where=size > 0.0)
    return unit


def _make_records(
    part: Part,
    resting: RestingPoses,
    groups: Index,
    surface: Callable[[], symmetry.SurfaceTrial],
) -> tuple[StablePose, ...]:
    body = resting.body
    equilibria = resting.equilibria
    clusters = resting.clusters
    downs = resting.downs
    heights = resting.heights * body.radius
    quaternions = resting_quaternions(downs)
    rotations = rotation_matrices(quaternions)
    positions = -rotations @ part.center_of_mass
    positions[:, 2] += heights
    top = heights + tops(body.points, np.ascontiguousarray(downs)) * body.radius
    margins = tilt_margins(equilibria, clusters)
    # A shelf between two poses that are alike goes to one of them, and neither tilts
    # farther.
    group_margin = np.full(len(margins), np.inf)
    np.minimum.at(group_margin, groups, margins)
    margins = group_margin[groups]
    rolls, axes = rolling_axes(equilibria, clusters)
    roll_axes = _along_plate(axes, rotations)
    first = clusters.lowest_face[np.unique(groups, return_index=True)[1]]
    yaw = yaw_symmetries(part, equilibria, first, surface)[groups]
    faces = resting.faces
    barriers = clusters.barrier * body.radius
    members_of: list[list[int]] = [[] for _ in margins]
    for member, pose in enumerate(clusters.pose.tolist()):
        members_of[pose].append(member)
    for array in (downs, quaternions, positions, roll_axes):
        array.flags.writeable = False
    size = np.bincount(groups)
    return tuple(
        StablePose(
            index=i,
            group=int(groups[i]),
            down=downs[i],
            height=float(heights[i]),
            top=float(top[i]),
            margin=float(margins[i]),
            barrier=float(barriers[i]),
            spread=spread(equilibria, clusters, members),
            members=tuple(members),
            orientation=quaternions[i],
            position=positions[i],
            shape=PoseShape(body, int(faces[i]), rotations[i]),
            group_size=int(size[groups[i]]),
            rolls=bool(rolls[i]),
            roll_axis=roll_axes[i],
            yaw_symmetry=int(yaw[i]),
        )
        for i, members in enumerate(members_of)
    )
