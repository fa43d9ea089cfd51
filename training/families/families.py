"""Families of bodies for fitting and judging estimators, each an endless series."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

import numpy as np
from numpy.random import Generator

from ros_pose_stats.errors import MassPropertiesError, MeshError
from ros_pose_stats.records import Part
from ros_pose_stats.records.scene import DEFAULT_CLUSTER_TOLERANCE
from ros_pose_stats.resting.poses import resting_poses
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron

from .machined import machined
from .makers import (
    cornered,
    ellipsoids,
    fine_ellipsoids,
    fine_rounds,
    lumps,
    plates,
    prisms,
    rounds,
    weighted,
)
from .solids import Solid, assembled

Maker = Callable[[Generator], list[Solid]]

_TOO_FLAT = 0.02
"""Bodies thinner than this, in radii, are drawn anew."""


MADE: dict[str, Maker] = {"prisms": prisms, "plates": plates, "ellipsoids": ellipsoids,
                          "machined": machined, "rounds": rounds, "cornered": cornered,
                          "weighted": weighted, "fine rounds": fine_rounds, "lumps": lumps,
                          "fine ellipsoids": fine_ellipsoids}
DRAWN: dict[str, tuple[float, str]] = {
    "polyhedra 0": (0.0, "inertia"), "polyhedra 0.25": (0.25, "inertia"),
    "polyhedra 0.65 second": (0.65, "second"), "polyhedra 1": (1.0, "inertia")}

FAMILIES: tuple[str, ...] = (*DRAWN, *MADE)


def family_part(family: str, seed: int, number: int) -> Part:
    """Make one body of a family, about its centre of mass and in metres.

    Equal arguments give the same body.

    Parameters
    ----------
    family : str
        Out of `FAMILIES`.
    seed : int
        Of the series, 0 to 2^63.
    number : int
        Place in the series, from 0.
    """
    if family in DRAWN:
        return random_polyhedron(seed, number, *DRAWN[family]).part()
    for attempt in count():
        draw = np.random.Generator(np.random.Philox(np.random.SeedSequence(
            (seed, number, attempt, *family.encode()))))
        try:
            part = assembled(MADE[family](draw))
            found = resting_poses(part, family_tolerance(family), round_sides=0)
        except (MeshError, MassPropertiesError):
            continue
        if len(found.poses) > 1 and float(found.equilibria.heights.min()) > _TOO_FLAT:
            return part
    raise AssertionError


def family_tolerance(family: str) -> float:
    """Cluster tolerance at which a family's poses are counted."""
    return 0.0 if family in DRAWN else DEFAULT_CLUSTER_TOLERANCE
