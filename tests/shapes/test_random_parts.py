"""Random machined and turned parts are closed solids, and no two are the same."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.shapes.random_parts import KINDS, random_part


@pytest.mark.parametrize("number", range(2 * len(KINDS)))
def test_a_part_is_a_closed_solid_with_few_poses(number):
    vertices, triangles = random_part(3, number)
    body = trimesh.Trimesh(vertices, triangles, process=False)
    assert body.is_watertight and body.is_winding_consistent
    assert body.volume > 0.0
    assert 5.0 < np.ptp(vertices, axis=0).max() < 150.0
    part = part_from_mesh(vertices, triangles, unit="mm")
    assert part.center_of_mass * 1e3 == pytest.approx(body.center_mass, abs=1e-3)
    assert 2 <= len(resting_poses(part).poses) <= 24


def test_equal_arguments_give_the_same_part_and_others_another():
    one, again, other = random_part(3, 0), random_part(3, 0), random_part(4, 0)
    assert np.array_equal(one[0], again[0]) and np.array_equal(one[1], again[1])
    assert one[0].shape != other[0].shape or not np.array_equal(one[0], other[0])
