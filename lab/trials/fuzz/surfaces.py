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

"""Meshes as exporters leave them: repeated, turned, torn, crossing, closed wrongly or
not at all.

Each maker takes a random generator and gives vertices and triangles.
"""

import numpy as np

from lab.bodies import shapes
from lab.bodies.degenerate import (
    Random,
    points_of_a_ball,
    polyhedron,
    power,
    regular,
    split,
    turned,
    with_pocket,
)
from lab.bodies.shapes import Surface
from lab.bodies.variants import joined, shuffled, subdivided


def repeated(random: Random) -> Surface:
    """Each triangle with corners of its own, moved by up to 1e-9; some triangles
    twice.
    """
    vertices, triangles = split(polyhedron(random))
    repeats = random.integers(len(triangles), size=int(random.integers(0, 9)))
    moves = random.choice((0.0, 1e-9)) * random.uniform(-1.0, 1.0, vertices.shape)
    return shuffled(
        (vertices + moves, np.vstack((triangles, triangles[repeats]))), random
    )


def fine(random: Random) -> Surface:
    """A polyhedron or regular body with its triangles cut once or twice."""
    surface = subdivided(
        polyhedron(random) if random.random() < 0.5 else regular(random)
    )
    return subdivided(surface) if len(surface[1]) < 100 else surface


def turned_round(random: Random) -> Surface:
    """A polyhedron with some or all triangles turned round."""
    vertices, triangles = polyhedron(random)
    turn = random.random(len(triangles)) < random.choice((0.1, 0.5, 1.0))
    return vertices, np.where(turn[:, None], triangles[:, ::-1], triangles)


def filled(random: Random) -> Surface:
    """A polyhedron with a void, bodies in the void, and vertices of no triangle."""
    surface = polyhedron(random)
    center = surface[0].mean(axis=0)
    hollow = with_pocket(surface, center, float(random.uniform(0.1, 0.99)))
    loose = 5.0 * points_of_a_ball(random, int(random.integers(0, 9)))
    vertices, triangles = joined(
        hollow, (center + 0.05 * (surface[0] - center), surface[1])
    )
    return np.vstack((vertices, loose)), triangles


def bodies(random: Random) -> Surface:
    """Several polyhedra, apart, overlapping or one inside another, wound either way."""
    several = []
    for _ in range(int(random.integers(2, 6))):
        vertices, triangles = polyhedron(random)
        offset = random.choice((0.0, 1.0, 5.0)) * random.standard_normal(3)
        facing = triangles if random.random() < 0.7 else triangles[:, ::-1]
        several.append((vertices * power(random, -2, 0) + offset, facing))
    return joined(*several)


def stacked(random: Random) -> Surface:
    """Boxes of a lattice that touch in faces, edges and corners, some twice in one
    place.
    """
    several = []
    for _ in range(int(random.integers(2, 9))):
        vertices, triangles = shapes.box(*random.integers(1, 3, 3).astype(float))
        several.append((vertices + random.integers(0, 4, 3) / 2.0, triangles))
    surface = joined(*several)
    return surface if random.random() < 0.5 else turned(surface, random)


def soup(random: Random) -> Surface:
    """Loose triangles anywhere."""
    return split(
        (
            points_of_a_ball(random, 60),
            random.integers(60, size=(int(random.integers(1, 40)), 3)),
        )
    )


def tangle(random: Random) -> Surface:
    """Triangles between random vertices: crossing, repeated, edges of three and
    more.
    """
    vertices = points_of_a_ball(random, int(random.integers(4, 30)))
    return vertices, random.integers(
        len(vertices), size=(int(random.integers(4, 90)), 3)
    )


def lattice_tangle(random: Random) -> Surface:
    """A tangle on a lattice: vertices coincide, triangles are coplanar or without
    area.
    """
    vertices = random.integers(0, int(random.integers(2, 5)), (30, 3)).astype(float)
    return vertices, random.integers(30, size=(int(random.integers(4, 90)), 3))


def crowded_edges(random: Random) -> Surface:
    """A polyhedron with walls inside and fins outside, on its own edges."""
    vertices, triangles = polyhedron(random)
    count = len(vertices)
    walls = random.integers(count, size=(int(random.integers(1, 20)), 3))
    if random.random() < 0.5:
        walls = np.vstack((walls, walls[:, ::-1]))
    outside = np.vstack((vertices, 3.0 * points_of_a_ball(random, 2)))
    fins = np.column_stack((triangles[:3, :2], random.integers(count, count + 2, 3)))
    return outside, np.vstack(
        (triangles, walls, fins if random.random() < 0.5 else walls)
    )


def torn(random: Random) -> Surface:
    """A polyhedron or regular body that lacks some of its triangles."""
    vertices, triangles = (
        polyhedron(random) if random.random() < 0.5 else regular(random)
    )
    is_kept = random.random(len(triangles)) > random.choice((0.05, 0.3, 0.9))
    return vertices, triangles[is_kept]


def ring_body(random: Random) -> Surface:
    """A torus or a Klein bottle of a few facets, not convex, corners moved."""
    sides = int(random.integers(3, 9))
    sections = int(random.integers(3, 9))
    u, v = (2.0 * np.pi * np.arange(n) / n for n in (sections, sides))
    u, v = (grid.ravel() for grid in np.meshgrid(u, v, indexing="ij"))
    radius = 1.0 + 0.4 * np.cos(v)
    vertices = np.column_stack(
        (radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v))
    )
    i, j = np.divmod(np.arange(sections * sides), sides)
    next_i = (i + 1) % sections
    next_j = (j + 1) % sides
    one_sided = random.random() < 0.3
    seam = np.where((next_i == 0) & one_sided, -1, 1)
    ahead_corner, ahead_next = ((seam * k) % sides + next_i * sides for k in (j, j + 1))
    corner = i * sides + j
    corner_next = i * sides + next_j
    triangles = np.vstack(
        (
            np.column_stack((corner, ahead_corner, ahead_next)),
            np.column_stack((corner, ahead_next, corner_next)),
        )
    )
    moves = power(random, -16, -1) * random.standard_normal(vertices.shape)
    return vertices + moves, triangles


def dented(random: Random) -> Surface:
    """A polyhedron whose corners are moved along their rays: not convex, perhaps
    crossing.
    """
    vertices, triangles = subdivided(polyhedron(random))
    factors = random.uniform(random.choice((-0.3, 0.2)), 1.0, (len(vertices), 1))
    return vertices * factors, triangles
