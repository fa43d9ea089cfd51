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

"""Families of bodies for fitting and judging estimators, each an endless series."""

from collections.abc import Callable
from itertools import count

import numpy as np
from numpy.random import Generator

from ros_pose_stats.base.errors import MassPropertiesError, MeshError
from ros_pose_stats.core.records import Part
from ros_pose_stats.core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_ROUND_SIDES,
)
from ros_pose_stats.core.resting.poses import RestingPoses, resting_poses

from .convex import (
    cornered,
    ellipsoids,
    fine_ellipsoids,
    lumps,
    plates,
    prisms,
    weighted,
)
from .machined import machined
from .milled import milled
from .nuts import cap_nuts, nuts, springs
from .random_polyhedra import random_polyhedron
from .rocking import ROCKING
from .slender import bars, near_cubes, sheets
from .solids import Solid, assembled
from .turned import flat_balls, gears, hollow, rounds, stepped

Maker = Callable[[Generator], list[Solid]]

_TOO_FLAT = 0.005
"""Bodies thinner than this, in radii, are drawn anew."""


MADE: dict[str, Maker] = {
    "prisms": prisms,
    "near-cubes": near_cubes,
    "plates": plates,
    "sheets": sheets,
    "bars": bars,
    "machined": machined,
    "milled": milled,
    "rounds": rounds,
    "stepped": stepped,
    "hollow": hollow,
    "gears": gears,
    "nuts": nuts,
    "cap nuts": cap_nuts,
    "springs": springs,
    "flat balls": flat_balls,
    "cornered": cornered,
    "weighted": weighted,
    "lumps": lumps,
    "ellipsoids": ellipsoids,
    "fine ellipsoids": fine_ellipsoids,
}
DRAWN: dict[str, tuple[float, str]] = {
    "polyhedra 0": (0.0, "inertia"),
    "polyhedra 0.25": (0.25, "inertia"),
    "polyhedra 0.65 second": (0.65, "second"),
    "polyhedra 1": (1.0, "inertia"),
}

FAMILIES: tuple[str, ...] = (*DRAWN, *MADE)


def family_part(family: str, seed: int, number: int) -> Part:
    """Make one body of a family, about its centre of mass and in metres.

    Equal arguments give the same body.

    Parameters
    ----------
    family : str
        Out of `FAMILIES`, or of `ROCKING`, which no fit of `split` sees.
    seed : int
        Of the series, 0 to 2^63.
    number : int
        Place in the series, from 0.
    """
    if family in DRAWN:
        return random_polyhedron(seed, number, *DRAWN[family]).part()
    for attempt in count():
        draw = np.random.Generator(
            np.random.Philox(
                np.random.SeedSequence((seed, number, attempt, *family.encode()))
            )
        )
        try:
            part = assembled((MADE | ROCKING)[family](draw))
            resting = family_poses(family, part)
        except (MeshError, MassPropertiesError):
            continue
        if (
            len(resting.poses) > 1
            and float(resting.equilibria.heights.min()) > _TOO_FLAT
        ):
            return part
    raise AssertionError


def family_options(family: str) -> tuple[float, int]:
    """Cluster tolerance and sides a turn of round surfaces of a family.

    Random polyhedra are taken as in the paper, all others as parts arrive.
    """
    return (
        (0.0, 0)
        if family in DRAWN
        else (DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES)
    )


def family_poses(family: str, part: Part) -> RestingPoses:
    """The poses of a body of a family."""
    return resting_poses(part, *family_options(family))
