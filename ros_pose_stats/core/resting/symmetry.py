"""Poses that a proper rotation of the part carries into each other.

Candidates come from the contact polygons: a symmetry takes a stable face to a stable
face of equal height, corner to corner. Each candidate is tried on the full surface,
with its pockets and bores, and on the inertia. When in doubt, poses stay in separate
groups.
"""

from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import islice
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..kernels.features.surface_features import moments_along, regions_and_corners
from ..kernels.mesh import connections, nearness
from ..kernels.principal_axes import is_kept
from ..mesh.vectors import cross
from ..records import Array, Index, Part
from ..tolerances import COPLANAR, SYMMETRY
from .convex_body import ConvexBody
from .equilibria import Equilibria, group_ties


class Frame(NamedTuple):
    """A face about the foot of the centre of mass on it."""

    corners: Array  # (k, 3)
    size: Array  # (k,); their distances
    normal: Array


MOST_EFFORT = 2**21
"""Most features compared on one part, in about a second. Where more would be needed
(thousands of equal facets that are not symmetric after all) the remaining poses stay
separate."""

MOST_FACES = 4096
"""Most stable faces that are compared; a finely tessellated ball has more and needs no
groups."""

FEW_PAIRS = 128
"""Pairs of like stable faces that are tried before the whole surface is measured. On a
part without symmetry few faces are alike, by chance only, and none of the pairs
fits."""


def symmetry_groups(
    part: Part,
    equilibria: Equilibria,
    pose: Index,
    surface: "Callable[[], SurfaceTrial]",
) -> Index:
    """Group number of each pose (P,), by their first pose.

    `pose` (S,): -1 for shelves.
    """
    poses = int(pose.max()) + 1
    separate = np.arange(poses)
    if poses == 1 or equilibria.order.shape[0] > MOST_FACES:
        return separate
    kind = kinds_of(equilibria)
    shared_faces = _shared_faces(kind, pose)
    if not len(shared_faces):
        return separate
    frames = cache(partial(frame_of, equilibria))
    # Few pairs of like faces, and no rotation that fits polygons and inertia.
    pairs = list(islice(_pairs(kind, shared_faces), FEW_PAIRS + 1))
    if len(pairs) <= FEW_PAIRS and not any(
        is_kept(part.inertia, rotation, SYMMETRY)
        for face, image in pairs
        for rotation in candidate_rotations(frames, face, image)
    ):
        return separate
    trial = surface()
    orbit = _find_orbits(
        equilibria, trial.refine(equilibria, kind), pose, frames, trial
    )
    is_support = pose >= 0  # poses with faces in one orbit are one group
    links = np.column_stack((pose[is_support], poses + orbit[is_support]))
    return connections.component_labels(poses + pose.shape[0], links)[:poses]


def _find_orbits(
    equilibria: Equilibria,
    kind: Index,
    pose: Index,
    frames: Callable[[int], Frame],
    trial: "SurfaceTrial",
) -> Index:
    """Number (S,) of each stable face's orbit under rotations of the surface.

    All of them take the first face of a kind to another or to itself.
    """
    orbit = np.arange(pose.shape[0])
    trees = cKDTree(equilibria.downs)
    for face, target in _pairs(kind, _shared_faces(kind, pose)):
        if face != target and orbit[face] == orbit[target]:
            continue
        for rotation in candidate_rotations(frames, face, target):
            if trial.effort > MOST_EFFORT:
                return orbit
            if trial.holds(rotation):
                gap, nearest_face = trees.query(equilibria.downs @ rotation.T)
                is_carried = (gap < SYMMETRY) & (pose >= 0) & (pose[nearest_face] >= 0)
                links = np.column_stack(
                    (orbit[is_carried], orbit[nearest_face[is_carried]])
                )
                orbit = connections.component_labels(pose.shape[0], links)[orbit]
                break
    return orbit


def kinds_of(equilibria: Equilibria) -> Index:
    """Stable faces that agree in height, area, solid angle and number of corners."""
    arrays = equilibria.body.arrays
    faces = equilibria.faces
    corners = (arrays.face_start[faces + 1] - arrays.face_start[faces]).astype(
        np.float64
    )
    return group_ties(
        (equilibria.heights, SYMMETRY),
        (corners, 0.5),
        (arrays.area[faces], SYMMETRY),
        (arrays.angle[faces], SYMMETRY),
    )


def _shared_faces(kind: Index, pose: Index) -> Index:
    """Stable faces whose kind has members in two poses at least, kind by kind."""
    if int(kind.max()) + 1 == kind.shape[0]:
        return np.empty(0, dtype=np.int64)
    is_support = pose >= 0
    poses = int(pose.max()) + 1
    pairs = np.unique((kind * poses + pose)[is_support])
    in_several_poses = np.bincount(pairs // poses, minlength=int(kind.max()) + 1) > 1
    faces = np.flatnonzero(in_several_poses[kind] & is_support)
    return faces[np.argsort(kind[faces], kind="stable")]


def _pairs(kind: Index, faces: Index) -> Iterator[tuple[int, int]]:
    """The first of the shared faces of each kind, with itself and its like."""
    kinds: dict[int, int] = {}
    for number, face in zip(kind[faces].tolist(), faces.tolist(), strict=True):
        yield kinds.setdefault(number, face), face


def candidate_rotations(
    frames: Callable[[int], Frame], face: int, target: int
) -> Iterator[Array]:
    """Rotations but the identity that take one contact polygon to the other."""
    frame = frames(face)
    target_frame = frames(target)
    start = int(np.argmax(frame.size))
    count = len(frame.size)
    axes = _axes(frame.normal, frame.corners[start] / frame.size[start])
    is_like = (np.abs(target_frame.size - frame.size[start]) <= SYMMETRY).tolist()
    doubled_size = np.concatenate([target_frame.size, target_frame.size])
    for turn in range(1 if face == target else 0, count):
        begin = turn if face == target else (turn - start) % count
        shift = (begin + start) % count
        if (
            is_like[shift]
            and np.abs(doubled_size[begin : begin + count] - frame.size).max()
            <= SYMMETRY
        ):
            yield (
                _axes(
                    target_frame.normal,
                    target_frame.corners[shift] / target_frame.size[shift],
                ).T
                @ axes
            )


def _axes(normal: Array, direction: Array) -> Array:
    """Right-handed axes as rows: a normal, a unit vector across it, and the third."""
    return np.array([normal, direction, cross(normal, direction)])


def frame_of(equilibria: Equilibria, stable: int) -> Frame:
    """Frame of a stable face."""
    face = equilibria.faces[stable]
    normal = equilibria.body.arrays.normal[face]
    foot = equilibria.body.arrays.distance[face] * normal
    corners = equilibria.body.polygon(face) - foot
    corners = corners - np.outer(corners @ normal, normal)
    return Frame(corners, np.sqrt((corners**2).sum(axis=1)), normal)


OVERHEAD = 64  # cost of setting up one comparison, in features compared

PROBES = 12
"""Regions that a candidate must match before the whole surface is compared: the
largest, and those that refuted earlier candidates."""

_ALL = np.empty(0, dtype=np.int64)


class SurfaceTrial:
    """The whole surface of one part, on which rotations are tried."""

    def __init__(self, part: Part, body: ConvexBody) -> None:
        points = (part.surface_vertices - part.center_of_mass) / body.radius
        # Wider than for the hull, but a tenth of the thickness at most: both sides of a
        # plate.
        flatness = min(
            max(COPLANAR, body.tolerance), 100.0 * body.tolerance or COPLANAR
        )
        regions, corners = regions_and_corners(points, part.surface_triangles, flatness)
        # (G, 7); centroid, normal times size and size (square root of the area) of each
        # connected planar region, largest first, in radii. The normal is weighed by the
        # size because a small region's normal is known only that well from rounded
        # coordinates
        self.regions = nearness.feature_grid(regions, SYMMETRY)
        # (C, 3); vertices where at least three regions meet
        self.corners = nearness.feature_grid(points[corners], SYMMETRY)
        self.inertia = part.inertia
        self.probes = list(range(min(PROBES, len(regions))))
        self.effort = 0

    def refine(self, equilibria: Equilibria, kind: Index) -> Index:
        """Split kinds by moments of the whole surface along the faces' normals."""
        moments = moments_along(self.regions.rows, equilibria.downs)
        return group_ties(
            *((moment, 10.0 * SYMMETRY) for moment in moments.T), groups=kind
        )

    def is_turned(self, axis: Array) -> bool:
        """Whether all regions face the axis or away from it, as of a turned part."""
        centroid = self.regions.rows[:, :3]
        normal = self.regions.rows[:, 3:6]
        return bool(
            (np.abs((np.cross(centroid, normal) * axis).sum(axis=1)) < SYMMETRY).all()
        )

    def holds(self, rotation: Array) -> bool:
        """Whether the rotation carries surface and inertia into themselves."""
        if not is_kept(self.inertia, rotation, SYMMETRY):
            return False
        probes = np.array(self.probes, dtype=np.int64)
        if self._first_unmatched(self.regions, rotation, probes) >= 0:
            return False
        unmatched = self._first_unmatched(self.regions, rotation, _ALL)
        if unmatched >= 0:
            self.probes = [unmatched, *self.probes][: 2 * PROBES]
            return False
        return (
            not len(self.corners.rows)
            or self._first_unmatched(self.corners, rotation, _ALL) < 0
        )

    def _first_unmatched(
        self, features: nearness.FeatureGrid, rotation: Array, selection: Index
    ) -> int:
        """First feature that meets no like one where a rotation puts it; -1: none."""
        self.effort += OVERHEAD + (len(selection) or len(features.rows))
        return nearness.first_unmatched(features, rotation, selection)
