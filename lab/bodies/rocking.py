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

"""Parts that rock: curves that are no full turn, beside flats. No estimator was fitted
to them.

A part that rocks on a curve keeps its energy, and a flat takes it in one blow; how
often it stays there is what estimators know least about.
"""

import math

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.records import Array

from .solids import Solid, extruded
from .turned import _rings, flattened_ball


def _arc(draw: Generator, begin: float, end: float) -> Array:
    """Points (k, 2) on the unit circle between two angles, as files cut it: 48 to 200 a
    turn.
    """
    sides = math.exp(draw.uniform(math.log(48), math.log(200)))
    turn = np.linspace(
        begin, end, max(3, math.ceil(sides * (end - begin) / (2.0 * math.pi))) + 1
    )
    return np.column_stack((np.cos(turn), np.sin(turn)))


def _drawn(
    outline: Array, draw: Generator, shortest: float = 0.3, longest: float = 4.0
) -> list[Solid]:
    """An outline along an axis, between so many and so many times as long as its
    radius.
    """
    length = math.exp(draw.uniform(math.log(shortest), math.log(longest)))
    return [extruded(outline, 0.0, length)]


def cut_cylinders(draw: Generator) -> list[Solid]:
    """Half cylinders and shafts with one flat, shallow to deep."""
    half = math.acos(draw.uniform(-0.9, 0.6))
    return _drawn(
        _arc(draw, half - math.pi, math.pi - half) @ np.array([(0, 1), (-1, 0)]), draw
    )


def sectors(draw: Generator) -> list[Solid]:
    """Slices of a cylinder of 30 to 180 degrees."""
    return _drawn(
        np.vstack(
            (_arc(draw, 0.0, math.radians(draw.uniform(30.0, 180.0))), np.zeros((1, 2)))
        ),
        draw,
    )


def ovals(draw: Generator) -> list[Solid]:
    """Elliptic cylinders; some have a flat below."""
    oval = _arc(draw, 0.0, 2.0 * math.pi)[:-1] * (1.0, draw.uniform(0.4, 0.95))
    if draw.random() < 0.5:
        oval[:, 1] = np.maximum(oval[:, 1], draw.uniform(0.5, 0.95) * oval[:, 1].min())
    return _drawn(oval, draw)


def rounded_polygons(draw: Generator) -> list[Solid]:
    """Triangles to pentagons with round corners."""
    corners = int(draw.integers(3, 6))
    radius = draw.uniform(0.15, 1.2)
    turn = 2.0 * math.pi / corners
    return _drawn(
        np.vstack(
            [
                np.array((math.cos(k * turn), math.sin(k * turn)))
                + radius * _arc(draw, (k - 0.5) * turn, (k + 0.5) * turn)
                for k in range(corners)
            ]
        ),
        draw,
    )


def arc_plates(draw: Generator) -> list[Solid]:
    """Plates with one or two round ends or corners, 0.08 to 0.6 thick."""
    wide = draw.uniform(0.3, 2.5)
    ends = [_arc(draw, 0.0, math.pi * draw.choice([0.5, 1.0])) + np.array((0.0, wide))]
    if draw.random() < 0.4:
        ends.append(-ends[0] * (1.0, draw.uniform(0.3, 1.0)))
    return _drawn(np.vstack((*ends, [(1.0, 0.0), (-1.0, 0.0)])), draw, 0.08, 0.6)


def domes(draw: Generator) -> list[Solid]:
    """Caps of a ball or an egg, on a foot of any height."""
    segments = 4 * int(draw.integers(12, 25))
    high = draw.uniform(0.4, 1.8)
    level = np.linspace(draw.uniform(-0.3, 0.6), 1.0, segments // 4)
    circles = [(math.sqrt(1.0 - z * z), high * z) for z in level.tolist()]
    if draw.random() < 0.4:
        radius, low = circles[0]
        circles.insert(0, (radius, low - draw.uniform(0.1, 1.5)))
    return [_rings(segments, circles)]


def cut_eggs(draw: Generator) -> list[Solid]:
    """Balls and eggs with one to three flats."""
    segments = 4 * int(draw.integers(12, 19))
    points = flattened_ball(draw, segments, 3, 0.55, 0.95)
    points[:, 2] *= np.where(points[:, 2] > 0.0, *draw.uniform(0.6, 1.5, 2))
    return [Solid(points)]


def free_forms(draw: Generator) -> list[Solid]:
    """Hulls of scans: superellipsoids of 300 to 1 200 points, some cut flat."""
    points = draw.normal(
        size=(round(math.exp(draw.uniform(math.log(300), math.log(1200)))), 3)
    )
    power = draw.uniform(1.6, 5.0)
    points /= (np.abs(points) ** power).sum(axis=1, keepdims=True) ** (1.0 / power)
    if draw.random() < 0.6:
        points[:, 0] = np.minimum(points[:, 0], draw.uniform(0.4, 0.9))
    return [Solid(points * (1.0, *draw.uniform(0.45, 1.0, 2)))]


ROCKING = {
    "cut cylinders": cut_cylinders,
    "sectors": sectors,
    "ovals": ovals,
    "rounded polygons": rounded_polygons,
    "arc plates": arc_plates,
    "domes": domes,
    "cut eggs": cut_eggs,
    "free forms": free_forms,
}
