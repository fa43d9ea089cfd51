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

"""Motions that carry a part into itself, and the poses that they exchange.

A rotation of the whole surface, with its pockets and bores, gathers poses to groups: a
camera cannot tell them apart. A rotation or reflection of the body that is dropped, its
hull, gathers them to units: they are equally probable.

Candidates come from planes: a symmetry takes two faces of the hull to two like ones
that lean to each other alike. Each candidate is tried on the inertia and on the
surface, by places and never by vertices, for a file may divide alike curves in
different ways. When in doubt, poses stay separate.
"""

from collections.abc import Callable, Set
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..kernels.features.motions import (
    SAME_PLACE,
    Planes,
    PosePlaces,
    candidate_motions,
    exchanging_motions,
    fit_motion,
)
from ..kernels.features.surface_features import (
    AREA,
    NORMAL,
    SMALLEST_AREA,
    first_stray,
    surface_of,
    tree_of,
)
from ..kernels.mesh import connections
from ..kernels.mesh.triangle_tree import TriangleTree
from ..kernels.principal_axes import is_kept
from ..mesh.vectors import lengths
from ..records import Array, Index, Mask, Part
from ..tolerances import COPLANAR, SYMMETRY
from .convex_body import ConvexBody, body_of
from .equilibria import Clusters, Equilibria
from .threads import Thread, find_thread

MOST_EFFORT = 2**21
"""Most samples compared on one part, in about a second. Where more would be needed the
remaining poses stay separate."""

MOST_FACES = 4096
"""Most stable faces that are compared; a finely tessellated ball has more and needs no
groups."""

MOST_LIKE = 24
"""Faces like one of these that are tried, or as many as there are poses: of the facets
of a round surface any will do."""

ROUNDED = 1e-7
"""Difference of motions by rounded coordinates; below it another is not worth a try."""

SAME_DIRECTION = 0.1
"""Angle within which a motion takes the face of one pose to that of another, radians;
facets of a round surface are up to 0.4 apart."""

NEAR = 0.05
"""How far a motion may take corners off the hull, in radii, if the surface is still to
be tried: as much as the depth of a thread that ends on it."""

HIDDEN = 1e-3
"""The same where no thread is in question, but facets of the hull may be uneven."""

MOST_CORNERS = 512
"""Corners, evenly among all, that tell whether a motion is worth a try."""

OVERHEAD = 64  # cost of setting up one comparison, in samples compared

PROBES = 12
"""Samples that a candidate must match before the whole surface is compared: of the
largest regions, and those that refuted earlier candidates."""

MOST_AXES = 4
"""Axes about which a thread is looked for."""

INERTIA_SLACK = 4.0
"""Share of the trace of the inertia by which it may be off where the centre of mass is,
by one radius: what makes that lies at most so far out, beside that radius squared."""

EVEN = 0.1
"""Share of its barrier by which a pose may be higher than one that a motion takes it
to, where the centre of mass is beside the axis of a thread: facets of a coil are
shallow, and it comes to rest on the low ones."""

NO_SHIFT = np.zeros(3)


class PoseSymmetry(NamedTuple):
    """Poses that motions of a part exchange."""

    group: Index  # (P,) by rotations of the surface, numbered by their first pose
    unit: Index  # (P,) by rotations and reflections of the hull, likewise
    images: Index  # (S, P) poses to which each motion takes the poses; the first: none


class Motions(NamedTuple):
    """Rotations and reflections, and where they take poses."""

    matrices: Array  # (C, 3, 3)
    images: Index  # (C, P)

    def pick(self, chosen: Mask) -> "Motions":
        """Some of them."""
        return Motions(self.matrices[chosen], self.images[chosen])


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
    heights = np.sort(equilibria.heights[clusters.lowest_face])
    symmetry = separate_poses(poses)
    if (
        poses == 1
        or equilibria.order.shape[0] > MOST_FACES
        or np.diff(heights).min() > SAME_PLACE
    ):
        return symmetry
    search = _Search(part, equilibria, clusters, surface)
    if np.diff(heights).min() <= SYMMETRY:
        symmetry = search.join(symmetry, SYMMETRY)
    # Mirror images as high to the last digit are no rotated ones but for rounding.
    first = np.unique(symmetry.unit, return_index=True)[1]
    heights = np.sort(equilibria.heights[clusters.lowest_face[first]])
    if np.diff(heights).min(initial=1.0) <= SAME_PLACE:
        symmetry = search.join(symmetry, SAME_PLACE)
    return symmetry


class _Search:
    """Motions of one part that are still to be tried."""

    def __init__(
        self,
        part: Part,
        equilibria: Equilibria,
        clusters: Clusters,
        surface: "Callable[[], SurfaceTrial]",
    ) -> None:
        self.part = part
        self.equilibria = equilibria
        self.clusters = clusters
        self.surface = surface
        most_like = max(MOST_LIKE, len(clusters.lowest_face))
        self.hull = hull_trial(part, equilibria.body)
        self.candidates = candidate_motions(self.hull.planes, most_like)

    def join(self, symmetry: PoseSymmetry, tolerance: float) -> PoseSymmetry:
        """Take poses together that motions exchange.

        `tolerance`: how far heights may be apart. Above `SYMMETRY` the centre of mass
        may be off its place by what the division of curves and a thread's end make.
        """
        motions = _exchanging(
            self.candidates, self.equilibria, self.clusters, self.part, tolerance
        )
        group = symmetry.group
        listed = {image.tobytes() for image in symmetry.images}
        slack = 0.0
        if tolerance > SYMMETRY:
            motions = motions.pick((group[motions.images] != group).any(axis=1))
            heights = self.equilibria.heights[self.clusters.lowest_face]
            rise = np.abs(heights[motions.images] - heights)
            is_uneven = (rise > EVEN * self.clusters.barrier).any(axis=1)
            motions = motions.pick(np.logical_not(is_uneven))
            is_near = [self.hull.is_near(m, NEAR) for m in motions.matrices]
            motions = motions.pick(np.array(is_near, dtype=np.bool_))
            slack = self._slack_of(motions.matrices)
            if not slack:
                return symmetry
        reach = NEAR if slack else HIDDEN
        images = list(symmetry.images)
        generators: list[Index] = []
        generated = listed
        by_image = _by_image(motions)
        for key, matrices in by_image.items():
            image = np.frombuffer(key, dtype=np.int64)
            is_symmetry = key in generated
            for matrix in matrices:
                joins = (group[image] != group).any() and np.linalg.det(matrix) > 0.0
                if is_symmetry and not joins:
                    continue
                carries_hull = self._holds(self.hull, matrix, slack)
                is_symmetry = is_symmetry or carries_hull
                # What carries the surface carries its hull, though facets may hide it.
                if (
                    joins
                    and (carries_hull or self.hull.is_near(matrix, reach))
                    and self._holds(self.surface(), matrix, slack)
                ):
                    group = _orbits([image], group)
                    is_symmetry = True
            if is_symmetry and key not in listed:
                images.append(image)
                if key not in generated:
                    generators.append(image)
                    candidates = by_image.keys() | listed
                    generated = _products(symmetry.images, generators, candidates)
        return PoseSymmetry(group, _orbits(images), np.array(images))

    def _holds(self, trial: "SurfaceTrial", matrix: Array, slack: float) -> bool:
        """Whether a motion or the one that fits best nearby carries the surface."""
        if not slack and trial.holds(matrix):
            return True
        motion, shift = fit_motion(self.hull.planes, matrix)
        if slack:
            return trial.holds(motion, shift, slack)
        return np.abs(motion - matrix).max() > ROUNDED and trial.holds(motion)

    def _slack_of(self, matrices: Array) -> float:
        """How far the centre of mass may be off its place; threads are left out.

        `matrices` (C, 3, 3): motions of the hull, about whose axes a thread may wind.
        """
        if not len(matrices):
            return 0.0
        surface = self.surface()
        axes: list[Array] = []
        for matrix in matrices[np.linalg.det(matrices) > 0.0]:
            axis = axis_of(matrix)
            if len(axes) < MOST_AXES and all(
                abs(axis @ other) < 1.0 - SAME_PLACE for other in axes
            ):
                axes.append(axis)
                shift = fit_motion(self.hull.planes, matrix)[1]
                center = np.linalg.pinv(np.eye(3) - matrix, SAME_PLACE) @ shift
                thread = find_thread(surface.surface, axis, center)
                if thread is not None:
                    surface.leave_out(thread)
                    break
        return surface.mass_slack


def pair_orbits(images: Index) -> Index:
    """Orbit (P, P) of each pair of poses under motions (S, P) of the part."""
    poses = images.shape[1]
    pair = np.arange(poses * poses).reshape(poses, poses)
    targets = images[1:, :, None] * poses + images[1:, None, :]
    links = np.stack(
        (np.broadcast_to(pair, targets.shape).ravel(), targets.ravel()), axis=1
    )
    return connections.component_labels(poses * poses, links).reshape(poses, poses)


def _orbits(images: list[Index], labels: Index | None = None) -> Index:
    """Number (P,) of each pose's orbit by its first pose; `labels`: joined before."""
    targets = list(images)
    if labels is not None:
        first = np.unique(labels, return_index=True)[1]
        targets.append(first[labels])
    poses = len(images[0])
    links = np.empty((len(targets), poses, 2), np.int64)
    links[..., 0] = np.arange(poses)
    links[..., 1] = targets
    return connections.component_labels(poses, links.reshape(-1, 2))


def _by_image(motions: Motions) -> dict[bytes, list[Array]]:
    """Where motions take the poses, but for the identity, and those that do so."""
    alike: dict[bytes, list[Array]] = {}
    for image, matrix in zip(motions.images, motions.matrices, strict=True):
        alike.setdefault(image.tobytes(), []).append(matrix)
    alike.pop(np.arange(motions.images.shape[1]).tobytes(), None)
    return alike


def _products(
    images: Index, generators: list[Index], candidates: Set[bytes]
) -> set[bytes]:
    """Images, and those of the candidates that generators make of them."""
    latest = list(images)
    products = {image.tobytes() for image in latest}
    while latest:
        product = latest.pop()
        for generator in generators:
            longer = product[generator]
            key = longer.tobytes()
            if key in candidates and key not in products:
                products.add(key)
                latest.append(longer)
    return products


def axis_of(rotation: Array) -> Array:
    """Axis of a rotation but the identity: the vector that it keeps."""
    # R + R' - (trace - 1) 1 is (3 - trace) times the projection on the axis.
    doubled = rotation + rotation.T - (np.trace(rotation) - 1.0) * np.eye(3)
    column: Array = doubled[:, np.diagonal(doubled).argmax()]
    axis: Array = column / np.sqrt((column * column).sum())
    return axis


def _exchanging(
    matrices: Array,
    equilibria: Equilibria,
    clusters: Clusters,
    part: Part,
    tolerance: float,
) -> Motions:
    """Motions that keep the inertia and take poses to poses as high."""
    lowest = clusters.lowest_face
    supports = np.flatnonzero(clusters.is_support)
    pose = clusters.pose[supports]
    places = PosePlaces(
        equilibria.downs[lowest],
        equilibria.heights[lowest],
        np.where(np.bincount(pose) > 1, 0.5, 1.0 - np.cos(SAME_DIRECTION)),
        equilibria.downs[supports],
        pose,
    )
    return Motions(*exchanging_motions(matrices, part.inertia, places, tolerance))


class SurfaceTrial:
    """A surface of a part, on which motions are tried."""

    def __init__(
        self, points: Array, triangles: Index, inertia: Array, flatness: float
    ) -> None:
        self.tolerance = max(SYMMETRY, flatness)
        self.surface = surface_of(points, triangles, flatness, self.tolerance)
        self.inertia = inertia
        self.solid: Index = np.arange(len(self.surface.sample))  # what is compared
        self.probes = list(range(min(PROBES, len(self.solid))))
        self.effort = 0
        self.thread_moment = 0.0  # most that threads left out add to the first moment

    @cached_property
    def _tree(self) -> TriangleTree:
        """Its triangles by place; few parts have a motion that is worth a try."""
        return tree_of(self.surface)

    @property
    def mass_slack(self) -> float:
        """How far the centre of mass may be off, in radii.

        For the division of curves as if one half were outside of them, and the other on
        them.
        """
        regions = self.surface.regions
        rise = (regions[:, :3] * regions[:, NORMAL : NORMAL + 3]).sum(axis=1)
        volume = float((rise * regions[:, AREA]).sum()) / 3.0
        reach = lengths(regions[:, :3]) * regions[:, AREA]
        curve_moment = 0.25 * float((self.surface.slack * reach).sum())
        return curve_moment / volume + self.thread_moment / volume

    @cached_property
    def planes(self) -> Planes:
        """Its planar regions."""
        order = np.argsort(-self.surface.regions[:, AREA], kind="stable")
        regions = self.surface.regions[order]
        regions = regions[regions[:, AREA] > SMALLEST_AREA]
        normal = np.ascontiguousarray(regions[:, NORMAL : NORMAL + 3])
        distance = (regions[:, :3] * normal).sum(axis=1)
        return Planes(normal, distance, regions[:, AREA].copy())

    def leave_out(self, thread: "Thread") -> None:
        """Take a thread for the surface that it winds on."""
        self.solid = np.flatnonzero(~thread.on_thread)
        self.probes = self.solid[:PROBES].tolist()
        self.thread_moment += thread.moment

    def is_turned(self, axis: Array) -> bool:
        """Whether all regions face the axis or away from it, as of a turned part."""
        centroid = self.surface.regions[:, :3]
        normal = self.surface.regions[:, NORMAL : NORMAL + 3]
        size = np.sqrt(self.surface.regions[:, AREA])
        across = (np.cross(centroid, normal) * axis).sum(axis=1)
        return bool((np.abs(across) * size < SYMMETRY).all())

    def holds(
        self, motion: Array, shift: Array = NO_SHIFT, mass_slack: float = 0.0
    ) -> bool:
        """Whether a motion, then a shift, carry surface and inertia into themselves.

        `mass_slack`: most that the shift may be, radii.
        """
        slack = SYMMETRY + mass_slack
        if (
            self.effort > MOST_EFFORT
            or (shift * shift).sum() > slack * slack
            or not is_kept(self.inertia, motion, SYMMETRY + INERTIA_SLACK * mass_slack)
        ):
            return False
        motion = np.ascontiguousarray(motion)
        probes = np.array(self.probes, dtype=np.int64)
        if self._first_stray(motion, shift, probes, self.tolerance) >= 0:
            return False
        stray = self._first_stray(motion, shift, self.solid, self.tolerance)
        if stray >= 0:
            self.probes = [stray, *self.probes][: 2 * PROBES]
        return stray < 0

    def is_near(self, motion: Array, reach: float) -> bool:
        """Whether a motion takes corners to places within a reach of the surface."""
        corners = np.flatnonzero(self.surface.sample < 0)
        corners = corners[:: 1 + len(corners) // MOST_CORNERS].copy()
        matrix = np.ascontiguousarray(motion)
        return self._first_stray(matrix, NO_SHIFT, corners, reach) < 0

    def _first_stray(
        self, motion: Array, shift: Array, chosen: Index, reach: float
    ) -> int:
        self.effort += OVERHEAD + len(chosen)
        return first_stray(self.surface, self._tree, motion, shift, chosen, reach)


def surface_trial(part: Part, body: ConvexBody) -> SurfaceTrial:
    """The whole surface of a part."""
    points = (part.surface_vertices - part.center_of_mass) / body.radius
    return SurfaceTrial(points, part.surface_triangles, part.inertia, _flatness(body))


def hull_trial(part: Part, body: ConvexBody) -> SurfaceTrial:
    """The convex body that is dropped, or that of the file where it was thinned.

    What thinning leaves of a free form is uneven by the height of an arc.
    """
    if body.thinned:
        body = body_of(part, 0)
    arrays = body.arrays
    first = arrays.face_start[arrays.face]
    side = np.arange(len(first))
    inner = side[(side > first) & (side + 1 < arrays.face_start[arrays.face + 1])]
    triangles = np.stack((first[inner], inner, inner + 1), axis=1)
    return SurfaceTrial(
        body.points, arrays.corner[triangles], part.inertia, _flatness(body)
    )


def _flatness(body: ConvexBody) -> float:
    """How far corners of a plane may be off it.

    Wider than for the faces that a part stands on, but a tenth of the thickness at
    most: both sides of a plate.
    """
    return min(max(SYMMETRY, body.tolerance), 100.0 * body.tolerance or COPLANAR)
