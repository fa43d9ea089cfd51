"""The stable poses of a part as records, before any probability."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..errors import RequestError
from ..kernels.body.equilibria import ways_out
from ..kernels.body.standing import silhouette, tops
from ..kernels.features.corner_crowding import corner_crowding
from ..kernels.features.split_features import split_features
from ..kernels.levels.splits import split_probabilities
from ..kernels.principal_axes import principal_axes
from ..mesh.vectors import lengths
from ..records import DropScene, Part, StablePose
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES
from .clusters import Clusters, clusters
from .convex_body import ConvexBody, foot_directions
from .equilibria import Equilibria, equilibria
from .orientation import resting_quaternions, rotation_matrices
from .surface_trial import SurfaceTrial
from .symmetry import symmetry_groups
from .turns import rolling_axes, yaw_symmetries

Array = NDArray[np.float64]
Index = NDArray[np.int64]

CORNER_REACHES = np.array([0.05, 0.3125])
"""Distances, in radii, within which corners count as one: for edges and bevels, and for shapes."""


@dataclass(frozen=True, eq=False)
class RestingPoses:
    """Stable poses of a part at one cluster tolerance, in the order of their `index`.

    Attributes
    ----------
    equilibria : Equilibria
    clusters : Clusters
    poses : tuple of StablePose
        Without probabilities.
    inertia : (3, 3) array
        Central inertia in part axes over the mass and the squared radius.
    """

    equilibria: Equilibria
    clusters: Clusters
    poses: tuple[StablePose, ...]
    inertia: Array

    @property
    def body(self) -> ConvexBody:
        """Convex body of the part."""
        return self.equilibria.body

    @cached_property
    def group(self) -> Index:
        """Symmetry group (P,) of each pose."""
        return np.array([pose.group for pose in self.poses])

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
        """Trace of `inertia`, its least and greatest share, highest split, lowest pose; (5,)."""
        least, middle, most = self.moments.tolist()
        trace = least + middle + most
        levels = self.equilibria.arrays.tree.level[self.clusters.split]
        found = np.array([trace, least / trace, most / trace, levels.max(initial=0.0),
                          self.equilibria.heights.min()])
        found.flags.writeable = False
        return found

    @cached_property
    def split_features(self) -> Array:
        """Features of the components of each split; see `kernels.features.split_features`."""
        found = self.equilibria.arrays
        return split_features(self.body.points, self.body.arrays, found.stable, found.basin,
                              found.tree, self.clusters.split, self.passage_r[0],
                              self.passage_R[0], self.inertia)

    @cached_property
    def corner_crowding(self) -> Array:
        """Crowding at each of `CORNER_REACHES`, (2,); see `kernels.features.corner_crowding`."""
        return corner_crowding(self.body.points, self.body.arrays, CORNER_REACHES)

    def _passage(self, of_R: bool) -> tuple[Array, Array]:  # noqa: N803 - the paper's name
        tree = self.equilibria.arrays.tree
        return split_probabilities(self.body.arrays, tree, self.clusters.split, of_R)

    def gather(self, stable: Array) -> Array:
        """Sum values of the stable faces (S,), by rising height, over the poses (P,)."""
        sums = np.bincount(self.clusters.pose, stable, len(self.poses))
        return sums.astype(np.float64)


@dataclass(frozen=True, eq=False)
class PoseShape:
    """Contact polygon and outline of a body in one pose, computed on demand."""

    body: ConvexBody
    face: int
    rotation: Array

    def support_polygon(self) -> Array:
        """Contact polygon (k, 2) in the plate frame, metres, counter-clockwise from above."""
        seen = self.body.polygon(self.face)[::-1] @ self.rotation[:2].T
        return np.asarray(seen * self.body.radius)

    def outline(self) -> Array:
        """Convex silhouette (k, 2) in the plate frame, metres, counter-clockwise."""
        seen = silhouette(self.body.points, self.body.arrays, self.rotation)
        return np.asarray(seen * self.body.radius)


def resting_poses(part: Part,
                  cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
                  round_sides: int = DEFAULT_ROUND_SIDES) -> RestingPoses:
    """Stable poses of a part, found once for the options and kept as long as the part lives.

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
    if not isinstance(part, Part):
        raise RequestError("a Part", f"{type(part).__name__}",
                           "make one with load_part or part_from_mesh")
    scene = DropScene(cluster_tolerance=cluster_tolerance, round_sides=round_sides)
    return part.prepare(_find, scene.cluster_tolerance, scene.round_sides)


def are_found(part: Part, cluster_tolerance: float, round_sides: int) -> bool:
    """Whether `resting_poses` would answer at once."""
    return part.has_prepared(_find, cluster_tolerance, round_sides)


def _find(part: Part, cluster_tolerance: float, round_sides: int) -> RestingPoses:
    found = equilibria(part, round_sides)
    grouped = clusters(found, cluster_tolerance)
    return RestingPoses(found, grouped, _records(part, found, grouped),
                        part.inertia / (part.mass * found.body.radius * found.body.radius))


def _records(part: Part, found: Equilibria, grouped: Clusters) -> tuple[StablePose, ...]:
    body = found.body
    downs = found.downs[grouped.lowest]
    heights = found.heights[grouped.lowest] * body.radius
    quaternions = resting_quaternions(downs)
    rotations = rotation_matrices(quaternions)
    positions = -rotations @ part.center_of_mass
    positions[:, 2] += heights
    top = heights + tops(body.points, np.ascontiguousarray(downs)) * body.radius
    margins = _margins(found, grouped)
    surface = cache(partial(SurfaceTrial, part, body))
    groups = symmetry_groups(part, found, np.where(grouped.near, grouped.pose, -1), surface)
    rolls, axes = rolling_axes(body, downs, found.heights[grouped.lowest], grouped.tolerance)
    on_plate = _on_plate(axes, rotations)
    yaw = yaw_symmetries(part, found, grouped.lowest, surface)
    faces = found.faces[grouped.lowest]
    barriers = grouped.barrier * body.radius
    for array in (downs, quaternions, positions, on_plate):
        array.flags.writeable = False
    rows = zip(groups.tolist(), downs, heights.tolist(), top.tolist(), margins.tolist(),
               barriers.tolist(), _members(grouped), quaternions, positions, faces.tolist(),
               rotations, np.bincount(groups)[groups].tolist(), rolls.tolist(), on_plate,
               yaw.tolist(), strict=True)
    return tuple(
        StablePose(
            index=i, group=group, down=down, height=height, top=highest, margin=margin,
            barrier=barrier, spread=_spread(_near_downs(found, grouped, members)),
            members=tuple(members),
            orientation=quaternion, position=position, shape=PoseShape(body, face, rotation),
            group_size=size, rolls=roll, roll_axis=axis, yaw_symmetry=order,
        )
        for i, (group, down, height, highest, margin, barrier, members, quaternion, position,
                face, rotation, size, roll, axis, order) in enumerate(rows)
    )


def _on_plate(axes: Array, rotations: Array) -> Array:
    """Direction (P, 3) along the plate of axes in the part frame; zero stays zero."""
    seen = (rotations * axes[:, None, :]).sum(axis=2)
    seen[:, 2] = 0.0
    length = lengths(seen)[:, None]
    return np.asarray(np.divide(seen, length, out=np.zeros_like(seen), where=length > 0.0))


def _near_downs(found: Equilibria, grouped: Clusters, members: list[int]) -> Array:
    """Directions of the members that the part rests on in the pose."""
    return found.downs[[member for member in members if grouped.near[member]]]


def _members(grouped: Clusters) -> list[list[int]]:
    """Stable faces of each pose, rising."""
    members = np.argsort(grouped.pose, kind="stable").tolist()
    ends = np.cumsum(np.bincount(grouped.pose)).tolist()
    return [members[begin:end] for begin, end in zip([0, *ends[:-1]], ends, strict=True)]


def _margins(found: Equilibria, grouped: Clusters) -> Array:
    """Smallest tilt (P,) over a side of a member that leads to a face outside the pose.

    From a shelf the part slips into its pose: the tilt to one of its sides is told from the
    nearest face that the part rests on.
    """
    arrays = found.body.arrays
    pose_of_face = np.full(found.body.faces, -1, dtype=np.int64)
    pose_of_face[found.faces] = grouped.pose
    on_shelf = np.zeros(found.body.faces, dtype=np.bool_)
    on_shelf[found.faces] = ~grouped.near
    margins = np.full(grouped.lowest.shape[0], np.pi / 2.0)
    sides = ways_out(arrays, found.arrays.basin, pose_of_face)
    faces = arrays.face[sides]
    tilts = np.arctan2(arrays.inset[sides], arrays.distance[faces])
    shelved = np.flatnonzero(on_shelf[faces])
    feet, own = foot_directions(found.body, sides[shelved]), pose_of_face[faces[shelved]]
    for pose in np.unique(own).tolist():
        rests = cKDTree(found.downs[grouped.near & (grouped.pose == pose)])
        chord = rests.query(feet[own == pose])[0]
        tilts[shelved[own == pose]] = 2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0))
    np.minimum.at(margins, pose_of_face[faces], tilts)
    return margins


def _spread(downs: Array) -> float:
    """Largest angle between two directions, radians."""
    if len(downs) == 1:
        return 0.0
    # The direction farthest from another one is the nearest to its opposite.
    gap, partner = cKDTree(downs).query(-downs)
    first = int(np.argmin(gap))
    chord = float(np.linalg.norm(downs[first] - downs[partner[first]]))
    return 2.0 * math.asin(min(1.0, 0.5 * chord))
