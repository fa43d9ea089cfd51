"""Wanted poses of which symmetry has more alike are told, and counted as they were named."""

from __future__ import annotations

import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes
from ros_pose_stats.statistics.wanted_poses import warn_of_alike


@pytest.fixture(scope="module")
def box():
    """Poses 0 and 1, 2 and 3, 4 and 5 are alike."""
    return estimate(part_from_mesh(*shapes.box(0.04, 0.03, 0.02)))


@pytest.fixture(scope="module")
def cube():
    return estimate(part_from_mesh(*shapes.box(0.02, 0.02, 0.02)))


def test_one_that_is_left_out(box):
    share = sum(pose.probability for pose in box.poses if pose.index in (0, 1))
    assert warn_of_alike(box, [0]) == (
        "WANTED_ALIKE: pose 1 looks the same as pose 0 (symmetry) and is not among the wanted "
        f"ones: {50 * share:.1f} % are accepted, with them {100 * share:.1f} %.",)


def test_several(box, cube):
    (line,) = warn_of_alike(cube, [2])
    assert line == ("WANTED_ALIKE: poses 0, 1, 3-5 look the same as pose 2 (symmetry) and are not "
                    "among the wanted ones: 16.7 % are accepted, with them 100.0 %.")
    (line,) = warn_of_alike(box, [5, 0])
    assert "pose 1 looks the same as pose 0 and pose 4 looks the same as pose 5 (symm" in line


@pytest.mark.parametrize("wanted", [[], [0, 1], [3, 2, 4, 5], range(6)])
def test_whole_groups_are_in_order(box, wanted):
    assert warn_of_alike(box, wanted) == ()
