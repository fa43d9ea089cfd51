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

"""Walks of parts as designers send them: sides of a turn, teeth, holes, and the
nudge.
"""

import numpy as np

from lab.bodies.shapes import cylinder, ellipsoid_points, hull_mesh
from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.records import Part
from ros_pose_stats.core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_ROUND_SIDES,
)
from ros_pose_stats.core.resting.poses import resting_poses

from .walk import SIZE, Step, Walk, is_along, is_towards

GEAR_WIDTH = 0.8
"""Width of the gears over their outer radius."""

LUMP = 60, 1, (1.0, 0.8, 0.6)
"""Corners of the lump, its seed, and the semi-axes of the ellipsoid that it follows."""

BLOCK_HEIGHT = 1.1
HOLE_DEPTH = 0.9
"""Height of the block over its width, and depth of its hole over that height."""


def part_walks() -> list[Walk]:
    """The walks of this module, in the order of the page."""
    return [_turned(), _toothed(), _drilled(), _nudged()]


def _turned() -> Walk:
    sides = np.unique(np.geomspace(6.0, 512.0, 20).round())
    return Walk(
        "cylinder_sides",
        "A file cuts a cylinder, as high as wide, into more and more sides",
        "sides in the file",
        sides,
        True,
        lambda count: Step(part_from_mesh(*cylinder(round(count), SIZE, 2.0 * SIZE))),
        is_along(2),
        "both ends together",
        round_sides=DEFAULT_ROUND_SIDES,
        whole=True,
        mark=15.0,
    )


def _toothed() -> Walk:
    teeth = np.unique(np.geomspace(8.0, 120.0, 14).round())
    return Walk(
        "gear_teeth",
        "A spur gear of the same size has more and more teeth",
        "teeth",
        teeth,
        True,
        lambda count: Step(_gear(round(count))),
        is_along(2),
        "both faces together",
        round_sides=DEFAULT_ROUND_SIDES,
        whole=True,
        mark=15.0,
    )


def _drilled() -> Walk:
    return Walk(
        "hole_size",
        "A blind hole in a block grows",
        "diameter over the width of the block",
        np.linspace(0.0, 0.96, 17),
        False,
        lambda diameter: Step(_drilled_block(diameter)),
        is_towards((0.0, 0.0, -1.0), 0.3),
        "the closed end",
        round_sides=DEFAULT_ROUND_SIDES,
    )


def _nudged() -> Walk:
    lump = part_from_mesh(*hull_mesh(SIZE * ellipsoid_points(*LUMP)))
    x, y, z = resting_poses(lump, round_sides=0).poses[0].down.tolist()
    return Walk(
        "nudge",
        "The nudge that a pose of a cast lump has to survive grows",
        "cluster tolerance",
        np.geomspace(1e-5, 0.1, 17),
        True,
        lambda tolerance: Step(lump, cluster_tolerance=tolerance),
        is_towards((x, y, z), 0.1),
        "its lowest pose",
        mark=DEFAULT_CLUSTER_TOLERANCE,
    )


def _gear(teeth: int) -> Part:
    # It loads the solid modeller.
    from ros_pose_stats.core.shapes.demo_parts import extrude, surface_of
    from ros_pose_stats.core.shapes.profiles import spur_gear

    radius = 1e3 * SIZE
    outline = spur_gear(teeth, 2.0 * radius / (teeth + 2))
    return part_from_mesh(
        *surface_of(extrude(outline, "z", 0.0, GEAR_WIDTH * radius)), unit="mm"
    )


def _drilled_block(diameter: float) -> Part:
    # It loads the solid modeller.
    from ros_pose_stats.core.shapes.demo_parts import drill, extrude, surface_of

    wide = 1e3 * SIZE
    high = BLOCK_HEIGHT * wide
    half = 0.5 * wide
    block = extrude(
        np.array([(-half, -half), (half, -half), (half, half), (-half, half)]),
        "z",
        0.0,
        high,
    )
    if diameter > 0.0:
        block -= drill(
            diameter * half, "z", (0.0, 0.0), (1.0 - HOLE_DEPTH) * high, high + 1.0, 64
        )
    return part_from_mesh(*surface_of(block), unit="mm")
