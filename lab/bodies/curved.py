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

"""Bodies to measure, each made from its seed alone."""

from collections.abc import Sequence
from itertools import count, product
from typing import NamedTuple

import numpy as np
import trimesh

from ros_pose_stats.core.records import Array, Index
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS

from . import exports, shapes

FEW = (1.0, 0.7, 0.5)
"""Semi-axes of an ellipsoid on which few facets are stable."""

NEAR_SPHERE = (1.0, 0.96, 0.92)
"""Semi-axes of a near-sphere: about 700 of its facets are stable at 4 000 random
vertices.
"""

ROUNDED_AXES = np.array((1.0, 0.8, 0.6))
_CUTS = np.array(
    ((0.64, 0.66, 0.65), (0.67, 0.63, 0.66))
)  # unequal: no symmetry, no ties


class Body(NamedTuple):
    """A named mesh: vertices (V, 3) and triangles (T, 3)."""

    name: str
    vertices: Array
    triangles: Index


def random_polyhedron(vertices: int, seed: int) -> Body:
    """Hull of normally distributed points, the first from the seed on with that many
    vertices.
    """
    for trial in count(1000 * seed):
        points = np.random.default_rng(trial).standard_normal(
            (vertices * vertices // 6, 3)
        )
        surface = shapes.hull_mesh(points)
        if len(surface[0]) == vertices:
            return Body(f"random polyhedron {seed}", *surface)
    raise AssertionError


def paper_polyhedron(seed: int) -> Body:
    """Hull of normally distributed points, as in the paper's experiments.

    There are 4 points and as many more as a coin of 0.1 fails before its first success.
    """
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((3 + int(rng.geometric(0.1)), 3))
    return Body(f"paper's polyhedron {seed}", *shapes.hull_mesh(points))


def ellipsoid(vertices: int, seed: int = 1) -> Body:
    """Random points on an ellipsoid: few stable facets."""
    return Body(
        "ellipsoid", *shapes.hull_mesh(shapes.ellipsoid_points(vertices, seed, FEW))
    )


def sphere(vertices: int, seed: int = 1) -> Body:
    """Random points on a sphere: nearly half of the facets are stable."""
    return Body("sphere", *shapes.hull_mesh(shapes.sphere_points(vertices, seed)))


def near_sphere(vertices: int, seed: int = 3) -> Body:
    """Random points on an ellipsoid close to a sphere: many stable facets, unevenly
    spread.
    """
    points = shapes.ellipsoid_points(vertices, seed, NEAR_SPHERE)
    return Body("near-sphere", *shapes.hull_mesh(points))


def demo_parts() -> list[Body]:
    """The demo parts as meshed, in millimetres."""
    return [Body(name, *make()) for name, make in DEMO_PARTS.items()]


def rounded_box(fineness: int) -> Body:
    """Ellipsoid cut by six planes that meet: six flat faces and eight rounded corners.

    The ellipsoid has its equilibria where the planes cut it away, so the six flats are
    the only stable faces however fine the corners are. There are 4 (f + 1) (f + 2)
    vertices.
    """
    corners = [_corner(np.array(side), fineness) for side in product((0, 1), repeat=3)]
    return Body("rounded box", *shapes.hull_mesh(np.vstack(corners) * ROUNDED_AXES))


def _corner(side: Index, fineness: int) -> Array:
    """Triangular grid on one corner of the cut unit sphere.

    In squared coordinates the sphere is the plane X + Y + Z = 1 and each cut is X =
    const, so the corner is a flat triangle there and its rims come out exactly planar.
    """
    cut = _CUTS[side, np.arange(3)] ** 2
    i, j = np.meshgrid(np.arange(fineness + 1), np.arange(fineness + 1), indexing="ij")
    is_inside = i + j <= fineness
    weights = (
        np.column_stack((i[is_inside], j[is_inside], fineness - (i + j)[is_inside]))
        / fineness
    )
    ends = np.tile(cut, (3, 1))
    np.fill_diagonal(ends, 1.0 - cut.sum() + cut)
    squares = np.where(weights == 0.0, cut, weights @ ends)
    return np.sqrt(squares) * (2 * side - 1)


def cut_ball(
    subdivisions: int, axes: Sequence[float] = (1.0, 1.0, 1.0), height: float = 0.7
) -> shapes.Surface:
    """An ellipsoid cut at that share of its lower radius."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    points = np.array(ball.vertices)
    edges = ball.edges_unique
    is_cut = points[:, 2] < -height
    first, last = edges[is_cut[edges[:, 0]] != is_cut[edges[:, 1]]].T
    share = (-height - points[first, 2]) / (points[last, 2] - points[first, 2])
    crossing = points[first] + share[:, None] * (points[last] - points[first])
    return shapes.hull_mesh(np.vstack((points[~is_cut], crossing)) * np.array(axes))


LENGTH = 0.05
"""Of bodies of so many triangles, metres."""


def ring_of(triangles: int) -> Body:
    """Flat elliptic ring, a torus: half of its vertices are on the hull."""
    sides = max(3, round((triangles / 10) ** 0.5))
    sections = max(3, triangles // (2 * sides))
    tube = exports.circle(sides)
    vertices, corners = exports.turned(
        np.column_stack((1.0 + 0.3 * np.cos(tube), 0.2 * np.sin(tube))),
        exports.circle(sections),
    )
    return Body(
        f"ring, {len(corners)} triangles",
        LENGTH * vertices * (1.0, 0.8, 1.0),
        corners,
    )


def rounded_box_of(triangles: int) -> Body:
    """Rounded box: all of its vertices are on the hull."""
    body = rounded_box(max(1, round((triangles / 8.0) ** 0.5 - 1.5)))
    return Body(
        f"rounded box, {len(body.triangles)} triangles",
        LENGTH * body.vertices,
        body.triangles,
    )
