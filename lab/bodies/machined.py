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

"""Random parts as they are machined: brackets, shafts, bolts, bossed and drilled
plates.

Every function draws one body from a generator of random numbers. Lengths are in units
of the part; only their ratios matter.
"""

import math

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.shapes.profiles import unit_circle

from .solids import Solid, block, extruded
from .turned import disc


def machined(draw: Generator) -> list[Solid]:
    """One of the kinds of this module, each as often."""
    kinds = (bracket, shaft, bolt, bossed_plate, channel, wedge)
    return kinds[int(draw.integers(len(kinds)))](draw)


def bracket(draw: Generator) -> list[Solid]:
    """Two plates at a right angle, off the middle in one direction, with holes."""
    width, depth, rise = draw.uniform(0.5, 1.5, 3)
    thick, wall = draw.uniform(0.08, 0.3, 2)
    begin = draw.uniform(0.0, max(width - wall, 0.0)) * float(draw.random() < 0.5)
    short = draw.uniform(0.4, 1.0) if draw.random() < 0.5 else 1.0
    base = block((0.0, 0.0, 0.0), (width, depth, thick))
    upright = block((begin, 0.0, thick), (begin + wall, short * depth, thick + rise))
    return [base, upright, *_holes(draw, width, depth, 0.0, thick)]


def shaft(draw: Generator) -> list[Solid]:
    """Two to four round steps on one axis."""
    sides = int(draw.integers(16, 41))
    solids = []
    level = 0.0
    for _ in range(int(draw.integers(2, 5))):
        length = float(draw.uniform(0.15, 1.0))
        solids.append(disc(sides, float(draw.uniform(0.2, 0.7)), level, level + length))
        level += length
    return solids


def bolt(draw: Generator) -> list[Solid]:
    """A polygonal head on a shank."""
    head = float(draw.uniform(0.15, 0.6))
    shank = disc(
        int(draw.integers(16, 33)), 0.5, head, head + float(draw.uniform(0.3, 2.5))
    )
    corners = unit_circle(int(draw.choice([4, 6, 6, 8]))) * draw.uniform(0.7, 1.2)
    return [extruded(corners, 0.0, head), shank]


def bossed_plate(draw: Generator) -> list[Solid]:
    """A plate with one to three round or square bosses, and holes."""
    width = draw.uniform(0.6, 1.6)
    depth = draw.uniform(0.6, 1.6)
    thick = draw.uniform(0.08, 0.5)
    plate = block((0.0, 0.0, 0.0), (width, depth, thick))
    solids = [plate, *_holes(draw, width, depth, 0.0, thick)]
    for number in range(int(draw.integers(1, 4))):
        size = draw.uniform(0.06, 0.14) * min(width, depth)
        # A lane for each boss keeps them apart.
        x = width * (number + 0.5) / 3.0 + draw.uniform(-0.02, 0.02)
        y = draw.uniform(0.2, 0.8) * depth
        outline = unit_circle(4 if draw.random() < 0.5 else 20) * size + (x, y)
        solids.append(extruded(outline, thick, thick + float(draw.uniform(0.1, 0.9))))
    return solids


def channel(draw: Generator) -> list[Solid]:
    """A U profile with legs of different heights, or a T where they meet."""
    length = draw.uniform(0.4, 2.0)
    width = draw.uniform(0.4, 1.2)
    floor = draw.uniform(0.06, 0.25)
    wall = draw.uniform(0.06, 0.18)
    first_leg, second_leg = draw.uniform(0.1, 1.0, 2)
    offset = (width - wall) * (1.0 if draw.random() < 0.7 else 0.5)
    legs = [
        block((0.0, 0.0, floor), (wall, length, floor + first_leg)),
        block((offset, 0.0, floor), (offset + wall, length, floor + second_leg)),
    ]
    if offset < wall:
        legs = legs[:1]
    return [block((0.0, 0.0, 0.0), (width, length, floor)), *legs]


def wedge(draw: Generator) -> list[Solid]:
    """A block with sloping sides: a convex outline of five or six corners, extruded."""
    turn = np.sort(draw.uniform(0.0, 2.0 * math.pi, int(draw.integers(4, 7))))
    outline = np.stack([np.cos(turn), np.sin(turn)], axis=1) * draw.uniform(0.4, 1.0, 2)
    return [extruded(outline, 0.0, float(draw.uniform(0.1, 1.6)))]


def _holes(
    draw: Generator, width: float, depth: float, low: float, high: float
) -> list[Solid]:
    """Up to two holes through a plate, inside its two halves."""
    radius = 0.12 * min(width, depth)
    places = [(0.25 * width, 0.5 * depth), (0.75 * width, 0.5 * depth)]
    count = int(draw.integers(0, 3))
    return [
        extruded(
            unit_circle(12) * radius * draw.uniform(0.5, 1.0) + center, low, high
        ).hole()
        for center in places[:count]
    ]
