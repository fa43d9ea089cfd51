"""Bodies of every family: the same ones again, rigid bodies, and what the family promises."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.resting.poses import resting_poses
from training.families import FAMILIES, family_part, family_tolerance


@pytest.mark.parametrize("family", FAMILIES)
def test_bodies(family):
    for number in (0, 7):
        part = family_part(family, 5, number)
        assert part.digest == family_part(family, 5, number).digest
        resting = resting_poses(part, family_tolerance(family))
        assert len(resting.poses) > 1
        assert resting.body.arrays.distance.min() > 0.0  # the centre of mass lies inside
        low, middle, high = np.linalg.eigvalsh(resting.inertia)
        assert low > 0.0 and high <= low + middle
    assert part.digest != family_part(family, 5, 0).digest
    assert part.digest != family_part(family, 6, 7).digest


def hull_corners(family, count=12):
    return [len(resting_poses(family_part(family, 5, number)).body.points)
            for number in range(count)]


def test_fine_families_have_many_corners():
    assert min(hull_corners("fine rounds")) >= 2 * 32
    assert min(hull_corners("fine ellipsoids")) >= 90
    assert max(hull_corners("lumps")) > 300 and max(hull_corners("ellipsoids")) <= 60


def test_turned_parts_are_round():
    """Two of their principal moments are the same."""
    for family in ("rounds", "fine rounds"):
        for number in range(6):
            moments = np.linalg.eigvalsh(resting_poses(family_part(family, 5, number)).inertia)
            assert min(np.diff(moments)) < 1e-9
