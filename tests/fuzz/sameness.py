"""The same body given in another way must get the same answer.

As it is given, without round sides: those are laid by the file's own corners.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ros_pose_stats import Part, PoseStatistics, estimate_all, part_from_mesh, resting_poses
from ros_pose_stats.shapes import Surface

from .changes import Array, Random, rotation, shuffled, split, subdivided, with_pocket
from .closeness import smallest_split, thickness, undecided

FINE = 1e-9
"""By how much answers may differ on a body as thick as long, per unit."""


class Change(NamedTuple):
    """One way to give a body: the mesh, its rotation and its length of one metre."""

    name: str
    part: Part
    turn: Array
    scale: float


def changes(part: Part, random: Random) -> Iterator[Change]:
    """The same body turned, in other units, renumbered, cut finer, doubled and hollowed."""
    surface: Surface = (part.surface_vertices, part.surface_triangles)
    vertices, triangles = surface
    turn, same, scale = rotation(random), np.eye(3), float(10.0 ** random.uniform(-9.0, 9.0))
    kept = {"center_of_mass": part.center_of_mass, "mass": part.mass, "inertia": part.inertia}
    yield Change("turned", part_from_mesh(
        vertices @ turn.T, triangles, turn @ part.center_of_mass, part.mass,
        turn @ part.inertia @ turn.T), turn, 1.0)
    yield Change("in other units", part_from_mesh(
        vertices * scale, triangles, scale * part.center_of_mass, part.mass,
        scale * scale * part.inertia), same, scale)
    given = {"renumbered": shuffled(surface, random), "cut finer": subdivided(surface),
             "with doubled vertices": shuffled(split(surface), random),
             "with points inside": with_pocket(surface, part.center_of_mass, 0.3)}
    for name, mesh in given.items():
        yield Change(name, part_from_mesh(*mesh, **kept), same, 1.0)


def allowed(part: Part) -> float:
    """By how much two answers on the same body may differ.

    Rounding turns a face of a thin body by its inverse thickness, and moves the foot of the
    centre of mass there by as much again. Rounding of a solid angle counts for more the
    smaller the component is that falls apart.
    """
    split_by = smallest_split(resting_poses(part, 0.0, round_sides=0))
    return min(1.0, FINE + 1e-14 / thickness(part) ** 2 + 1e-14 / split_by)


def differences(part: Part, random: Random) -> Iterator[tuple[str, str]]:
    """What differs, under which change; nothing for bodies that rounding may decide about."""
    if undecided(part):
        return
    within = allowed(part)
    known = estimate_all(part, cluster_tolerance=0.0, round_sides=0)
    for change in changes(part, random):
        other = estimate_all(change.part, cluster_tolerance=0.0, round_sides=0)
        for here, there in zip(known, other, strict=True):
            fault = difference(here, there, change, within)
            if fault:
                yield change.name, f"{here.method}: {fault}"
                break


def difference(here: PoseStatistics, there: PoseStatistics, change: Change,
               within: float) -> str:
    """The first quantity in which two answers differ; empty where they agree."""
    if len(here.poses) != len(there.poses):
        return f"{len(here.poses)} poses became {len(there.poses)}"
    expected = np.array([pose.down for pose in here.poses]) @ change.turn.T
    gap, partner = cKDTree(np.array([pose.down for pose in there.poses])).query(expected)
    if gap.max() > 1e-5 or len(np.unique(partner)) != len(partner):
        return f"a pose turned by {gap.max():.1e}"
    length = change.scale * here.radius
    for name, unit in (("probability", 1.0), ("margin", 1.0), ("height", length),
                       ("top", length), ("barrier", length)):
        one = np.array([getattr(pose, name) for pose in here.poses])
        other = np.array([getattr(there.poses[k], name) for k in partner])
        if name in ("height", "top", "barrier"):
            one = one * change.scale
        far = np.where(one == other, 0.0, np.abs(one - other) / unit).max()
        if not far <= within:
            return f"{name} differs by {far:.1e}, allowed {within:.1e}"
    return ""
