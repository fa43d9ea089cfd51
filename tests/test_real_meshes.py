"""Meshes that were not made for this project, where they are at hand: a sober answer to each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ros_pose_stats
from ros_pose_stats import PoseStatsError, estimate_all, load_part, resting_poses
from ros_pose_stats.resting.equilibria import equilibria
from tests.matching import values

FOLDER = Path(ros_pose_stats.__file__).resolve().parents[2] / "shared" / "meshes"

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="no meshes beside the repository")

EXPECTED = {
    # name: (unit, stable poses, most probable pose at least, warnings)
    "featuretype.STL": ("inch", 5, 0.4, set()),
    "angle_block.STL": ("inch", 6, 0.25, set()),
    "plate_holes.STL": ("mm", 2, 0.45, set()),
    "cylinder.stl": ("mm", 3, 0.9, {"CLUSTERED"}),
    "round.stl": ("mm", 3, 0.95, {"CLUSTERED"}),
    "ariac_sensor_collision.stl": ("m", 5, 0.2, {"ROUNDED"}),
    "soup.stl": ("mm", None, 0.05, {"OPEN_MESH"}),
    "multibody.stl": ("mm", None, 0.2, set()),
    "wallhole.obj": ("mm", None, 0.1, set()),
}


@pytest.mark.parametrize("name", EXPECTED)
class TestEachFile:
    @staticmethod
    def part(name):
        if not (FOLDER / name).is_file():
            pytest.skip(f"{name} is not there")
        return load_part(FOLDER / name, unit=EXPECTED[name][0])

    def test_answers(self, name):
        _, count, best, warnings = EXPECTED[name]
        for found in estimate_all(self.part(name)):
            probability = values(found.poses, "probability")
            assert count is None or len(probability) == count
            assert probability.sum() == pytest.approx(1.0, abs=1e-12)
            assert probability.min() >= 0.0
            assert {line.split(":")[0] for line in found.warnings} >= warnings
            if found.method in ("meae", "combined"):
                assert probability[0] > best

    def test_geometry(self, name):
        part = self.part(name)
        found = equilibria(part, 0)
        assert found.poincare_hopf == 2
        assert found.body.arrays.angle.sum() == pytest.approx(4.0 * np.pi, rel=1e-6)
        for pose in resting_poses(part, round_sides=0).poses:
            along = (part.surface_vertices - part.center_of_mass) @ pose.down
            assert along.max() == pytest.approx(pose.height, abs=3e-6 * found.body.radius)
            assert np.ptp(along) == pytest.approx(pose.top, abs=3e-6 * found.body.radius)
            assert pose.barrier > 0.0

    def test_a_wrong_centre_of_mass_is_refused(self, name):
        part = self.part(name)
        outside = part.surface_vertices.max(axis=0) * 2.0 + 1.0
        with pytest.raises(PoseStatsError, match="inside the part's convex hull"):
            load_part(FOLDER / name, unit=EXPECTED[name][0], center_of_mass=outside)
