"""A part with some of its features changed, made from what is known about the part before.

The outer shape is that of the convex hull: faces are moved by moving their planes, and
what does not move is taken over. The mass follows: stretching carries the material along, and a
sliver that is added or cut off has the part's mean density, its mass over the volume of its hull.
"""

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from ..errors import MeshError
from ..kernels.body.convex_body import BodyArrays
from ..kernels.mesh.measures import solid_moments
from ..mesh.hull import hull_of_corners
from ..mesh.vectors import lengths
from ..records import Part, scene as scenes
from ..resting import convex_body, poses
from .features import FACE, KINDS, Feature, find_features

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Moments(NamedTuple):
    """Mass, first moment (3,) and second moment (3, 3) about one point."""

    mass: float
    first: Array
    second: Array


class ChangedPart(NamedTuple):
    """A changed part."""

    part: Part  # its convex hull with its mass properties, in the frame of the part before
    origin: Index  # (F,); face of the body before that each face of its body was


class DesignSpace:
    """A part and all that can be changed on it.

    Attributes `resting`: of the part as it is.
    """

    def __init__(self, part: Part, cluster_tolerance: float = scenes.DEFAULT_CLUSTER_TOLERANCE,
                 round_sides: int = scenes.DEFAULT_ROUND_SIDES) -> None:
        self.part = part
        self.cluster_tolerance, self.round_sides = cluster_tolerance, round_sides
        self.resting: poses.RestingPoses = poses.resting_poses(part, cluster_tolerance,
                                                               round_sides)
        self.features: tuple[Feature, ...] = find_features(self.resting)

    @property
    def body(self) -> convex_body.ConvexBody:
        """Body of the part as it is."""
        return self.resting.body

    @cached_property
    def kinds(self) -> Index:
        """Kind (n,) of each feature, as a number: `CENTRE`, `STRETCH` or `FACE`."""
        return np.array([KINDS.index(one.kind) for one in self.features])

    @cached_property
    def _corners(self) -> Array:
        return np.ascontiguousarray(self.body.points[np.unique(self.body.arrays.corner)])

    @cached_property
    def _hull(self) -> tuple[Index, Index]:
        return hull_of_corners(self._corners)

    @cached_property
    def _moments(self) -> Moments:
        return _moments_of(self._corners, self._hull[0])

    def change(self, steps: ArrayLike) -> ChangedPart:
        """Make the part with changed features.

        `steps` (n,): of each of the `features`: metres, of stretching a fraction. Faces move
        outward. Raises MeshError if no body remains around its centre of mass.
        """
        values = np.asarray(steps, dtype=np.float64)
        shift, stretch = values[:3] / self.body.radius, 1.0 + values[3:6]
        corners, hull = self._corners * stretch, self._hull
        normals, distances = self._planes(values, stretch)
        reshaped = bool(values[self.kinds == FACE].any())
        if reshaped:
            corners = corners_of_planes(normals, distances, corners)
            hull = hull_of_corners(corners)
        mass, center, inertia = self._mass(
            np.diag(stretch), _moments_of(corners, hull[0]) if reshaped else None)
        body, plane = self._body(corners, hull, center + shift, normals)
        return ChangedPart(self._part(corners, body, mass, center + shift, inertia), plane)

    def change_one(self, number: int, step: float) -> ChangedPart:
        """Make the part with one changed feature; see `change`."""
        steps = np.zeros(len(self.features))
        steps[number] = step
        return self.change(steps)

    def _planes(self, values: Array, stretch: Array) -> tuple[Array, Array]:
        """Normals (F, 3) and distances (F,) of the faces, stretched and moved."""
        arrays = self.body.arrays
        normals = arrays.normal / stretch
        size = lengths(normals)
        distances = arrays.distance / size
        for feature, value in zip(self.features, values.tolist(), strict=True):
            if feature.kind == "face":
                distances[feature.planes] += value / self.body.radius
        return normals / size[:, None], distances

    def _mass(self, linear: Array, after: Moments | None) -> tuple[float, Array, Array]:
        """Mass, centre of mass and central inertia, in masses and radii before."""
        inertia = self.resting.inertia
        second = linear @ (0.5 * np.trace(inertia) * np.eye(3) - inertia) @ linear
        mass = 1.0
        center: Array = np.zeros(3)
        if after is not None:
            before, grown = self._moments, float(np.linalg.det(linear))
            density = 1.0 / (before.mass * grown)
            mass += density * (after.mass - grown * before.mass)
            if mass <= 0.0:
                raise MeshError("a part of which something is left", "one that was cut away",
                                "change the part less")
            center = density * (after.first - grown * linear @ before.first) / mass
            second = second + density * (after.second - grown * linear @ before.second @ linear)
            second -= mass * np.outer(center, center)
        return mass, center, np.trace(second) * np.eye(3) - second

    def _body(self, corners: Array, hull: tuple[Index, Index], center: Array, normals: Array
              ) -> tuple[convex_body.ConvexBody, Index]:
        """The body about its centre of mass, and the face before of each of its faces."""
        before = self.body
        points = corners - center
        farthest = float(lengths(points).max())
        points /= farthest
        points.flags.writeable = False
        arrays, tolerance = convex_body.polyhedron(points, *hull,
                                                   self.part.rounding / before.radius)
        plane = plane_of_face(arrays, normals)
        runs = tuple(replace(run, center=(run.center - center) / farthest,
                             radius=run.radius / farthest) for run in before.runs)
        return convex_body.ConvexBody(before.radius * farthest, points, arrays, tolerance, runs,
                                      before.run_of_face[plane], before.rounded), plane

    def _part(self, corners: Array, body: convex_body.ConvexBody, mass: float, center: Array,
              inertia: Array) -> Part:
        """The hull as a part, with its body, which is not to be rounded once more."""
        before, radius = self.part, self.body.radius
        vertices = before.center_of_mass + radius * corners
        fans = fan_triangles(body.arrays)
        part = Part(before.part_id, vertices, fans.astype(np.uint32), vertices, fans,
                    before.mass * mass, before.center_of_mass + radius * center,
                    inertia * (before.mass * radius * radius), before.warnings, before.rounding,
                    notes=before.notes)
        convex_body.keep_body(part, body, self.round_sides)
        return part


def _moments_of(corners: Array, triangles: Index) -> Moments:
    """Of the inside of a hull, at density one."""
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    middle = corners.mean(axis=0)
    inward = (np.cross(b - a, c - a) * (a - middle)).sum(axis=1) < 0.0
    outward = triangles.copy()
    outward[inward] = outward[inward][:, ::-1]
    volume, x, y, z, xx, yy, zz, xy, xz, yz = solid_moments(
        np.ascontiguousarray(corners), outward).tolist()
    return Moments(volume, np.array([x, y, z]),
                   np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


SNAP = 2e-5
"""Corners this close, in radii, to one that was there before are that corner. Where more than
three faces meet in rounded coordinates, their planes miss each other by as much."""

SAME = 1e-9
"""New corners this close are one."""


def corners_of_planes(normals: Array, distances: Array, before: Array) -> Array:
    """Corners (C, 3) of the body that planes bound.

    `normals` (K, 3): unit vectors, outward; `distances` (K,): from the origin, which lies inside.
    Planes that bound nothing are left out; `before` (H, 3): corners of the body that was changed.
    Raises MeshError if the origin is not inside, or the planes leave the body open.
    """
    if distances.min() <= 0.0:
        raise MeshError("faces around the centre of mass", "a face that was moved beyond it",
                        "change the part less")
    try:
        dual = ConvexHull(normals / distances[:, None]).equations
    except QhullError as error:
        raise MeshError("planes that bound a body", "planes that leave it open",
                        "change the part less") from error
    dual = np.unique(dual, axis=0)
    if dual[:, 3].max() >= 0.0:
        raise MeshError("planes that bound a body", "planes that leave it open",
                        "change the part less")
    corners = dual[:, :3] / -dual[:, 3:]
    gap, nearest = cKDTree(before).query(corners, distance_upper_bound=SNAP)
    stays = np.isfinite(gap)
    fresh = corners[~stays]
    if len(fresh):
        tree = cKDTree(fresh)
        first = np.arange(len(fresh))
        for one, other in sorted(tree.query_pairs(SAME)):
            first[other] = min(first[other], first[one])
        fresh = fresh[np.unique(first)]
    return np.ascontiguousarray(np.concatenate((before[np.unique(nearest[stays])], fresh)))


def plane_of_face(arrays: BodyArrays, normals: Array) -> Index:
    """Which of some planes (K, 3) each face (F,) of a body lies in; a body has none twice."""
    return np.asarray(cKDTree(normals).query(arrays.normal)[1], dtype=np.int64)


def fan_triangles(arrays: BodyArrays) -> Index:
    """Triangles (T, 3) of the faces of a body, wound outward, each face a fan."""
    sizes = np.diff(arrays.face_start)
    side = np.arange(arrays.corner.shape[0])
    place = side - arrays.face_start[arrays.face]
    inner = side[(place > 0) & (place < sizes[arrays.face] - 1)]
    first = arrays.face_start[arrays.face[inner]]
    return np.stack((arrays.corner[first], arrays.corner[inner], arrays.corner[inner + 1]), axis=1)
