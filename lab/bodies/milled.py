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

"""Random parts as they are milled, stamped or moulded: outlines and edges with rounded
corners.

Lengths are in units of the part; only their ratios matter. Their arcs are those of the
file, not of whole circles, so that poses on them are the facets of an arc.
"""

import math

import numpy as np
from manifold3d import Manifold
from numpy.random import Generator

from ros_pose_stats.core.shapes.demo_parts import drill, extrude, surface_of
from ros_pose_stats.core.shapes.profiles import Outline, rounded_polygon

from .catalogue_parts import rounded_rectangle
from .solids import Solid, around

LARGEST_ARC = 0.45
"""Of the shorter side at a corner, what its arc takes away at most."""


def milled(draw: Generator) -> list[Solid]:
    """One of the kinds of this module: plain and crossed outlines, and boxes with round
    edges.
    """
    kinds = (_plate, _plate, _crossed, _rounded_box)
    solid = kinds[int(draw.integers(len(kinds)))](draw)
    corners, triangles = surface_of(solid)
    return [Solid(corners, triangles=np.asarray(triangles, dtype=np.int64))]


def _plate(draw: Generator) -> Manifold:
    """A rounded outline 0.08 to 1.2 thick, some with one or two holes."""
    thick = math.exp(draw.uniform(math.log(0.08), math.log(1.2)))
    plate = extrude(_outline(draw), "z", 0.0, thick)
    for _ in range(int(draw.integers(0, 3))):
        center = draw.uniform(-0.35, 0.35, 2)
        plate -= drill(
            float(draw.uniform(0.03, 0.15)),
            "z",
            (float(center[0]), float(center[1])),
            -thick,
            2.0 * thick,
        )
    return plate


def _crossed(draw: Generator) -> Manifold:
    """What two rounded outlines at right angles have in common."""
    width = math.exp(draw.uniform(math.log(0.2), math.log(1.2)))
    return extrude(_outline(draw), "z", -1.0, 1.0) ^ extrude(
        _outline(draw) * (1.0, width), "x", -2.0, 2.0
    )


def _rounded_box(draw: Generator) -> Manifold:
    """A box whose edges are rounded, all of them or those along one axis."""
    size = np.exp(draw.uniform(-math.log(3.0), 0.0, 3))
    radius = float(draw.uniform(0.02, 0.3) * size.min())
    steps = int(draw.integers(3, 9))
    if draw.random() < 0.5:
        x, y, z = size.tolist()
        return extrude(rounded_rectangle(x, y, radius, steps), "z", 0.0, z)
    ball = Manifold.sphere(radius, 4 * steps)
    corners = (size - 2.0 * radius) * np.array(np.meshgrid(*[[0.0, 1.0]] * 3)).reshape(
        3, 8
    ).T
    return Manifold.batch_hull(
        [ball.translate(tuple(corner)) for corner in corners.tolist()]
    )


def _outline(draw: Generator) -> Outline:
    """Three to nine corners around the middle, most of them rounded; some
    re-entrant.
    """
    corners = int(draw.integers(3, 10))
    points = around(corners, 0.35, draw)
    points *= draw.uniform(draw.choice([0.4, 0.9]), 1.0, (corners, 1))
    points *= (1.0, draw.uniform(0.4, 1.0))
    sides = np.roll(points, -1, axis=0) - points
    length = np.linalg.norm(sides, axis=1)
    shorter = np.minimum(length, np.roll(length, 1))
    direction = sides / length[:, None]
    previous = np.roll(direction, 1, axis=0)
    bend = np.abs(
        np.arctan2(
            previous[:, 0] * direction[:, 1] - previous[:, 1] * direction[:, 0],
            (previous * direction).sum(axis=1),
        )
    )
    radius = LARGEST_ARC * shorter / np.tan(np.maximum(0.5 * bend, 0.05))
    radius *= draw.uniform(0.0, 1.0, corners) * (draw.random(corners) < 0.8)
    return rounded_polygon(
        [
            (float(x), float(y), float(r))
            for (x, y), r in zip(points, radius, strict=True)
        ],
        int(draw.integers(3, 13)),
    )
