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

"""Meshes that were not made for this project, where they are at hand: a sober answer to
each.
"""

from pathlib import Path

import numpy as np
import pytest

import ros_pose_stats
from ros_pose_stats import estimate_all, load_part, resting_poses
from tests.matching import values

FOLDER = Path(ros_pose_stats.__file__).resolve().parents[2] / "shared" / "meshes"

pytestmark = pytest.mark.skipif(
    not FOLDER.is_dir(), reason="no meshes beside the repository"
)

EXPECTED = {
    # name: (unit, stable poses, most probable pose at least, warnings)
    "featuretype.STL": ("inch", 5, 0.4, set()),
    "angle_block.STL": ("inch", 6, 0.25, set()),
    "plate_holes.STL": ("mm", 2, 0.45, set()),
    "cylinder.stl": ("mm", 3, 0.9, {"CLUSTERED"}),
    "round.stl": ("mm", 3, 0.95, {"CLUSTERED"}),
    "ariac_sensor_collision.stl": ("m", 5, 0.2, {"ROUNDED"}),
    "soup.stl": ("mm", None, 0.05, {"OPEN_MESH"}),
    "multibody.stl": ("mm", None, 0.2, {"BODIES_LOOSE"}),
    "wallhole.obj": ("mm", None, 0.1, set()),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_each_file(name):
    if not (FOLDER / name).is_file():
        pytest.skip(f"{name} is not there")
    unit, count, best, warnings = EXPECTED[name]
    part = load_part(FOLDER / name, unit=unit, body="all")
    for answer in estimate_all(part):
        probability = values(answer.poses, "probability")
        assert count is None or len(probability) == count
        assert probability.sum() == pytest.approx(1.0, abs=1e-12)
        assert probability.min() >= 0.0
        assert {warning.code for warning in answer.warnings} >= warnings
        if answer.method in ("meae", "combined"):
            assert probability[0] > best
    for pose in resting_poses(part, round_sides=0).poses:
        along = (part.surface_vertices - part.center_of_mass) @ pose.down
        assert along.max() == pytest.approx(pose.height, abs=3e-6 * answer.radius)
        assert np.ptp(along) == pytest.approx(pose.top, abs=3e-6 * answer.radius)
        assert pose.barrier > 0.0
