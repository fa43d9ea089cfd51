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

"""The walks: bodies and scenes that go through one known trouble each, step by step."""

import math
from functools import lru_cache

import numpy as np

from lab.bodies.random_polyhedra import random_polyhedron
from lab.bodies.shapes import box, hull_mesh, sphere_points
from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.records import Array, Part
from ros_pose_stats.core.resting.poses import resting_poses

from .part_walks import part_walks
from .walk import (
    SIZE,
    Step,
    Walk,
    is_along,
    is_towards,
)

LEAN_HEIGHT = 1.5
RANDOM_BODY = 3
"""Number of the random polyhedron, of seed 1."""

THICK = 0.6
"""Thickness over width of the plate whose scene changes."""

ROCKING_BODY = (11, 335, 1.0)
"""Seed, number and shift of the random polyhedron that rocks over a low ridge."""

NEAR = 0.3
"""Radians within which the poses of a disturbed body count as one of the
undisturbed's.
"""


def walks() -> list[Walk]:
    """All walks, in the order of the page."""
    return [
        _leaning(),
        _roof(),
        *part_walks(),
        _sphere(),
        _prism(),
        _broken_cube(),
        _noisy(),
        _restitution(),
        _rocking(),
        _drop_height(),
    ]


def _leaning() -> Walk:
    return Walk(
        "marginal_face",
        "A prism leans until its centre of mass crosses the base's edge",
        "lean of the top over the width of the base",
        np.linspace(0.85, 1.15, 13),
        False,
        lambda lean: Step(_leaning_prism(lean)),
        is_along(2),
        "both bases together",
        0.0,
        mark=1.0,
    )


def _leaning_prism(lean: float) -> Part:
    base = np.array([(x, y, 0.0) for x in (-0.5, 0.5) for y in (-0.4, 0.4)])
    return _hull(np.vstack((base, base + np.array((lean, 0.0, LEAN_HEIGHT)))))


def _roof() -> Walk:
    return Walk(
        "coplanar_faces",
        "The roof of a house flattens until it is one face",
        "height of the ridge over the width",
        np.geomspace(1e-12, 0.3, 24),
        True,
        lambda rise: Step(_house(rise)),
        is_towards((0.0, 0.0, 1.0), 0.8),
        "the roof",
        0.0,
    )


def _house(rise: float) -> Part:
    walls = [(x, y, z) for x in (-0.6, 0.6) for y in (-0.5, 0.5) for z in (0.0, 0.7)]
    ridge = [(x, 0.0, 0.7 + rise) for x in (-0.6, 0.6)]
    return _hull(np.array(walls + ridge))


def _sphere() -> Walk:
    return Walk(
        "heavy_sphere",
        "A tessellated sphere loses the offset of its centre of mass",
        "offset over the radius",
        np.geomspace(1e-4, 0.2, 12),
        True,
        lambda offset: Step(_loaded_sphere(offset)),
        is_towards((0.0, 0.0, -1.0), 0.25 * math.pi),
        "a pose within 45 degrees of the heavy side",
    )


def _loaded_sphere(offset: float) -> Part:
    plain = _plain_sphere()
    return part_from_mesh(
        plain.vertices,
        plain.triangles,
        plain.center_of_mass - np.array((0.0, 0.0, offset * SIZE)),
    )


@lru_cache(maxsize=1)
def _plain_sphere() -> Part:
    return part_from_mesh(*hull_mesh(SIZE * sphere_points(400, 1)))


def _prism() -> Walk:
    return Walk(
        "needle",
        "A square prism goes from a plate to a needle",
        "length over width",
        np.geomspace(0.01, 100.0, 25),
        True,
        lambda ratio: Step(part_from_mesh(*box(SIZE, SIZE, ratio * SIZE))),
        is_along(2),
        "both square faces together",
    )


def _broken_cube() -> Walk:
    return Walk(
        "broken_symmetry",
        "The corners of a cube are moved at random",
        "move over the edge",
        np.geomspace(1e-12, 1e-1, 23),
        True,
        lambda size: Step(_hull(_moved(np.array(box(1.0, 1.0, 1.0)[0]), size))),
        is_towards((0.0, 0.0, -1.0), NEAR),
        "one face",
        0.0,
    )


def _noisy() -> Walk:
    body = random_polyhedron(1, RANDOM_BODY)
    return Walk(
        "vertex_noise",
        "The vertices of a random polyhedron are moved at random",
        "move over the radius",
        np.geomspace(1e-9, 1e-1, 17),
        True,
        lambda size: Step(_hull(_moved(body.vertices, size))),
        is_towards(_favourite(body.part()), NEAR),
        "its most probable pose",
        0.0,
    )


def _restitution() -> Walk:
    part = _plate()
    return Walk(
        "restitution",
        "A thick square plate falls on harder and harder ground",
        "coefficient of restitution",
        np.linspace(0.0, 0.95, 20),
        False,
        lambda value: Step(part, restitution=value),
        is_along(2),
        "both square faces together",
    )


def _rocking() -> Walk:
    part = random_polyhedron(*ROCKING_BODY).part()
    x, y, z = resting_poses(part, 0.0, 0).poses[1].down.tolist()
    return Walk(
        "rocking",
        "A part with two poses side by side falls on harder and harder ground",
        "coefficient of restitution",
        np.linspace(0.0, 0.95, 20),
        False,
        lambda value: Step(part, restitution=value),
        is_towards((x, y, z), 0.1),
        "the higher one of the two",
        0.0,
    )


def _drop_height() -> Walk:
    part = _plate()
    return Walk(
        "drop_height",
        "A thick square plate falls from touching up",
        "drop height in radii",
        np.geomspace(0.3, 100.0, 22),
        True,
        lambda radii: Step(
            part, drop_height=radii * resting_poses(part, round_sides=0).body.radius
        ),
        is_along(2),
        "both square faces together",
        mark=1.0,
    )


def _plate() -> Part:
    return part_from_mesh(*box(SIZE, SIZE, THICK * SIZE))


def _favourite(part: Part) -> tuple[float, float, float]:
    """Direction of the pose with the largest contact face's centroid solid angle:
    CSAE's.
    """
    from ros_pose_stats import estimate

    x, y, z = estimate(part, "combined").poses[0].down.tolist()
    return x, y, z


def _moved(vertices: Array, size: float) -> Array:
    """Move vertices by normal numbers of this size, in the same directions for every
    size.
    """
    return vertices + size * np.random.default_rng(1).standard_normal(vertices.shape)


def _hull(points: Array) -> Part:
    """A homogeneous body of the usual size."""
    return part_from_mesh(*hull_mesh(SIZE * points))
