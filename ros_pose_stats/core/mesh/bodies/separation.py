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

"""Which bodies of a mesh are one part, and which are parts of their own.

A body is what hangs together in the welded mesh. Bodies whose convex hulls meet or
nearly meet are one rigid part, as a bearing or a screw with its washer is: joined, they
have one hull, which may meet further ones. What stands apart at last are several parts,
as a slicer sets them on a plate.
"""

from collections.abc import Iterator
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.linalg import LinAlgError

from ....base import errors
from ...kernels.mesh.connections import component_labels
from ...records import Array, Index, Mask
from ...records.notes import Note, note
from .. import arrays, hull, vectors
from . import copies, overlap

Choice: TypeAlias = int | Literal["all"] | None
"""Number of a body, `all` for one rigid part, or None for what the mesh suggests."""

BY_SHAPE = -1
ALL = -2
"""How messages and records write the choices that are no number."""

NEAR = 0.02
"""Gap between hulls, in radii of the whole, up to which bodies are one part: pins are
drawn a hair off their housing, and slicers leave some millimetres between parts."""

MOST_BODIES = 4096
"""Bodies beyond which a mesh is one part: debris of a scan, which nobody feeds."""

_MOST_STEPS = 100  # towards the nearest points of two hulls; ten are usual

_SAME_VOLUME = 1e-3
"""Copies of a body have hulls whose volumes differ by less; the file's order numbers
them then."""

_MOST_NAMED = 8  # bodies whose sizes a refusal names


class ChosenBody(NamedTuple):
    """A body that is the part, out of several that stand apart."""

    in_body: Mask  # (V,); which vertices of the welded mesh are its own
    bodies: int
    notes: tuple[Note, ...]


def check_choice(body: object) -> Choice:
    """Check which body is asked for; raises RequestError."""
    if body is None:
        return None
    if isinstance(body, str) and body == "all":
        return "all"
    number = -1.0 if isinstance(body, str) else arrays.number_or_nan(body)
    if not (number >= 0.0 and number.is_integer()):
        raise errors.RequestError(
            "the number of a body, 0 or more, or `all`",
            f"{body!r}",
            "leave it out for a mesh of one part",
        )
    return int(number)


def choice_of_number(number: int) -> Choice:
    """The choice that a message means; raises RequestError."""
    if number == BY_SHAPE:
        return None
    return "all" if number == ALL else check_choice(number)


def number_of_choice(choice: Choice) -> int:
    """The choice as a message has it."""
    if choice is None:
        return BY_SHAPE
    return ALL if choice == "all" else choice


def choose_body(vertices: Array, triangles: Index, choice: Choice) -> ChosenBody | None:
    """The body of a welded mesh that is the part; None where the whole mesh is.

    Raises MeshError where nothing says which of different bodies is meant.
    """
    if choice == "all" or len(triangles) == 0:
        return None
    body = _bodies_apart(vertices, triangles)
    count = int(body.max()) + 1
    if count == 1 and not choice:
        return None
    order = _by_falling_size(_split(vertices, body))
    bodies = [vertices[body == number] for number in order]
    if choice is not None and choice >= count:
        raise errors.MeshError(
            f"a body from 0 to {count - 1}",
            f"{choice} where the mesh has {_sizes_in_words(bodies)}",
            "the largest is 0",
        )
    notes: tuple[Note, ...] = ()
    if choice is None:
        if not all(copies.is_copy(bodies[0], points) for points in bodies[1:]):
            raise errors.MeshError(
                "a mesh of one part, or of equal ones",
                f"{count} that stand apart and differ: {_sizes_in_words(bodies)}",
                "choose one with --body N of commands about one part (`body` in "
                "library and messages), take all as one rigid part with --body all, "
                "or export each by itself",
            )
        notes = (
            note(
                "BODIES_APART",
                f"the mesh has {count} equal bodies that stand apart; one of them is "
                "the part.",
            ),
        )
    return ChosenBody(body == order[choice or 0], count, notes)


def _bodies_apart(vertices: Array, triangles: Index) -> Index:
    """Number of the body of each vertex (V,); those that are one part have one."""
    sides = np.concatenate((triangles[:, :2], triangles[:, 1:]))
    body = component_labels(len(vertices), sides)
    if body.max() == 0:
        return body
    if vectors.surface_area(vertices, triangles) == 0.0:
        return np.zeros_like(body)  # to be refused as what it is
    scaled = _in_radii(vertices, triangles)
    body = _join_neighbours(scaled, body)
    is_new: Mask = np.ones(int(body.max()) + 1, dtype=bool)
    while is_new.any() and 1 < len(is_new) <= MOST_BODIES:
        joints = list(_near_hulls(_split(scaled, body), is_new))
        joined = component_labels(
            len(is_new), np.array(joints, dtype=np.int64).reshape(-1, 2)
        )
        is_new = np.bincount(joined) > 1
        body = joined[body]
    return body if len(is_new) <= MOST_BODIES else np.zeros_like(body)


def _in_radii(vertices: Array, triangles: Index) -> Array:
    """Points about the middle of the surface, in radii.

    Neither the turn of the mesh nor its division moves that middle.
    """
    points = vectors.to_unit_size(vertices).points
    area = vectors.lengths(vectors.area_vectors(points, triangles))
    middles = points[triangles].sum(axis=1) / 3.0
    points = points - (area[:, None] * middles).sum(axis=0) / area.sum()
    return np.asarray(points / vectors.lengths(points).max())


def _join_neighbours(points: Array, body: Index) -> Index:
    """Join bodies that have points in one cell of a grid, no farther apart than `NEAR`.

    Meshes in hundreds of loose patches are one thing after this, in no time.
    """
    cell = np.floor((points + 1.0) / (NEAR / 2.0)).astype(np.int64)
    cells = np.int64(np.ceil(4.0 / NEAR) + 1.0)
    key = (cell[:, 0] * cells + cell[:, 1]) * cells + cell[:, 2]
    order = np.argsort(key, kind="stable")
    is_shared = key[order[1:]] == key[order[:-1]]
    neighbours = body[np.stack((order[1:], order[:-1]), axis=1)[is_shared]]
    return component_labels(int(body.max()) + 1, neighbours)[body]


def _split(points: Array, body: Index) -> list[Array]:
    """The points of each body."""
    order = np.argsort(body, kind="stable")
    ends = np.cumsum(np.bincount(body))
    return np.split(points[order], ends[:-1])


def _near_hulls(bodies: list[Array], is_new: Mask) -> Iterator[tuple[int, int]]:
    """Pairs of bodies, one of them new, whose hulls are within `NEAR`, as joints.

    Pairs that other joints join already are left out.
    """
    low = np.array([points.min(axis=0) for points in bodies]) - NEAR
    high = np.array([points.max(axis=0) for points in bodies])
    owner = np.arange(len(bodies))
    for first in range(len(bodies)):
        overlap.check_patience()
        boxes_meet = (low[first + 1 :] <= high[first]) & (
            low[first] <= high[first + 1 :]
        )
        candidates = first + 1 + np.flatnonzero(boxes_meet.all(axis=1))
        for second in candidates[is_new[candidates] | is_new[first]].tolist():
            if owner[first] == owner[second]:
                continue
            if hulls_are_near(bodies[first], bodies[second]):
                owner[owner == owner[second]] = owner[first]
                yield first, second


def hulls_are_near(first: Array, second: Array) -> bool:
    """Whether the convex hulls of points in radii are within `NEAR` of each other.

    The point of least length in the hull of all differences, by Wolfe's method
    (Finding the nearest point in a polytope, 1976), until a plane parts both or the
    way is short enough.
    """
    simplex: Array = (second[0] - first[0])[None]
    weights: Array = np.ones(1)
    for _ in range(_MOST_STEPS):
        way = (weights[:, None] * simplex).sum(axis=0)
        length = vectors.length(way)
        if length <= NEAR:
            return True
        along_first = vectors.components_along(first, way)
        along_second = vectors.components_along(second, way)
        if along_second.min() - along_first.max() > NEAR * length:
            return False
        corner = second[along_second.argmin()] - first[along_first.argmax()]
        simplex = np.concatenate((simplex, corner[None]))
        weights = np.append(weights, 0.0)
        try:
            simplex, weights = _nearest_in_simplex(simplex, weights)
        except LinAlgError:  # no nearer corner: rounding is all that is left
            return False
    return False


def _nearest_in_simplex(simplex: Array, weights: Array) -> tuple[Array, Array]:
    """Corners (k, 3) of the face nearest to the origin, and weights of that point."""
    while True:
        products = (simplex[:, None] * simplex).sum(axis=2)
        affine = np.linalg.solve(products + 1.0, np.ones(len(simplex)))
        affine /= affine.sum()
        is_outside = affine <= 0.0
        if not is_outside.any():
            return simplex, affine
        steps = weights[is_outside] / (weights[is_outside] - affine[is_outside])
        weights = weights + steps.min() * (affine - weights)
        is_kept = weights > 1e-12
        is_kept[np.flatnonzero(is_outside)[steps.argmin()]] = False
        simplex = simplex[is_kept]
        weights = weights[is_kept] / weights[is_kept].sum()


def _by_falling_size(bodies: list[Array]) -> list[int]:
    """Numbers of bodies by the volumes of their hulls; of copies the file's order."""
    volumes = np.array([_hull_volume(points) for points in bodies])
    order = np.argsort(-volumes, kind="stable").tolist()
    tie: list[int] = []
    sorted_order: list[int] = []
    for number in order:
        if tie and volumes[number] < volumes[tie[0]] * (1.0 - _SAME_VOLUME):
            sorted_order += sorted(tie)
            tie = []
        tie.append(number)
    return sorted_order + sorted(tie)


def _hull_volume(points: Array) -> float:
    """Volume of the convex hull; 0 of points in a plane."""
    try:
        scaled = vectors.to_unit_size(points)
        return hull.hull_of(scaled).qhull.volume * scaled.size**3
    except errors.MeshError:
        return 0.0


def _sizes_in_words(bodies: list[Array]) -> str:
    """Numbers of bodies and the sizes of the boxes around them."""
    sizes = [
        f"{number}: " + " x ".join(f"{1e3 * x:.4g}" for x in np.ptp(points, axis=0))
        for number, points in enumerate(bodies[:_MOST_NAMED])
    ]
    return ", ".join(sizes) + (" mm" if len(bodies) <= _MOST_NAMED else " mm, …")
