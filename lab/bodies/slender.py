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

"""Random bars, sheets and near-cubes.

Lengths are in units of the part; only their ratios matter.
"""

import math

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.records import Array

from .solids import Solid, around, block, cube, extruded, tapered
from .turned import disc


def bars(draw: Generator) -> list[Solid]:
    """Bars 3 to 20 times as long as wide: polygons, rectangles, rods, tubes, L and U
    profiles.
    """
    length = math.exp(draw.uniform(math.log(3.0), math.log(20.0)))
    kind = draw.random()
    if kind < 0.25:
        sides = int(draw.integers(24, 97))
        rod = disc(sides, 0.5, 0.0, length, float(draw.choice([0.0, 0.02, 0.1])))
        if draw.random() < 0.5:
            return [rod]
        hole = disc(
            sides,
            float(draw.uniform(0.15, 0.42)),
            0.0,
            length * float(draw.choice([1.0, 0.6])),
        ).hole()
        return [rod, hole]
    if kind < 0.55:
        wide = 1.0
        thick = math.exp(draw.uniform(math.log(0.15), 0.0))
        return [_tapered(_rectangle(wide, thick), length, draw)]
    if kind < 0.8:
        corners = int(draw.choice([3, 5, 6, 6, 8]))
        outline = around(corners, 0.15 * float(draw.random() < 0.5), draw) * 0.5
        return [_tapered(outline, length, draw)]
    wall = float(draw.uniform(0.08, 0.25))
    leg = float(draw.uniform(0.4, 1.2))
    solids = [
        block((0.0, 0.0, 0.0), (1.0, wall, length)),
        block((0.0, wall, 0.0), (wall, leg, length)),
    ]
    if draw.random() < 0.5:
        solids.append(block((1.0 - wall, wall, 0.0), (1.0, leg, length)))
    return solids


def sheets(draw: Generator) -> list[Solid]:
    """Thin plates, 0.01 to 0.06 of their width: flat, bevelled, drilled off centre, or
    bent.
    """
    thick = 2.0 * math.exp(draw.uniform(math.log(0.01), math.log(0.06)))
    width = float(draw.uniform(0.4, 1.0))
    kind = draw.random()
    if kind < 0.3:
        outline = around(int(draw.integers(3, 9)), 0.35, draw) * (1.0, width)
        bevel = float(draw.choice([1.0, 0.98, 0.9]))
        return [tapered(outline, ((1.0, 0.0), (bevel, thick)))]
    if kind < 0.5:
        rim = disc(
            int(draw.integers(32, 129)),
            1.0,
            0.0,
            thick,
            float(draw.choice([0.0, 0.2])) * thick,
        )
        away = float(draw.uniform(0.0, 0.4))
        hole = disc(48, float(draw.uniform(0.1, 0.5)), 0.0, thick)
        return [rim, Solid(hole.corners + np.array((away, 0.0, 0.0)), -1.0)]
    plate = block((-1.0, -width, 0.0), (1.0, width, thick))
    rise = math.exp(draw.uniform(math.log(0.05), math.log(1.0)))
    solids = [plate, block((-1.0, -width, thick), (-1.0 + thick, width, thick + rise))]
    if draw.random() < 0.4:
        second_rise = rise * float(draw.choice([1.0, draw.uniform(0.2, 1.0)]))
        solids.append(
            block((1.0 - thick, -width, thick), (1.0, width, thick + second_rise))
        )
    return solids


def near_cubes(draw: Generator) -> list[Solid]:
    """Boxes whose sides differ by up to 15 per cent; some are chamfered, some have a
    weight.
    """
    half = np.exp(draw.uniform(0.01, 0.15) * draw.uniform(-1.0, 1.0, 3))
    if draw.random() < 0.4:
        half[1] = half[0]
    signs = np.array(
        [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    )
    chamfer = float(draw.choice([0.0, 0.0, 0.03, 0.1, 0.2]))
    corners = np.vstack(
        [signs * (half - chamfer * (1.0 - np.eye(3)[axis])) for axis in range(3)]
    )
    solids = [Solid(corners)]
    if draw.random() < 0.3:
        half = 0.05
        center = draw.uniform(-0.5, 0.5, 3)
        mass = float(draw.uniform(0.1, 2.0))
        solids.append(cube(center, half, mass / (2.0 * half) ** 3))
    return solids


def _rectangle(wide: float, thick: float) -> Array:
    return 0.5 * np.array(
        [(-wide, -thick), (wide, -thick), (wide, thick), (-wide, thick)]
    )


def _tapered(outline: Array, length: float, draw: Generator) -> Solid:
    """With ends as they are, chamfered, or one end narrower."""
    kind = draw.random()
    if kind < 0.5:
        return extruded(outline, 0.0, length)
    if kind < 0.75:
        narrow = 0.8
        inset = 0.1
        levels = [(narrow, 0.0), (1.0, inset), (1.0, length - inset), (narrow, length)]
    else:
        levels = [(1.0, 0.0), (float(draw.uniform(0.4, 0.95)), length)]
    return tapered(outline, levels)
