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

"""Random bodies of each family."""

import math

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.mesh.surface import solid_of
from ros_pose_stats.core.mesh.vectors import to_unit_size
from ros_pose_stats.core.shapes.profiles import unit_circle

from .shapes import hull_mesh
from .solids import Solid, around, cube, extruded, tapered
from .turned import rounds


def prisms(draw: Generator) -> list[Solid]:
    """Regular prisms of 3 to 12 sides, or boxes, with ratios from 1/3 to 3."""
    if draw.random() < 0.3:
        x, y, z = np.exp(draw.uniform(-math.log(2.5), math.log(2.5), 3)).tolist()
        return [extruded(np.array([(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)]), 0.0, z)]
    sides = int(draw.choice([3, 4, 4, 4, 5, 6, 6, 8, 10, 12]))
    width = 2.0 * math.cos(math.pi / sides)
    ratio = float(np.exp(draw.uniform(-math.log(3.0), math.log(3.0))))
    return [extruded(unit_circle(sides), 0.0, width * ratio)]


def plates(draw: Generator) -> list[Solid]:
    """Convex outlines of 3 to 8 corners, 0.04 to 0.5 thick, some with bevelled
    edges.
    """
    corners = int(draw.integers(3, 9))
    outline = around(corners, 0.35, draw) * (1.0, draw.uniform(0.4, 1.0))
    thick = float(np.exp(draw.uniform(math.log(0.08), math.log(1.0))))
    if draw.random() < 0.4:
        return [tapered(outline, ((1.0, 0.0), (draw.uniform(0.5, 0.95), thick)))]
    return [extruded(outline, 0.0, thick)]


def ellipsoids(draw: Generator) -> list[Solid]:
    """Hulls of 8 to 60 points on an ellipsoid."""
    return _ellipsoid(draw, 8, 60)


def fine_ellipsoids(draw: Generator) -> list[Solid]:
    """Hulls of 100 to 2000 points on an ellipsoid."""
    return _ellipsoid(draw, 100, 2000)


def _ellipsoid(draw: Generator, fewest: int, most: int) -> list[Solid]:
    count = round(math.exp(draw.uniform(math.log(fewest), math.log(most))))
    points = draw.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return [Solid(points * (1.0, *draw.uniform(0.35, 1.0, 2)))]


def lumps(draw: Generator) -> list[Solid]:
    """Castings and pebbles: hulls of 30 to 600 points on a wavy ellipsoid."""
    points = round(math.exp(draw.uniform(math.log(30), math.log(600))))
    toward = draw.normal(size=(points, 3))
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    waves = draw.normal(size=(6, 3)) * draw.uniform(0.5, 2.5)
    heights = draw.normal(size=6) * draw.uniform(0.03, 0.15)
    reach = np.exp(
        np.cos(toward @ waves.T + draw.uniform(0.0, 2.0 * math.pi, 6)) @ heights
    )
    return [Solid(toward * reach[:, None] * (1.0, *draw.uniform(0.45, 1.0, 2)))]


def cornered(draw: Generator) -> list[Solid]:
    """Hulls of 12 to 80 normally distributed points, stretched along the axes."""
    count_of_points = round(math.exp(draw.uniform(math.log(12), math.log(80))))
    return [
        Solid(
            draw.normal(size=(count_of_points, 3)) * (1.0, *draw.uniform(0.4, 1.0, 2))
        )
    ]


def weighted(draw: Generator) -> list[Solid]:
    """A prism, plate, turned part or hull of points, with one to three weights inside.

    Parts of one shape may be hollow or solid inside, so centre of mass and inertia
    differ from those of the hull.
    """
    makers = (prisms, plates, rounds, cornered)
    (shell,) = makers[int(draw.integers(len(makers)))](draw)
    corners = shell.corners
    size = 0.01 * float(np.ptp(corners, axis=0).min())
    vertices, triangles = hull_mesh(corners)
    volume = solid_of(to_unit_size(vertices), triangles).volume
    solids = [shell]
    for _ in range(int(draw.integers(1, 4))):
        share = draw.dirichlet(np.full(corners.shape[0], draw.choice([0.1, 1.0])))
        center = 0.97 * share @ corners + 0.03 * corners.mean(axis=0)
        mass = volume * draw.uniform(0.1, 1.5)
        solids.append(cube(center, 0.5 * size, mass / size**3))
    return solids
