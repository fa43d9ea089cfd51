"""Motions that carry a part into itself, and the poses that they exchange.

A rotation of the whole surface, with its pockets and bores, gathers poses to groups: a
camera cannot tell them apart. A rotation or reflection of the body that is dropped, its
hull, gathers them to units: they are equally probable.

Candidates come from planes: a symmetry takes two faces of the hull to two like ones that
lean to each other alike. Each candidate is tried on the inertia and on the surface, by
places and never by vertices, for a file may divide alike curves in different ways. When
in doubt, poses stay separate.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ..kernels.features.surface_features import AREA, NORMAL, first_stray, surface_of
from ..kernels.mesh import connections
from ..kernels.principal_axes import is_kept
from ..mesh.vectors import cross, lengths
from ..records import Array, Index, Part
from ..tolerances import COPLANAR, SYMMETRY
from .convex_body import ConvexBody
from .equilibria import Clusters, Equilibria

MOST_EFFORT = 2**21
"""Most samples compared on one part, in about a second. Where more would be needed the
remaining poses stay separate."""

MOST_FACES = 4096
"""Most stable faces that are compared; a finely tessellated ball has more and needs no
groups."""

LARGEST = 32
"""Faces of the hull, the largest, of which two are followed."""

MOST_LIKE = 24
"""Faces like one of these that are tried, or as many as there are poses: of the facets
of a round surface any will do."""

SAME_PLACE = 5e-3
"""Differences of distances, in radii, cosines, and areas, as a share, of like faces."""

UPRIGHT_COSINE = 0.9
"""Cosine of the angle of two planes from which on both do not tell a motion."""

SAME_DIRECTION = 0.1
"""Angle within which a motion takes the face of one pose to that of another, radians;
facets of a round surface are up to 0.4 apart."""

OVERHEAD = 64  # cost of setting up one comparison, in samples compared

PROBES = 12
"""Samples that a candidate must match before the whole surface is compared: of the
largest regions, and those that refuted earlier candidates."""

_ALL = np.empty(0, dtype=np.int64)
_NO_SHIFT = np.zeros(3)


class PoseSymmetry(NamedTuple):
    """Poses that motions of a part exchange."""

    group: Index  # (P,) by rotations of the surface, numbered by their first pose
    unit: Index  # (P,) by rotations and reflections of the hull, likewise
    images: Index  # (S, P) poses to which each motion takes the poses; the first: none


class Motions(NamedTuple):
    """Rotations and reflections, and where they take poses."""

    matrices: Array  # (C, 3, 3)
    images: Index  # (C, P)


def separate_poses(poses: int) -> PoseSymmetry:
    """No two of the poses are alike."""
    identity: Index = np.arange(poses)
    return PoseSymmetry(identity, identity, identity[None])


def find_symmetry(
    part: Part,
    equilibria: Equilibria,
    clusters: Clusters,
    surface: "Callable[[], SurfaceTrial]",
) -> PoseSymmetry:
    """Find groups and units of the poses."""
    poses = len(clusters.lowest_face)
    separate = separate_poses(poses)
    identity = separate.group
    heights = np.sort(equilibria.heights[clusters.lowest_face])
    if (
        poses == 1
        or equilibria.order.shape[0] > MOST_FACES
        or np.diff(heights).min() > SYMMETRY
    ):
        return separate
    matrices = candidate_motions(equilibria.body, max(MOST_LIKE, poses))
    motions = _exchanging(matrices, equilibria, clusters, part)
    if not len(motions.matrices):
        return separate
    hull = hull_trial(part, equilibria.body)
    images: list[Index] = [identity]
    group = identity
    for image, matrices in _by_image(motions):
        is_symmetry = False
        for matrix in matrices:
            # What carries the surface carries its hull, though facets may hide it.
            if (
                np.linalg.det(matrix) > 0.0
                and (group[image] != group).any()
                and surface().holds(matrix)
            ):
                group = _orbits(poses, [image], group)
                is_symmetry = True
            is_symmetry = is_symmetry or hull.holds(matrix)
        if is_symmetry:
            images.append(image)
    return PoseSymmetry(group, _orbits(poses, images), np.array(images))


def pair_orbits(images: Index) -> Index:
    """Orbit (P, P) of each pair of poses under motions (S, P) of the part."""
    poses = images.shape[1]
    pair = np.arange(poses * poses).reshape(poses, poses)
    targets = images[1:, :, None] * poses + images[1:, None, :]
    links = np.stack(
        (np.broadcast_to(pair, targets.shape).ravel(), targets.ravel()), axis=1
    )
    return connections.component_labels(poses * poses, links).reshape(poses, poses)


def _orbits(poses: int, images: list[Index], labels: Index | None = None) -> Index:
    """Number (P,) of each pose's orbit, by their first pose; `labels`: joined before."""
    links = [np.column_stack((np.arange(poses), image)) for image in images]
    if labels is not None:
        first = np.unique(labels, return_index=True)[1]
        links.append(np.column_stack((np.arange(poses), first[labels])))
    return connections.component_labels(poses, np.concatenate(links))


def _by_image(motions: Motions) -> Iterator[tuple[Index, Array]]:
    """Where motions take the poses, but for the identity, and those that do so."""
    images, kind = np.unique(motions.images, axis=0, return_inverse=True)
    kind = kind.reshape(-1)
    for number, image in enumerate(images):
        if not np.array_equal(image, np.arange(len(image))):
            yield image, motions.matrices[kind == number]


def candidate_motions(body: ConvexBody, most_like: int) -> Array:
    """Motions (C, 3, 3) that take two faces of a body to two like ones.

    The first is one of the largest that few are like. Of the others across it two are
    taken, one by one: another such, and one of those that make most of the surface, for
    uneven facets of a curve may be like nothing else.
    """
    normal = body.arrays.normal
    area = body.arrays.area
    largest = np.argsort(-area, kind="stable")
    first = _like_faces(body, largest[:LARGEST], most_like)[0]
    is_across = np.abs(normal[largest] @ normal[first[0]]) < UPRIGHT_COSINE
    if not is_across.any():
        return np.empty((0, 3, 3))
    motions = []
    for second in _like_faces(body, largest[is_across][:LARGEST], 4 * most_like):
        cosine = normal[first[0]] @ normal[second[0]]
        gap = np.abs(normal[first] @ normal[second].T - cosine)
        pairs = np.argwhere(gap <= SAME_PLACE)
        frames = _frames(normal[first[pairs[:, 0]]], normal[second[pairs[:, 1]]])
        mirrored = frames * np.array((1.0, 1.0, -1.0))[:, None]
        for images in (frames, mirrored):
            motions.append(images.transpose(0, 2, 1) @ frames[0])
    return np.concatenate(motions)


def _like_faces(body: ConvexBody, faces: Index, most: int) -> list[Index]:
    """One of some faces, and those that are like it: which few and which many are."""
    distance = body.arrays.distance
    area = body.arrays.area
    difference = np.abs(distance[faces, None] - distance)
    difference += np.abs(area[faces, None] / area - 1.0)
    difference[np.arange(len(faces)), faces] = -1.0  # each comes first itself
    number_alike = (difference <= SAME_PLACE).sum(axis=1)
    rarest = int(number_alike.argmin())
    broadest = int((number_alike * area[faces]).argmax())
    return [
        np.argsort(difference[k], kind="stable")[: min(number_alike[k], most)]
        for k in dict.fromkeys((rarest, broadest))
    ]


def _frames(first: Array, second: Array) -> Array:
    """Right-handed axes (C, 3, 3) as rows, from normals (C, 3) of two planes."""
    third = cross(first, second)
    third /= lengths(third)[:, None]
    return np.stack((first, cross(third, first), third), axis=1)


def _exchanging(
    matrices: Array, equilibria: Equilibria, clusters: Clusters, part: Part
) -> Motions:
    """Motions that keep the inertia and take poses to poses as high."""
    scale = float(np.trace(part.inertia))
    turned = matrices @ part.inertia @ matrices.transpose(0, 2, 1)
    keeps = np.abs(turned - part.inertia).max(axis=(1, 2)) <= SYMMETRY * scale
    matrices = matrices[keeps]
    lowest = clusters.lowest_face
    supports = np.flatnonzero(clusters.is_support)
    images = equilibria.downs[lowest] @ matrices.transpose(0, 2, 1)
    cosines = images @ equilibria.downs[supports].T
    image = clusters.pose[supports][cosines.argmax(axis=2)]
    heights = equilibria.heights[lowest]
    fits = (np.abs(heights[image] - heights) <= SYMMETRY).all(axis=1)
    faces = np.bincount(clusters.pose[supports])
    reach = np.where(faces > 1, 0.5, 1.0 - np.cos(SAME_DIRECTION))
    fits &= (1.0 - cosines.max(axis=2) <= reach[image]).all(axis=1)
    fits &= (np.sort(image, axis=1) == np.arange(len(lowest))).all(axis=1)
    return Motions(matrices[fits], image[fits])


class SurfaceTrial:
    """A surface of a part, on which motions are tried."""

    def __init__(
        self, points: Array, triangles: Index, inertia: Array, flatness: float
    ) -> None:
        self.tolerance = max(SYMMETRY, flatness)
        self.surface = surface_of(points, triangles, flatness, self.tolerance)
        self.inertia = inertia
        self.probes = list(range(min(PROBES, len(self.surface.sample))))
        self.effort = 0

    def is_turned(self, axis: Array) -> bool:
        """Whether all regions face the axis or away from it, as of a turned part."""
        centroid = self.surface.regions[:, :3]
        normal = self.surface.regions[:, NORMAL : NORMAL + 3]
        size = np.sqrt(self.surface.regions[:, AREA])
        across = (np.cross(centroid, normal) * axis).sum(axis=1)
        return bool((np.abs(across) * size < SYMMETRY).all())

    def holds(self, motion: Array) -> bool:
        """Whether a rotation or reflection carries surface and inertia into themselves."""
        if self.effort > MOST_EFFORT or not is_kept(self.inertia, motion, SYMMETRY):
            return False
        motion = np.ascontiguousarray(motion)
        if self._first_stray(motion, np.array(self.probes, dtype=np.int64)) >= 0:
            return False
        stray = self._first_stray(motion, _ALL)
        if stray >= 0:
            self.probes = [stray, *self.probes][: 2 * PROBES]
        return stray < 0

    def _first_stray(self, motion: Array, chosen: Index) -> int:
        self.effort += OVERHEAD + (len(chosen) or len(self.surface.sample))
        return first_stray(self.surface, motion, _NO_SHIFT, chosen, self.tolerance)


def surface_trial(part: Part, body: ConvexBody) -> SurfaceTrial:
    """The whole surface of a part."""
    # Wider than for the hull, but a tenth of the thickness at most: both sides of a
    # plate.
    flatness = min(max(COPLANAR, body.tolerance), 100.0 * body.tolerance or COPLANAR)
    points = (part.surface_vertices - part.center_of_mass) / body.radius
    return SurfaceTrial(points, part.surface_triangles, part.inertia, flatness)


def hull_trial(part: Part, body: ConvexBody) -> SurfaceTrial:
    """The convex body that is dropped."""
    arrays = body.arrays
    size = np.diff(arrays.face_start)
    side = np.arange(len(arrays.corner))
    inner = side[(arrays.face_start[:-1][arrays.face] != side)]
    inner = inner[inner + 1 < arrays.face_start[arrays.face[inner] + 1]]
    triangles = np.stack(
        (
            arrays.corner[arrays.face_start[arrays.face[inner]]],
            arrays.corner[inner],
            arrays.corner[inner + 1],
        ),
        axis=1,
    )
    assert len(triangles) == int((size - 2).sum())
    return SurfaceTrial(body.points, triangles, part.inertia, body.tolerance)
