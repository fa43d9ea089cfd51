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

"""Exact convex bodies for tests, benchmarks and studies, and random points to make
hulls of.

Each body is a pair (vertices, triangles): (V, 3) float64 in the unit of its arguments
and (T, 3) int64, counter-clockwise seen from outside. All are centred on the origin,
and their coordinates are as symmetric as floating point allows: a reflection or quarter
turn that the body has maps its vertices onto each other bit for bit. The face normals
of a regular solid are the corners of its dual, so that four sets of points make all
five solids.
"""

from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull

from ros_pose_stats.core.mesh.arrays import sort_triangles
from ros_pose_stats.core.records import Array
from ros_pose_stats.core.shapes.profiles import Surface as Surface, prism as prism

_GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0


def cube_corners() -> Array:
    """The eight points (±1, ±1, ±1)."""
    return np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(
        -1, 3
    )


def axis_ends() -> Array:
    """The six points ±x, ±y, ±z."""
    return np.vstack((np.eye(3), -np.eye(3))) + 0.0


def _golden_rectangles(short: float, long: float) -> Array:
    """The twelve corners of three mutually perpendicular rectangles."""
    rectangle = [(0.0, s * short, t * long) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    return np.vstack([np.roll(rectangle, turn, axis=1) for turn in range(3)])


def icosahedron_corners() -> Array:
    """The twelve corners of the icosahedron of edge 2."""
    return _golden_rectangles(1.0, _GOLDEN)


def dodecahedron_corners() -> Array:
    """The twenty corners of the dodecahedron around the cube [-1, 1]³."""
    return np.vstack((cube_corners(), _golden_rectangles(_GOLDEN, _GOLDEN - 1.0)))


def polytope(vertices: Array, normals: Array) -> Surface:
    """Fan-triangulated regular solid from its corners and outward face normals (any
    length).
    """
    triangles = [fan for normal in normals for fan in _face_fan(vertices, normal)]
    return vertices, np.array(triangles, dtype=np.int64)


def _face_fan(vertices: Array, normal: Array) -> list[tuple[int, int, int]]:
    """Triangles of the face farthest along `normal`, counter-clockwise from outside."""
    reach = vertices @ normal
    face = np.flatnonzero(
        reach > 0.5 * reach.max()
    )  # others of a regular solid: below 0.24
    spokes = vertices[face] - vertices[face].mean(axis=0)
    x_axis = spokes[0]
    y_axis = np.cross(normal, x_axis) / np.linalg.norm(normal)
    loop = face[
        np.argsort(np.arctan2(spokes @ y_axis, spokes @ x_axis) % (2.0 * np.pi))
    ]
    first, *followers = loop.tolist()
    return [(first, a, b) for a, b in pairwise(followers)]


def box(x: float, y: float, z: float) -> Surface:
    """Box with edge lengths x, y, z along the axes: 8 vertices, 12 triangles."""
    vertices, triangles = polytope(cube_corners(), axis_ends())
    return vertices * (np.array((x, y, z)) / 2.0), triangles


def cylinder(sides: int, radius: float, length: float) -> Surface:
    """Cylinder along z, tessellated as a regular prism whose corners lie on the
    circle.
    """
    return prism(sides, radius, length)


def lofted(rings: Array, ends: Array) -> Surface:
    """Closed surface through rings (m, n, 3) of as many corners, counter-clockwise seen
    from the last one; fans about two ends (2, 3) close the first and the last.
    """
    count, sides = rings.shape[:2]
    corner = np.arange((count - 1) * sides).reshape(-1, sides)
    neighbour = np.roll(corner, -1, axis=1)
    first = corner[0]
    last = first + corner.size
    walls = [
        np.stack((corner, neighbour, neighbour + sides), axis=2),
        np.stack((corner, neighbour + sides, corner + sides), axis=2),
    ]
    middle = np.full(sides, count * sides)
    fans = [
        np.column_stack((neighbour[0], first, middle)),
        np.column_stack((last, np.roll(last, -1), middle + 1)),
    ]
    triangles = np.vstack([*(wall.reshape(-1, 3) for wall in walls), *fans])
    return np.vstack((rings.reshape(-1, 3), ends)), triangles


def tetrahedron() -> Surface:
    """Regular tetrahedron on four corners of the cube [-1, 1]³: edge 2√2, volume
    8/3.
    """
    corners = cube_corners()
    corners = corners[np.prod(corners, axis=1) > 0.0]
    return polytope(corners, -corners)


def octahedron() -> Surface:
    """Regular octahedron on the ends of the unit axes: edge √2, volume 4/3."""
    return polytope(axis_ends(), cube_corners())


def icosahedron() -> Surface:
    """Regular icosahedron on the rectangles 2 by 2φ: edge 2, volume 10 (3 + √5) / 3."""
    return polytope(icosahedron_corners(), dodecahedron_corners())


def dodecahedron() -> Surface:
    """Regular dodecahedron around the cube [-1, 1]³: edge √5 - 1, volume 10 + 2√5."""
    return polytope(dodecahedron_corners(), icosahedron_corners())


def hull_mesh(points: Array) -> Surface:
    """Points on the convex hull of points (N, 3), in the order given, and outward
    triangles.
    """
    points = np.asarray(points, dtype=np.float64)
    hull = ConvexHull(points)
    used, triangles = np.unique(hull.simplices, return_inverse=True)
    vertices = points[used]
    triangles = triangles.reshape(-1, 3).astype(np.int64)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return vertices, sort_triangles(triangles)


def sphere_points(n: int, seed: int) -> Array:
    """Random points (n, 3), uniform on the unit sphere."""
    directions = np.random.default_rng(seed).standard_normal((n, 3))
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def ellipsoid_points(n: int, seed: int, semi_axes: tuple[float, float, float]) -> Array:
    """`sphere_points` stretched by the semi-axes, hence denser per area at the long
    ends.
    """
    return sphere_points(n, seed) * np.asarray(semi_axes, dtype=np.float64)
