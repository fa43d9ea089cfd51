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

"""The same body given in another way must get the same answer, unless rounding decides
it.

As it is given, without round sides: those are laid by the file's own corners.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from lab.bodies.degenerate import Random, power, rotation, split, with_pocket
from lab.bodies.shapes import Surface
from lab.bodies.variants import shuffled, subdivided
from ros_pose_stats import (
    Part,
    PoseStatistics,
    estimate_all,
    part_from_mesh,
    resting_poses,
)
from ros_pose_stats.core.records import Array

from .judge import MARGINAL, marginal, roughness

FINE = 1e-9
"""By how much answers may differ on a body as thick as long, per unit."""

BY_SPLIT = 1e-5
"""By how much those of `split` may, which takes saddles that tie in the order that
rounding gives them: a known fault, see `tests/contract/library/test_door.py`.
"""

WELD = 1e-8
"""Vertices this close, as a fraction of the extent, count as one."""


class Change(NamedTuple):
    """One way to give a body: the mesh, its rotation and its length of one metre."""

    name: str
    part: Part
    turn: Array
    scale: float


def changes(part: Part, random: Random) -> Iterator[Change]:
    """The same body turned, in other units, renumbered, cut finer, doubled and
    hollowed.
    """
    surface: Surface = (part.surface_vertices, part.surface_triangles)
    vertices, triangles = surface
    turn = rotation(random)
    identity = np.eye(3)
    scale = power(random, -9.0, 9.0)
    mass_properties = {
        "center_of_mass": part.center_of_mass,
        "mass": part.mass,
        "inertia": part.inertia,
    }
    yield Change(
        "turned",
        part_from_mesh(
            vertices @ turn.T,
            triangles,
            turn @ part.center_of_mass,
            part.mass,
            turn @ part.inertia @ turn.T,
            body="all",
        ),
        turn,
        1.0,
    )
    yield Change(
        "in other units",
        part_from_mesh(
            vertices * scale,
            triangles,
            scale * part.center_of_mass,
            part.mass,
            scale * scale * part.inertia,
            body="all",
        ),
        identity,
        scale,
    )
    meshes = {
        "renumbered": shuffled(surface, random),
        "cut finer": subdivided(surface),
        "with doubled vertices": shuffled(split(surface), random),
        "with points inside": with_pocket(surface, part.center_of_mass, 0.3),
    }
    for name, mesh in meshes.items():
        same_part = part_from_mesh(*mesh, **mass_properties, body="all")
        yield Change(name, same_part, identity, 1.0)


def bend(body: Any) -> float:
    """How far the flattest of all neighbours are from being coplanar, in radii.

    For each side the third of the neighbour's corners, by distance from this face's
    plane: two are the side's own.
    """
    arrays = body.arrays
    smallest = np.inf
    for side, twin in enumerate(arrays.twin.tolist()):
        face = arrays.face[side]
        distances = (
            body.polygon(int(arrays.face[twin])) @ arrays.normal[face]
            - arrays.distance[face]
        )
        smallest = min(smallest, float(np.sort(np.abs(distances))[2]))
    return smallest


def undecided(part: Part) -> str:
    """Why rounding may decide what the poses are; empty where it cannot.

    A foot within a thousand times of what counts as on a side, or triangles that are
    merged, or not, with less than a factor of five between their bend and the
    tolerance; vertices so close that a corner and the middle of an edge would be
    welded.
    """
    equilibria = resting_poses(part, 0.0, 0).equilibria
    body = equilibria.body
    vertices = part.surface_vertices
    if marginal(equilibria) < 100.0 * MARGINAL:
        return "marginal"
    if roughness(body) > 0.2 * body.tolerance or bend(body) < 5.0 * body.tolerance:
        return "nearly coplanar"
    gap = cKDTree(vertices).query(vertices, k=2)[0][:, 1].min()
    return (
        "nearly coincident" if gap < 4.0 * WELD * np.ptp(vertices, axis=0).max() else ""
    )


def allowed(part: Part) -> float:
    """By how much two answers on the same body may differ.

    Rounding turns a face of a thin body by its inverse thickness, and moves the foot of
    the centre of mass there by as much again. The solid angle of a component that falls
    apart is a difference of solid angles of up to 4 pi: rounding counts for more the
    smaller it is.
    """
    resting = resting_poses(part, 0.0, 0)
    points = resting.body.points
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    splits = resting.clusters.split
    smallest = min(
        passage[0][splits].sum(axis=1).min(initial=np.inf)
        for passage in (resting.passage_r, resting.passage_R)
    )
    return min(
        1.0, FINE + 1e-14 * float(spread[0] / spread[2]) ** 2 + 1e-14 / float(smallest)
    )


def differences(part: Part, random: Random) -> Iterator[str]:
    """What differs, under which change."""
    within = allowed(part)
    answers = estimate_all(part, cluster_tolerance=0.0, round_sides=0)
    for change in changes(part, random):
        changed_answers = estimate_all(
            change.part, cluster_tolerance=0.0, round_sides=0
        )
        for answer, changed_answer in zip(answers, changed_answers, strict=True):
            minimum = BY_SPLIT if answer.method == "split" else 0.0
            fault = difference(answer, changed_answer, change, max(within, minimum))
            if fault:
                yield f"{change.name}: {answer.method}: {fault}"
                break


def difference(
    answer: PoseStatistics,
    changed_answer: PoseStatistics,
    change: Change,
    within: float,
) -> str:
    """The first quantity in which two answers differ; empty where they agree."""
    if len(answer.poses) != len(changed_answer.poses):
        return f"{len(answer.poses)} poses became {len(changed_answer.poses)}"
    expected = np.array([pose.down for pose in answer.poses]) @ change.turn.T
    gap, partner = cKDTree(
        np.array([pose.down for pose in changed_answer.poses])
    ).query(expected)
    if gap.max() > 1e-5 or len(np.unique(partner)) != len(partner):
        return f"a pose turned by {gap.max():.1e}"
    length = change.scale * answer.radius
    for name, unit in (
        ("probability", 1.0),
        ("margin", 1.0),
        ("height", length),
        ("top", length),
        ("barrier", length),
    ):
        values = np.array([getattr(pose, name) for pose in answer.poses])
        changed_values = np.array(
            [getattr(changed_answer.poses[k], name) for k in partner]
        )
        if name in ("height", "top", "barrier"):
            values = values * change.scale
        distance = np.where(
            values == changed_values, 0.0, np.abs(values - changed_values) / unit
        ).max()
        if not distance <= within:
            return f"{name} differs by {distance:.1e}, allowed {within:.1e}"
    return ""
