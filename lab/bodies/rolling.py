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

"""Bodies that roll or rock for long, and drops of them that nothing ends early."""

from collections.abc import Callable

import numpy as np
from manifold3d import CrossSection, Manifold

from ros_pose_stats import Part, part_from_mesh
from ros_pose_stats.core.simulation.drop_body import PreparedBody

from . import gears
from .families import family_part
from .fine_parts import surface

SIDES = 96
SERIES = 4321
"""Seed of the bodies out of families."""


def cylinder(
    height: float, radius: float, above: float = 0.0, offset: float = 0.0
) -> Manifold:
    """A round disc or shaft about z, moved up and along x."""
    shaft = Manifold.cylinder(height, radius, circular_segments=SIDES)
    return shaft.translate((offset, 0.0, above))


def oval(sides: int, width: float, length: float) -> Manifold:
    """An elliptic cylinder of half axes 1 and `width`."""
    angle = np.arange(sides) * 2.0 * np.pi / sides
    outline = np.column_stack((np.cos(angle), width * np.sin(angle)))
    return Manifold.extrude(CrossSection([outline]), length)


def shaft_between(low: float, high: float, length: float) -> Manifold:
    """A shaft of radius 1 with what lies beyond two planes cut off."""
    block = Manifold.cube((3.0, high - low, length)).translate((-1.5, low, 0.0))
    return cylinder(length, 1.0) ^ block


def lens(thickness: float) -> Manifold:
    """What two balls have in common."""
    ball = Manifold.sphere(1.0, SIDES)
    lift = 1.0 - 0.5 * thickness
    return ball.translate((0.0, 0.0, lift)) ^ ball.translate((0.0, 0.0, -lift))


def part_of(solid: Manifold) -> Part:
    """A homogeneous part."""
    return part_from_mesh(*surface(solid))


ROLLING: dict[str, Callable[[], Part]] = {
    "oval": lambda: part_of(oval(96, 0.9, 1.5)),
    "short oval": lambda: part_of(oval(60, 0.7, 0.8)),
    "oval with a flat": lambda: family_part("ovals", SERIES, 0),
    "shaft, shallow flats": lambda: part_of(shaft_between(-0.95, 0.95, 1.5)),
    "shaft, wide flats": lambda: part_of(shaft_between(-0.8, 0.8, 3.0)),
    "shaft, one flat": lambda: part_of(shaft_between(-1.0, 0.8, 3.0)),
    "half cylinder": lambda: part_of(shaft_between(-1.0, 0.0, 1.2)),
    "sector": lambda: family_part("sectors", SERIES, 1),
    "disc": lambda: part_of(cylinder(0.2, 1.0)),
    "ring": lambda: part_of(cylinder(0.6, 1.0) - cylinder(1.0, 0.6, above=-0.1)),
    "lens": lambda: part_of(lens(0.5)),
    "gear": lambda: part_from_mesh(*gears.gear(24, keyway=2.0)),
    "hexagonal cap nut": lambda: family_part("cap nuts", SERIES, 3),
    "octagonal cap nut": lambda: family_part("cap nuts", SERIES, 1),
    "cut egg": lambda: family_part("cut eggs", SERIES, 0),
}
"""Parts by name."""


def run_on(body: PreparedBody) -> PreparedBody:
    """The same body, of which drops end by the way out of their pose alone."""
    arrays = body.arrays
    return body._replace(
        arrays=arrays._replace(
            corner_rim=np.full_like(arrays.corner_rim, -1), unit_way_out=arrays.way_out
        )
    )
