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

"""Convex bodies, from harmless to as degenerate as a mesh can be, and the same body
changed.

Each maker takes a random generator and gives vertices and triangles.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from ros_pose_stats.core.records import Array

from . import shapes
from .shapes import Surface
from .variants import joined

Random = np.random.Generator

REGULAR = (
    shapes.tetrahedron,
    shapes.octahedron,
    shapes.icosahedron,
    shapes.dodecahedron,
)


def rotation(random: Random) -> Array:
    """Random rotation matrix."""
    return np.asarray(Rotation.from_quat(random.standard_normal(4)).as_matrix())


def turned(surface: Surface, random: Random) -> Surface:
    """Turned at random."""
    return surface[0] @ rotation(random).T, surface[1]


def power(random: Random, low: float, high: float) -> float:
    """Power of ten with a random exponent."""
    return float(10.0 ** random.uniform(low, high))


def split(surface: Surface) -> Surface:
    """Each triangle with three vertices of its own."""
    vertices, triangles = surface
    return vertices[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(
        -1, 3
    )


def with_pocket(surface: Surface, center: Array, factor: float = 0.3) -> Surface:
    """With a void of its own shape inside, shrunk towards a point."""
    vertices, triangles = surface
    return joined(surface, (center + factor * (vertices - center), triangles[:, ::-1]))


def points_of_a_ball(random: Random, count: int) -> Array:
    """Normally distributed points."""
    return np.asarray(random.standard_normal((count, 3)))


def polyhedron(random: Random) -> Surface:
    """Hull of normally distributed points."""
    return shapes.hull_mesh(points_of_a_ball(random, int(random.integers(4, 40))))


def regular(random: Random) -> Surface:
    """A regular solid, box or prism, turned, its corners moved by 1e-17 to 1e-3."""
    choice = int(random.integers(len(REGULAR) + 2))
    if choice < len(REGULAR):
        vertices, triangles = REGULAR[choice]()
    elif choice == len(REGULAR):
        vertices, triangles = shapes.box(*random.integers(1, 4, 3).astype(float))
    else:
        vertices, triangles = shapes.prism(
            int(random.integers(3, 30)), 1.0, float(random.integers(1, 9)) / 4.0
        )
    moves = power(random, -17, -3) * random.standard_normal(vertices.shape)
    return turned((vertices + moves, triangles), random)


def stretched(random: Random) -> Surface:
    """A polyhedron flattened or drawn out by up to 1e8, turned."""
    vertices, triangles = polyhedron(random)
    stretch = 10.0 ** random.uniform(-8.0, 0.0, 3)
    return turned((vertices * stretch, triangles), random)


def needle(random: Random) -> Surface:
    """A slender box or prism, across down to 1e-8 of its length; corners moved by a
    part of it.
    """
    widths = 10.0 ** random.uniform(-8.0, -1.0, 2)
    vertices, triangles = (
        shapes.box(1.0, *widths)
        if random.random() < 0.5
        else shapes.prism(int(random.integers(3, 9)), widths[0], 1.0)
    )
    moves = (
        random.standard_normal(vertices.shape) * widths.min() * power(random, -9, -1)
    )
    return turned((vertices + moves, triangles), random)


def plate(random: Random) -> Surface:
    """A flat prism, down to a hundred-millionth of its radius."""
    thin = power(random, -8, -1)
    vertices, triangles = shapes.prism(int(random.integers(3, 24)), 1.0, thin)
    moves = random.standard_normal(vertices.shape) * thin * power(random, -9, -1)
    return turned((vertices + moves, triangles), random)


def twins(random: Random) -> Surface:
    """Every corner twice or three times, 1e-13 to 1e-2 apart."""
    points = points_of_a_ball(random, int(random.integers(4, 16)))
    gap = power(random, -13, -2)
    copies = [
        points + gap * random.standard_normal(points.shape)
        for _ in range(int(random.integers(1, 3)))
    ]
    return shapes.hull_mesh(np.vstack((points, *copies)))


def slivers(random: Random) -> Surface:
    """Points along the edges and inside the faces of a polyhedron, nearly on them."""
    vertices, triangles = polyhedron(random)
    weights = random.dirichlet((0.1, 0.1, 0.1), len(triangles))
    inner = np.einsum("tc,tcx->tx", weights, vertices[triangles])
    bulge = 1.0 + power(random, -15, -1) * random.standard_normal((len(inner), 1))
    return shapes.hull_mesh(np.vstack((vertices, inner * bulge)))


def rough_box(random: Random) -> Surface:
    """Points scattered over the faces of a box, off by 1e-16 to 1e-3."""
    points = random.uniform(-1.0, 1.0, (int(random.integers(8, 80)), 3))
    axis = random.integers(0, 3, len(points))
    points[np.arange(len(points)), axis] = np.sign(points[np.arange(len(points)), axis])
    points = np.vstack((shapes.box(2.0, 2.0, 2.0)[0], points)) * random.uniform(
        0.2, 1.0, 3
    )
    points += power(random, -16, -3) * random.standard_normal(points.shape)
    return turned(shapes.hull_mesh(points), random)


def grid(random: Random) -> Surface:
    """Hull of points of a small lattice: coplanar, cocircular and tied everywhere."""
    size = int(random.integers(2, 7))
    points = random.integers(0, size, (int(random.integers(6, 60)), 3)).astype(float)
    points = np.vstack((points, np.zeros(3), np.eye(3) * (size - 1)))
    return shapes.hull_mesh(np.unique(points, axis=0))


def rings(random: Random) -> Surface:
    """Rings of cocircular points, some bunched: fans of slivers, narrow bands, short
    edges.
    """
    levels = []
    for height in np.sort(random.uniform(-1.0, 1.0, int(random.integers(2, 4)))):
        angles = random.uniform(0.0, 2.0 * np.pi, int(random.integers(3, 40)))
        if random.random() < 0.5:
            angles = np.repeat(angles, 2) + power(random, -12, -2) * np.arange(
                2 * len(angles)
            )
        ring = np.sqrt(1.0 - height * height) * np.exp(1j * angles)
        levels.append(
            np.column_stack((ring.real, ring.imag, np.full(len(ring), height)))
        )
    return turned(shapes.hull_mesh(np.vstack(levels)), random)


def round_body(random: Random) -> Surface:
    """Points on an ellipsoid with nearly equal axes: most facets are stable."""
    points = points_of_a_ball(random, int(random.integers(8, 120)))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return shapes.hull_mesh(points * (1.0 + power(random, -9, -1) * random.random(3)))


def leaning(random: Random) -> Surface:
    """A prism that leans until its centre is over the rim of its base, to 1e-15."""
    sides = int(random.integers(3, 9))
    vertices, triangles = shapes.prism(sides, 1.0, 2.0)
    lean = np.cos(np.pi / sides) * (
        1.0 + power(random, -15, -1) * random.choice((-1, 0, 1))
    )
    rim = np.array((np.cos(np.pi / sides), np.sin(np.pi / sides))) * lean
    vertices = vertices + 0.0
    vertices[:, :2] += np.outer((vertices[:, 2] + 1.0), rim)
    return vertices @ rotation(random).T, triangles


def float32(random: Random) -> Surface:
    """A polyhedron some way off its origin in single precision."""
    vertices, triangles = polyhedron(random)
    away = power(random, -1, 5) * random.standard_normal(3)
    return (vertices + away).astype(np.float32).astype(np.float64), triangles


def far(random: Random) -> Surface:
    """A polyhedron up to 1e12 sizes off its origin."""
    vertices, triangles = polyhedron(random)
    return vertices + power(random, 0, 12) * random.standard_normal(3), triangles


def scaled(random: Random) -> Surface:
    """A polyhedron in a unit of 1e-9 to 1e9."""
    vertices, triangles = polyhedron(random)
    return vertices * power(random, -9, 9), triangles


def scaled_widely(random: Random) -> Surface:
    """A polyhedron in a unit of 1e-310 to 1e308."""
    vertices, triangles = polyhedron(random)
    with np.errstate(over="ignore"):
        return vertices * power(random, -310, 308), triangles
