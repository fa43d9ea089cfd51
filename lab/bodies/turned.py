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

"""Random parts as they are turned, and gears.

Lengths are in units of the part; only their ratios matter. Files cut circles into 24 to
200 sides, which drops and estimates take for circles.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.records import Array
from ros_pose_stats.core.shapes.profiles import unit_circle

from .solids import Solid, extruded, fan, tapered


def rounds(draw: Generator) -> list[Solid]:
    """Convex profiles of two to five circles with 12 to 48 sides."""
    sides = int(draw.integers(12, 49))
    circles = int(draw.integers(2, 6))
    height = math.exp(draw.uniform(-math.log(4.0), math.log(4.0)))
    level = np.concatenate(([0.0, height], draw.uniform(0.0, height, circles - 2)))
    radius = draw.uniform(0.3, 1.0, circles)
    if draw.random() < 0.4:
        radius[1] = radius[0]
    return [_rings(sides, zip(radius.tolist(), level.tolist(), strict=True))]


def stepped(draw: Generator) -> list[Solid]:
    """Shafts and pulleys: two to five steps, most with chamfers, some with a bore or a
    flat.
    """
    sides = _sides(draw)
    steps = int(draw.integers(2, 6))
    stretch = math.exp(draw.uniform(math.log(0.15), math.log(1.5)))
    radii = draw.uniform(0.25, 1.0, steps)
    level = 0.0
    solids: list[Solid] = []
    for radius in radii.tolist():
        length = stretch * math.exp(draw.uniform(math.log(0.1), math.log(1.5)))
        solids.append(
            disc(sides, radius, level, level + length, _chamfer(draw, radius, length))
        )
        level += length
    if draw.random() < 0.2:
        widest = int(radii.argmax())
        solids[widest] = _with_flat(
            solids[widest], float(radii[widest] * draw.uniform(0.6, 0.95))
        )
    if draw.random() < 0.3:
        bore = float(radii.min() * draw.uniform(0.2, 0.75))
        solids.append(disc(sides, bore, level * draw.choice([0.0, 0.5]), level).hole())
    return solids


def hollow(draw: Generator) -> list[Solid]:
    """Rings, bushings, washers, cups and nuts: a bore through one or two steps, or a
    blind one.
    """
    sides = _sides(draw)
    height = math.exp(draw.uniform(math.log(0.1), math.log(4.0)))
    if draw.random() < 0.15:
        solids = [extruded(unit_circle(6) * (2.0 / math.sqrt(3.0)), 0.0, height)]
    else:
        solids = [disc(sides, 1.0, 0.0, height, _chamfer(draw, 1.0, height))]
    bore = float(draw.uniform(0.3, 0.95))
    if draw.random() < 0.35:
        collar = float(draw.uniform(bore * 1.05, max(1.6, bore * 1.2)))
        top = height + height * float(draw.uniform(0.05, 1.0))
        solids.append(
            disc(sides, collar, height, top, _chamfer(draw, collar, top - height))
        )
        height = top
    floor = float(draw.uniform(0.05, 0.6)) * height if draw.random() < 0.4 else 0.0
    return [*solids, disc(sides, bore, floor, height).hole()]


def gears(draw: Generator) -> list[Solid]:
    """Spur gears of 8 to 60 teeth; two thirds have a hub, all but few a bore."""
    teeth = round(math.exp(draw.uniform(math.log(8), math.log(60))))
    module = 2.0 / (teeth + 2.0)
    width = math.exp(draw.uniform(math.log(0.1), math.log(1.5)))
    root = 1.0 - 2.25 * module
    sides = _sides(draw)
    tip = draw.uniform(0.1, 0.35)
    foot = draw.uniform(0.5, 0.7)
    turn = (
        2.0
        * math.pi
        * (np.arange(teeth)[:, None] + np.array([-foot, -tip, tip, foot]) / 2.0)
        / teeth
    )
    reach = np.array([root, 1.0, 1.0, root])
    outline = np.stack((reach * np.cos(turn), reach * np.sin(turn)), axis=2).reshape(
        -1, 2
    )
    solids = [fan(outline, 0.0, width)]
    top = width
    core = root
    if draw.random() < 0.65:
        core = root * float(draw.uniform(0.3, 0.8))
        top = width + float(draw.uniform(0.05, 1.0))
        solids.append(disc(sides, core, width, top, _chamfer(draw, core, top - width)))
    if draw.random() < 0.9:
        solids.append(
            disc(sides, core * float(draw.uniform(0.2, 0.8)), 0.0, top).hole()
        )
    return solids


def flat_balls(draw: Generator) -> list[Solid]:
    """Balls with one to four flats; some are beads with a bore between two of them."""
    segments = 4 * int(draw.integers(10, 19))
    if draw.random() < 0.4:
        level = np.cos(np.linspace(0.0, math.pi, segments // 2 + 1))
        low = -float(draw.uniform(0.6, 0.98))
        high = float(draw.uniform(0.6, 1.0))
        level = np.concatenate(([low, high], level[(level > low) & (level < high)]))
        bead = _rings(segments, ((math.sqrt(1.0 - z * z), z) for z in level.tolist()))
        widest = math.sqrt(1.0 - max(low * low, high * high))
        if draw.random() < 0.5 and widest > 0.1:
            return [bead, disc(segments, 0.7 * widest, low, high).hole()]
        return [bead]
    return [Solid(flattened_ball(draw, segments, 4, 0.75, 0.98))]


def disc(
    sides: int, radius: float, low: float, high: float, chamfer: float = 0.0
) -> Solid:
    """A cylinder about z, chamfered at both ends."""
    if not chamfer:
        return _rings(sides, ((radius, low), (radius, high)))
    return _rings(
        sides,
        (
            (radius - chamfer, low),
            (radius, low + chamfer),
            (radius, high - chamfer),
            (radius - chamfer, high),
        ),
    )


def _rings(sides: int, circles: Iterable[tuple[float, float]]) -> Solid:
    """The hull of circles about z, each a radius and a level."""
    return tapered(unit_circle(sides), circles)


def flattened_ball(
    draw: Generator, segments: int, most: int, nearest: float, farthest: float
) -> Array:
    """Points on a ball of radius 1 with up to so many flats, and on the rims of
    these.
    """
    level = np.cos(np.linspace(0.0, math.pi, segments // 2 + 1))
    ball = _rings(
        segments, ((math.sqrt(max(1.0 - z * z, 0.0)), z) for z in level.tolist())
    )
    flats = draw.normal(size=(int(draw.integers(1, most + 1)), 3))
    flats /= np.linalg.norm(flats, axis=1, keepdims=True)
    distances = draw.uniform(nearest, farthest, len(flats))
    return _cut(ball.corners, flats, distances, segments)


def _sides(draw: Generator) -> int:
    return round(math.exp(draw.uniform(math.log(24), math.log(200))))


def _chamfer(draw: Generator, radius: float, length: float) -> float:
    """None, small or large."""
    return float(draw.choice([0.0, 0.03, 0.12])) * min(radius, length)


def _with_flat(round_solid: Solid, away: float) -> Solid:
    """With what lies beyond a plane moved into it."""
    corners = round_solid.corners.copy()
    corners[:, 0] = np.minimum(corners[:, 0], away)
    return Solid(corners)


def _cut(points: Array, flats: Array, distances: Array, sides: int) -> Array:
    """Points of a ball on the near side of all flats, and the rims of the flats."""
    pieces = [points]
    for normal, distance in zip(flats, distances.tolist(), strict=True):
        first_axis = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
        first_axis /= np.linalg.norm(first_axis)
        wide = unit_circle(sides) * math.sqrt(1.0 - distance * distance)
        pieces.append(
            distance * normal
            + wide[:, :1] * first_axis
            + wide[:, 1:] * np.cross(normal, first_axis)
        )
    all_points = np.vstack(pieces)
    return all_points[((all_points @ flats.T) <= distances + 1e-9).all(axis=1)]
