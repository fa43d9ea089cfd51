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

"""Rotations and reflections that may carry a body into itself, from its planes.

A symmetry takes two planes to two like ones that lean to each other alike, and two
planes tell a rotation and a reflection.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import (
    Array,
    Array1,
    Array2,
    Fixed2,
    Fixed3,
    Flags,
    Index,
    Index1,
)
from ..compilation import entry_kernel, inlined, kernel
from ..principal_axes import keeps_tensor
from ..sorting import falling_order
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    inverse_of,
    length,
    point_at,
    scale,
    subtract,
    transform,
    write_row,
    write_vector,
)

LARGEST = 32
"""Planes, the largest, of which two are followed."""

SAME_PLACE = 5e-3
"""Of like planes: differences of distances (radii), cosines, and areas (a share)."""

UPRIGHT_COSINE = 0.9
"""Cosine of the angle of two planes from which on both do not tell a motion."""

SAME_NORMAL = 1e-8
"""One less the cosine of the angle of planes that a motion puts on each other: 1e-4."""

FREE = 1e-6
"""Share of the weights that holds a fit where no plane does."""


class Planes(NamedTuple):
    """Planes of a hull, the largest first."""

    normal: Array2  # (G, 3)
    distance: Array1  # (G,) from the centre of mass, radii
    area: Array1  # (G,)


@entry_kernel
def candidate_motions(planes: Planes, most_like: int) -> Array:
    """Motions (C, 3, 3) that take two planes of a hull to two like ones.

    The first is one of the largest that few are like. Of the others across it two are
    taken, one by one: another such, and one of those that make most of the surface, for
    uneven facets of a curve may be like nothing else.
    """
    normal = planes.normal
    count = normal.shape[0]
    is_across = np.ones(count, np.bool_)
    first = _rarest(planes, is_across, False)
    images = _like_planes(planes, first, most_like)
    for g in range(count):
        cosine = dot(point_at(normal, g), point_at(normal, first))
        is_across[g] = abs(cosine) < UPRIGHT_COSINE
    if not is_across.any():
        return np.empty((0, 3, 3))
    rarest = _rarest(planes, is_across, False)
    broadest = _rarest(planes, is_across, True)
    motions = _motions_by(planes, first, images, rarest, 4 * most_like)
    if broadest == rarest:
        return motions
    others = _motions_by(planes, first, images, broadest, 4 * most_like)
    return np.concatenate((motions, others))


@kernel
def _motions_by(
    planes: Planes, first: int, images: Index, second: int, most_like: int
) -> Array:
    """Motions (C, 3, 3) that take two planes to some images and to like planes."""
    normal = planes.normal
    likes = _like_planes(planes, second, most_like)
    cosine = dot(point_at(normal, first), point_at(normal, second))
    pairs = 0
    for b in images:
        for c in likes:
            pairs += _leans_alike(normal, b, c, cosine)
    frame = _frame_of(point_at(normal, first), point_at(normal, second), 1.0)
    motions = np.empty((2 * pairs, 3, 3))
    size = 0
    for b in images:
        for c in likes:
            if not _leans_alike(normal, b, c, cosine):
                continue
            for hand in (1.0, -1.0):
                image = _frame_of(point_at(normal, b), point_at(normal, c), hand)
                for i in range(3):
                    for j in range(3):
                        motions[size, i, j] = (
                            image[0, i] * frame[0, j]
                            + image[1, i] * frame[1, j]
                            + image[2, i] * frame[2, j]
                        )
                size += 1
    return motions


@inlined
def _leans_alike(normal: Array, first: int, second: int, cosine: float) -> bool:
    """Whether two planes lean to each other at an angle of this cosine."""
    product = dot(point_at(normal, first), point_at(normal, second))
    return abs(product - cosine) <= SAME_PLACE


class PosePlaces(NamedTuple):
    """Poses of a part, and the faces on which it rests in them."""

    down: Array2  # (P, 3) of the lowest face of each
    height: Array1  # (P,) of it, radii
    reach: Array1  # (P,) most by which a motion may miss a face of it, 1 - cosine
    support: Array2  # (S, 3) directions of all faces
    pose: Index1  # (S,) theirs


@entry_kernel
def exchanging_motions(
    motions: Fixed3, inertia: Fixed2, places: PosePlaces, tolerance: float
) -> tuple[Array, Index]:
    """Those of the motions (C, 3, 3) that keep the inertia and exchange poses as high.

    Returns
    -------
    motions : (K, 3, 3) float
    images : (K, P) int
        Poses to which they take the poses.
    """
    poses = places.height.shape[0]
    chosen = np.zeros(motions.shape[0], np.bool_)
    image = np.empty(poses, np.int64)
    for k in range(motions.shape[0]):
        chosen[k] = keeps_tensor(motions[k], inertia, tolerance) and _exchanges_poses(
            motions[k], places, tolerance, image
        )
    # Of many candidates few are left, so that their images alone are kept.
    exchanging = motions[chosen]
    images = np.empty((exchanging.shape[0], poses), np.int64)
    for k in range(exchanging.shape[0]):
        _exchanges_poses(exchanging[k], places, tolerance, images[k])
    return exchanging, images


@kernel
def _exchanges_poses(
    motion: Array, places: PosePlaces, tolerance: float, image: Index
) -> bool:
    """Whether a motion exchanges poses as high; `image` (P,): which, set in place."""
    is_taken = np.zeros(image.shape[0], np.bool_)
    for p in range(image.shape[0]):
        turned = transform(motion, point_at(places.down, p))
        nearest = 0
        cosine = -math.inf
        for s in range(places.support.shape[0]):
            product = dot(turned, point_at(places.support, s))
            if product > cosine:
                cosine = product
                nearest = s
        q = places.pose[nearest]
        if (
            is_taken[q]
            or abs(places.height[q] - places.height[p]) > tolerance
            or 1.0 - cosine > places.reach[q]
        ):
            return False
        is_taken[q] = True
        image[p] = q
    return True


@kernel
def _difference(planes: Planes, a: int, b: int) -> float:
    """How far two planes are from being alike, or more than `SAME_PLACE`.

    -1 for one and the same.
    """
    if a == b:
        return -1.0
    rise = abs(planes.distance[a] - planes.distance[b])
    if rise > SAME_PLACE:  # of most pairs, which need no division
        return rise
    return rise + abs(planes.area[a] / planes.area[b] - 1.0)


@kernel
def _rarest(planes: Planes, chosen: Flags, is_broad: bool) -> int:
    """Of the largest chosen planes the one that fewest are like.

    `is_broad`: the one that has the greatest area with those that are like it.
    """
    best = -1
    most = -math.inf
    looked_at = 0
    for g in range(planes.area.shape[0]):
        if not chosen[g]:
            continue
        looked_at += 1
        if looked_at > LARGEST:
            break
        alike = 0
        for h in range(planes.area.shape[0]):
            if _difference(planes, g, h) <= SAME_PLACE:
                alike += 1
        value = alike * planes.area[g] if is_broad else -float(alike)
        if value > most:
            most = value
            best = g
    return best


@kernel
def _like_planes(planes: Planes, plane: int, most: int) -> Index:
    """A plane and those that are like it, the likest first."""
    count = planes.area.shape[0]
    likeness = np.zeros(count)
    alike = 0
    for g in range(count):
        difference = _difference(planes, plane, g)
        if difference <= SAME_PLACE:
            likeness[g] = 1.0 + SAME_PLACE - difference
            alike += 1
    return falling_order(likeness)[: min(alike, most)]


@kernel
def _frame_of(first: Vec3, second: Vec3, hand: float) -> Array:
    """Axes (3, 3) as rows from the normals of two planes, right-handed or not."""
    third = cross(first, second)
    third = divide(third, length(third))
    frame = np.empty((3, 3))
    write_row(frame, 0, 0, first)
    write_row(frame, 1, 0, cross(third, first))
    write_row(frame, 2, 0, scale(third, hand))
    return frame


@entry_kernel
def fit_motion(planes: Planes, motion: Fixed2) -> tuple[Array, Array]:
    """The motion (3, 3) and shift (3,) nearby that put the largest planes on others.

    By least squares over all that have an image: rounded corners turn a plane.
    """
    normal = planes.normal
    count = normal.shape[0]
    turns = np.zeros((3, 3))
    shifts = np.zeros((3, 3))
    turn_sum = Vec3(0.0, 0.0, 0.0)
    rise_sum = Vec3(0.0, 0.0, 0.0)
    total = 0.0
    for g in range(min(LARGEST, count)):
        turned = transform(motion, point_at(normal, g))
        image = 0
        cosine = -1.0
        for h in range(count):
            product = dot(turned, point_at(normal, h))
            if product > cosine:
                cosine = product
                image = h
        rise = planes.distance[image] - planes.distance[g]
        if cosine <= 1.0 - SAME_NORMAL or abs(rise) >= SAME_PLACE:
            continue
        weight = planes.area[g]
        total += weight
        place = point_at(normal, image)
        turn_sum = add(turn_sum, scale(cross(turned, place), weight))
        rise_sum = add(rise_sum, scale(place, weight * rise))
        for i in range(3):
            turns[i, i] += weight
            for j in range(3):
                turns[i, j] -= weight * normal[image, i] * normal[image, j]
                shifts[i, j] += weight * normal[image, i] * normal[image, j]
    shift = np.zeros(3)
    if total == 0.0:
        return motion.copy(), shift
    for i in range(3):
        turns[i, i] += FREE * total
        shifts[i, i] += FREE * total
    write_vector(shift, 0, transform(inverse_of(shifts), rise_sum))
    turn = transform(inverse_of(turns), turn_sum)
    # The small turn follows the motion; its columns are made square to each other.
    columns = motion.T.copy()
    for i in range(3):
        column = point_at(columns, i)
        column = add(column, cross(turn, column))
        for j in range(i):
            other = point_at(columns, j)
            column = subtract(column, scale(other, dot(column, other)))
        write_row(columns, i, 0, divide(column, length(column)))
    return columns.T.copy(), shift
