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

"""Volume, centre of mass and inertia: closed forms, trimesh, and any place and size."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, strategies

from lab.bodies import shapes
from lab.bodies.variants import moved, rotation, subdivided
from ros_pose_stats import part_from_mesh

WATER = 1000.0


def of_water(vertices, triangles):
    """A part whose mass is its volume in litres."""
    return part_from_mesh(vertices, triangles, density=WATER)


def box_tensor(x, y, z):
    """Of unit mass."""
    return np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0


def star(seed):
    """A solid with dents and spikes: a ball whose corners are moved along their
    radii.
    """
    ball = trimesh.creation.icosphere(1)
    reach = np.random.default_rng(seed).uniform(0.3, 1.0, len(ball.vertices))
    return np.array(ball.vertices) * reach[:, None], np.array(ball.faces)


def assert_tensor(tensor, expected, relative):
    assert np.abs(tensor - expected).max() < relative * np.abs(expected).max()


@given(
    strategies.floats(0.01, 10),
    strategies.floats(0.01, 10),
    strategies.floats(0.01, 10),
)
def test_a_box(x, y, z):
    part = of_water(*shapes.box(x, y, z))
    assert part.mass == pytest.approx(WATER * x * y * z, rel=1e-12)
    assert np.abs(part.center_of_mass).max() < 1e-14 * max(x, y, z)
    assert_tensor(part.inertia, part.mass * box_tensor(x, y, z), 1e-12)


@given(strategies.integers(0, 2**32 - 1))
def test_solids_with_dents_against_trimesh_and_turned(seed):
    surface = star(seed)
    turn = rotation(seed)
    part = of_water(*surface)
    mesh = trimesh.Trimesh(*surface, process=False)
    assert part.mass == pytest.approx(WATER * mesh.volume, rel=1e-10)
    assert part.center_of_mass == pytest.approx(mesh.center_mass, rel=1e-9, abs=1e-10)
    assert_tensor(part.inertia, WATER * mesh.mass_properties["inertia"], 1e-9)
    turned = of_water(*moved(surface, turn, (1.0, 2.0, 3.0)))
    assert turned.center_of_mass == pytest.approx(
        turn @ part.center_of_mass + (1, 2, 3), rel=1e-12
    )
    assert_tensor(turned.inertia, turn @ part.inertia @ turn.T, 1e-11)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("away", [0.0, 1000.0])
def test_scale_and_place_cost_no_digits(scale, away):
    vertices, triangles = shapes.box(1.0, 0.5, 0.25)
    part = part_from_mesh(vertices + away, triangles, unit=scale, density=WATER)
    assert part.mass == pytest.approx(WATER * 0.125 * scale**3, rel=1e-10)
    assert part.center_of_mass / scale - away == pytest.approx(
        [0.0] * 3, abs=1e-12 * (1 + away)
    )
    assert_tensor(
        part.inertia, part.mass * scale**2 * box_tensor(1.0, 0.5, 0.25), 1e-10
    )


def test_the_error_does_not_grow_with_the_triangles():
    sides = np.array([1.0, 2.0, 3.0]) / 3.0
    turn = rotation(1)
    surface = shapes.box(*sides)
    for _ in range(5):
        surface = subdivided(surface)
    part = of_water(*moved(surface, turn, (0.1, -0.2, 0.05)))
    assert len(part.triangles) == 12 * 4**5
    assert part.mass == pytest.approx(WATER * np.prod(sides), rel=3e-15)
    assert part.center_of_mass == pytest.approx([0.1, -0.2, 0.05], abs=1e-15)
    assert_tensor(part.inertia, part.mass * turn @ box_tensor(*sides) @ turn.T, 4e-15)


@pytest.mark.parametrize("turn", [None, rotation(5)])
@pytest.mark.parametrize("extents", [(1, 1e-4, 1e-4), (1, 1, 1e-6), (1, 1e-3, 1e-5)])
def test_thin_parts(turn, extents):
    part = part_from_mesh(*moved(shapes.box(*extents), turn))
    assert part.warnings == ()
    assert np.linalg.eigvalsh(part.inertia)[0] == pytest.approx(
        (extents[1] ** 2 + extents[2] ** 2) / 12, rel=1e-3
    )
