"""A part whose centre of mass is shifted is the part that is loaded with that centre."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes, shift_center
from ros_pose_stats.errors import MassPropertiesError
from ros_pose_stats.mesh.hull import hull_of_part
from tests.bodies import random_polyhedron

OFFSET = np.array([0.02, -0.03, 0.01])


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(12, seed=4), mass=2.0, part_id="stone")


def test_it_is_the_part_that_is_given_this_centre(part):
    shifted = shift_center(part, OFFSET)
    given = part_from_mesh(part.vertices, part.triangles, part.center_of_mass + OFFSET, 2.0,
                           part_id="stone")
    assert shifted.digest == given.digest != part.digest
    assert np.array_equal(shifted.inertia, part.inertia)
    assert (shifted.part_id, shifted.warnings) == (given.part_id, given.warnings)
    for mine, other in zip(estimate(shifted).poses, estimate(given).poses, strict=True):
        assert mine.probability == other.probability
        assert np.array_equal(mine.down, other.down)


def test_the_hull_is_the_same_object(part):
    assert hull_of_part(shift_center(part, OFFSET)) is hull_of_part(part)


def test_no_shift_is_the_part_itself(part):
    assert shift_center(part, (0.0, 0.0, 0.0)) is part


def test_there_and_back(part):
    back = shift_center(shift_center(part, OFFSET), -OFFSET)
    assert back.center_of_mass == pytest.approx(part.center_of_mass, abs=1e-16)


@pytest.mark.parametrize("offset", [
    (np.nan, 0.0, 0.0), (0.0, np.inf, 0.0), (0.0, 0.0), "up", None, [[0.0, 0.0, 0.0]]])
def test_what_is_no_shift_is_refused(part, offset):
    with pytest.raises(MassPropertiesError, match="a shift of the centre of mass of three"):
        shift_center(part, offset)


@pytest.mark.parametrize("offset", [(0.6, 0.0, 0.0), (0.5, 0.0, 0.0), (1e30, 0.0, 0.0)])
def test_a_centre_out_of_the_hull_is_refused_as_a_given_one_is(offset):
    cube = part_from_mesh(*shapes.box(1.0, 1.0, 1.0))
    with pytest.raises(MassPropertiesError) as refused:
        shift_center(cube, offset)
    with pytest.raises(MassPropertiesError) as given:
        part_from_mesh(cube.vertices, cube.triangles, cube.center_of_mass + np.array(offset))
    assert str(refused.value) == str(given.value)
