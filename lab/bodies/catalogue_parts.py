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

"""Random parts as designers send them: machined, turned, drilled, toothed.

Each kind draws its proportions from a generator of random numbers. Lengths are in
millimetres, the surface is closed and outward, circles are cut into 24 to 128 sides as
files have them.
"""

import math
from collections.abc import Callable

import numpy as np
from manifold3d import Manifold
from numpy.random import Generator

from ros_pose_stats.core.shapes.demo_parts import drill, extrude, revolve, surface_of
from ros_pose_stats.core.shapes.profiles import (
    Outline,
    rounded_polygon,
    spur_gear,
    unit_circle,
)

from .shapes import Surface


def random_part(seed: int, number: int) -> Surface:
    """One part of an endless series that goes through the kinds in turn.

    Parameters
    ----------
    seed : int
        Of the series, from 0.
    number : int
        Place in the series, from 0. Equal arguments give the same part.

    Returns
    -------
    Surface
        Vertices (V, 3) in millimetres and triangles (T, 3).
    """
    make = KINDS[number % len(KINDS)]
    return surface_of(make(np.random.default_rng((seed, number))))


def shaft(draw: Generator) -> Manifold:
    """Two to five turned steps with chamfers; one in four has a flat."""
    sides = _sides(draw)
    level = 0.0
    corners = [(0.0, 0.0)]
    widest = 0.0
    for _ in range(int(draw.integers(2, 6))):
        radius = draw.uniform(3.0, 12.0)
        length = 3.0 * math.exp(draw.uniform(0.0, 2.0))
        chamfer = min(0.15 * radius, 0.2 * length) * float(draw.random() < 0.6)
        corners += [
            (radius - chamfer, level),
            (radius, level + chamfer),
            (radius, level + length),
        ]
        level = level + length
        widest = max(widest, radius)
    solid = revolve(np.array([*corners, (0.0, level)]), sides)
    if draw.random() < 0.25:
        depth = widest * draw.uniform(0.6, 0.9)
        solid -= extrude(_square(depth, 2.0 * widest, widest), "z", -1.0, level + 1.0)
    return solid


def ring(draw: Generator) -> Manifold:
    """A ring, bushing or washer, half of them with a collar; one in three is a cup."""
    sides = _sides(draw)
    height = 10.0 * math.exp(draw.uniform(math.log(0.15), math.log(3.0)))
    bore = draw.uniform(3.5, 9.0)
    collar = draw.uniform(10.0, 15.0)
    solid = revolve(
        np.array([(0.0, 0.0), (10.0, 0.0), (10.0, height), (0.0, height)]), sides
    )
    if draw.random() < 0.5:
        solid += drill(collar, "z", (0.0, 0.0), 0.0, 0.3 * height, sides)
    floor = height * draw.uniform(0.1, 0.5) if draw.random() < 0.33 else -1.0
    return solid - drill(bore, "z", (0.0, 0.0), floor, height + 1.0, sides)


def gear(draw: Generator) -> Manifold:
    """A spur gear of 16 to 48 teeth with a bore, most with a hub on one side."""
    teeth = int(draw.integers(16, 49))
    sides = _sides(draw)
    root = 0.5 * teeth - 1.25
    width = root * math.exp(draw.uniform(math.log(0.2), math.log(1.5)))
    hub = root * draw.uniform(0.4, 0.8)
    top = width
    solid = extrude(spur_gear(teeth, 1.0), "z", 0.0, width)
    if draw.random() < 0.65:
        top = width * draw.uniform(1.2, 2.0)
        solid += drill(hub, "z", (0.0, 0.0), 0.5 * width, top, sides)
    return solid - drill(
        hub * draw.uniform(0.3, 0.8), "z", (0.0, 0.0), -1.0, top + 1.0, sides
    )


def screw(draw: Generator) -> Manifold:
    """A hexagon or a round head on a shank."""
    sides = _sides(draw)
    length = draw.uniform(4.0, 40.0)
    head = draw.uniform(2.5, 8.0)
    flat = extrude(
        7.5 * unit_circle(6 if draw.random() < 0.6 else sides), "z", -head, 0.0
    )
    shank = np.array(
        [
            (0.0, -1.0),
            (4.0, -1.0),
            (4.0, length),
            (3.4, length + 0.6),
            (0.0, length + 0.6),
        ]
    )
    return flat + revolve(shank, sides)


def bracket(draw: Generator) -> Manifold:
    """An angle bracket with rounded corners and a hole in each leg."""
    wide, deep, rise = draw.uniform(20.0, 50.0, 3)
    thick = draw.uniform(2.0, 7.0)
    side = rounded_polygon(
        [
            (0.0, 0.0, 1.0),
            (wide, 0.0, 0.0),
            (wide, thick, 0.0),
            (thick, thick, 1.5),
            (thick, rise, 0.0),
            (0.0, rise, 0.0),
        ]
    )
    hole = draw.uniform(0.08, 0.3) * min(wide - thick, rise - thick, deep)
    body = extrude(side, "z", 0.0, deep)
    body -= drill(hole, "y", (0.5 * deep, 0.5 * (thick + wide)), -1.0, thick + 1.0)
    return body - drill(
        hole,
        "x",
        (0.5 * (thick + rise), draw.uniform(0.4, 0.6) * deep),
        -1.0,
        thick + 1.0,
    )


def plate(draw: Generator) -> Manifold:
    """A milled plate with rounded corners, a boss, and one or two holes."""
    wide, deep = draw.uniform(20.0, 50.0, 2)
    thick = draw.uniform(3.0, 15.0)
    corner = draw.uniform(0.5, 6.0)
    outline = rounded_rectangle(wide, deep, corner)
    shorter = min(wide, deep)
    x = draw.uniform(0.35, 0.65) * wide
    body = extrude(outline, "z", 0.0, thick)
    boss = 0.2 * shorter
    top = thick + draw.uniform(1.0, 12.0)
    body += drill(boss, "z", (x, 0.5 * deep), 0.5 * thick, top, 64)
    body -= drill(
        boss * draw.uniform(0.3, 0.8), "z", (x, 0.5 * deep), -1.0, top + 1.0, 64
    )
    if draw.random() < 0.5:
        body -= drill(0.07 * shorter, "z", (0.15 * wide, 0.5 * deep), -1.0, thick + 1.0)
    return body


def rounded_rectangle(x: float, y: float, radius: float, steps: int = 6) -> Outline:
    """A rectangle from the origin on; `steps`: of each corner."""
    corners = ((0.0, 0.0), (x, 0.0), (x, y), (0.0, y))
    return rounded_polygon([(*corner, radius) for corner in corners], steps)


def _sides(draw: Generator) -> int:
    return 4 * int(draw.integers(6, 33))


def _square(begin: float, end: float, half: float) -> Outline:
    return np.array([(begin, -half), (end, -half), (end, half), (begin, half)])


KINDS: tuple[Callable[[Generator], Manifold], ...] = (
    shaft,
    bracket,
    ring,
    screw,
    plate,
    gear,
)
