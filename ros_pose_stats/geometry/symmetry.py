"""Poses that a proper rotation of the part carries into each other.

Candidates come from the contact polygons: a symmetry takes a stable face to a stable face
of equal height, corner to corner. Each candidate is tried on the full surface, with its
pockets and bores, and on the inertia. When in doubt, poses stay in separate groups.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..records import Part
from ..tolerances import SYMMETRY
from .convex_body import ConvexBody
from .equilibria import Equilibria, tied
from .features import Features, surface_features

Array = NDArray[np.float64]
Index = NDArray[np.int64]

MOST_TRIALS = 4096
"""Candidate rotations tried on one part. Beyond it (thousands of equal facets that are not
symmetric after all) the remaining poses stay separate."""

MOST_FACES = 4096
"""Stable faces that are looked at; a finely tessellated ball has more and needs no groups."""

PROBES = 12
"""Regions that a candidate must match before the whole surface is compared."""


def symmetry_groups(part: Part, found: Equilibria, pose: Index) -> Index:
    """Group number of each pose.

    Parameters
    ----------
    part : Part
    found : Equilibria
    pose : (S,) array
        Pose of each stable face.

    Returns
    -------
    (P,) array of int
        Groups numbered by their first pose.
    """
    group = np.arange(int(pose.max()) + 1)
    if group.shape[0] == 1 or found.order.shape[0] > MOST_FACES:
        return group
    kind = _kinds(found)
    if not len(_shared(kind, pose)):
        return group
    trial = Trial(part, found.body)
    kind = trial.refine(found, kind, _shared(kind, pose))
    trees = cKDTree(found.downs)
    left = MOST_TRIALS
    for face, other in _pairs(kind, pose):
        if group[pose[face]] == group[pose[other]]:
            continue
        for rotation in _candidates(found, face, other):
            left -= 1
            if left < 0:
                return _renumber(group)
            if trial.holds(rotation):
                gap, image = trees.query(found.downs @ rotation.T)
                for a, b in zip(pose[gap < SYMMETRY], pose[image[gap < SYMMETRY]], strict=True):
                    group[group == max(group[a], group[b])] = min(group[a], group[b])
                break
    return _renumber(group)


def _renumber(group: Index) -> Index:
    return np.asarray(np.unique(group, return_inverse=True)[1], dtype=np.int64)


def _kinds(found: Equilibria) -> Index:
    """Stable faces that agree in height, area, solid angle and number of corners."""
    arrays, faces = found.body.arrays, found.faces
    kind = tied(found.heights, SYMMETRY)
    kind = tied(np.diff(arrays.face_start)[faces].astype(np.float64), 0.5, kind)
    kind = tied(arrays.area[faces], SYMMETRY, kind)
    return tied(arrays.angle[faces], SYMMETRY, kind)


def _shared(kind: Index, pose: Index) -> Index:
    """Stable faces whose kind has members in two poses at least."""
    pairs = np.unique(np.column_stack([kind, pose]), axis=0)
    return np.flatnonzero((np.bincount(pairs[:, 0]) > 1)[kind])


def _pairs(kind: Index, pose: Index) -> Iterator[tuple[int, int]]:
    """Pairs of like stable faces in different poses."""
    shared = _shared(kind, pose)
    shared = shared[np.argsort(kind[shared], kind="stable")]
    for faces in np.split(shared, np.flatnonzero(np.diff(kind[shared])) + 1):
        listed = faces.tolist()
        for i, other in enumerate(listed):
            for face in listed[:i]:
                if pose[face] != pose[other]:
                    yield face, other


def _candidates(found: Equilibria, face: int, other: int) -> Iterator[Array]:
    """Rotations that take one contact polygon to the other, corner to corner."""
    here, there = _frames(found, face), _frames(found, other)
    size = [np.linalg.norm(frame[0], axis=1) for frame in (here, there)]
    start = int(np.argmax(size[0]))
    for shift in range(len(size[1])):
        turned = np.roll(size[1], start - shift)
        if np.abs(turned - size[0]).max() > SYMMETRY:
            continue
        a, b = here[0][start] / size[0][start], there[0][shift] / size[1][shift]
        rotation = np.column_stack([there[1], b, np.cross(there[1], b)]) @ np.vstack(
            [here[1], a, np.cross(here[1], a)])
        yield rotation


def _frames(found: Equilibria, stable: int) -> tuple[Array, Array]:
    """Corners about the foot of the centre of mass, and the face's normal."""
    face = found.faces[stable]
    normal = found.body.arrays.normal[face]
    foot = found.body.arrays.distance[face] * normal
    corners = found.body.polygon(face) - foot
    return corners - np.outer(corners @ normal, normal), normal


class Trial:
    """Tries rotations on the whole surface of one part.

    Parameters
    ----------
    part : Part
    body : ConvexBody
    """

    def __init__(self, part: Part, body: ConvexBody) -> None:
        self.features: Features = surface_features(part, body.radius)
        self.regions = cKDTree(self.features.regions)
        self.corners = cKDTree(self.features.corners) if len(self.features.corners) else None
        self.inertia = part.inertia / np.trace(part.inertia)

    def refine(self, found: Equilibria, kind: Index, faces: Index) -> Index:
        """Split the kinds of some faces by how the whole surface lies along their normals."""
        regions = self.features.regions
        weight = regions[:, 6] ** 2
        moments = np.zeros((8, found.order.shape[0]))
        for chunk in np.array_split(faces, 1 + faces.shape[0] * regions.shape[0] // 2**20):
            downs = found.downs[chunk].T
            height = regions[:, :3] @ downs
            facing = (regions[:, 3:6] @ downs) * regions[:, 6:7]
            for power in range(4):
                moments[2 * power, chunk] = weight @ facing
                facing *= height
                moments[2 * power + 1, chunk] = facing.sum(axis=0)
        for moment in moments:
            kind = tied(moment, 10.0 * SYMMETRY, kind)
        return kind

    def holds(self, rotation: Array) -> bool:
        """Whether the rotation carries surface and inertia into themselves."""
        turned = rotation @ self.inertia @ rotation.T
        if np.abs(turned - self.inertia).max() > SYMMETRY:
            return False
        regions = self.features.regions
        image = np.column_stack([regions[:, :3] @ rotation.T, regions[:, 3:6] @ rotation.T,
                                 regions[:, 6]])
        for part in (image[:PROBES], image):
            gap, partner = self.regions.query(part, distance_upper_bound=SYMMETRY)
            if not np.isfinite(gap).all() or len(np.unique(partner)) < len(part):
                return False
        if self.corners is None:
            return True
        gap, partner = self.corners.query(self.features.corners @ rotation.T,
                                          distance_upper_bound=SYMMETRY)
        return bool(np.isfinite(gap).all() and len(np.unique(partner)) == len(partner))
