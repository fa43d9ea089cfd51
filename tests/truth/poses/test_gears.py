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

"""The teeth of a gear are one surface, whatever the shape of their tips."""

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold

from lab.bodies import exports, gears
from lab.bodies.fine_parts import surface
from lab.bodies.variants import in_float32, moved, rotation
from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.core.shapes.profiles import unit_circle


def poses_of(body):
    return resting_poses(part_from_mesh(*body, unit="mm")).poses


@pytest.mark.parametrize(("teeth", "keyway"), [(15, 0.0), (16, 0.0), (20, 1.5)])
def test_a_gear_with_a_boss_has_two_faces_and_two_ways_to_roll(teeth, keyway):
    """On its teeth alone, or leaning on its boss."""
    poses = poses_of(gears.gear(teeth, keyway=keyway))
    assert sorted(pose.rolls for pose in poses) == [False, False, True, True]
    assert sorted(abs(pose.down[2]) > 0.99 for pose in poses if not pose.rolls)
    upright, leaning = (pose for pose in poses if pose.rolls)
    assert abs(upright.down[2]) < 1e-4
    assert 0.4 < leaning.down[2] < 0.6
    assert min(len(upright.members), len(leaning.members)) >= 2 * teeth


def test_a_gear_without_a_boss_has_three_poses():
    assert len(poses_of(gears.gear(20, boss=0.0))) == 3


def test_a_turned_gear_in_float32():
    body = in_float32(moved(gears.gear(20), rotation(2), (30.0, 5.0, -8.0)))
    assert sorted(pose.rolls for pose in poses_of(body)) == [False] * 2 + [True] * 2


def test_where_a_tooth_is_missing_a_gear_stays():
    """Over 36 degrees it rests on the two tips beside the gap, whose rise is 5 %."""
    poses = poses_of(gears.gear(20, missing=(4,)))
    assert len(poses) == 5
    middle = 4 * 2.0 * np.pi / 20
    outward = np.array([np.cos(middle), np.sin(middle), 0.0])
    gap = max(poses, key=lambda pose: pose.down @ outward)
    assert gap.down @ outward > 0.9999
    assert len(gap.members) == 1
    assert not any(pose.rolls for pose in poses)


def test_gears_of_different_pitch_on_a_shaft_stay_two_runs():
    body = resting_poses(part_from_mesh(*gears.double_gear(20, 30, 0.95))).body
    height = [body.polygon(face)[:, 2] for face in range(body.faces)]
    middle = np.mean([body.points[:, 2].min(), body.points[:, 2].max()])
    on_first = np.array([z.max() < middle for z in height])
    on_second = np.array([z.min() > middle for z in height])
    strips = [set(body.run_of_face[on].tolist()) for on in (on_first, on_second)]
    on_both = set(body.run_of_face[~on_first & ~on_second].tolist())
    assert on_both - {-1}
    assert not (strips[0] & strips[1]) - {-1}
    assert not (on_both & (strips[0] | strips[1])) - {-1}


def on_a_boss(section, length=4.0):
    """A prism about a round boss that reaches beyond both ends."""
    prism = Manifold.extrude(CrossSection([section]), length)
    boss = Manifold.cylinder(length + 1.0, 4.0, 4.0, 96)
    return surface(prism + boss.translate((0.0, 0.0, -0.5)))


@pytest.mark.parametrize("sides", [6, 8, 12, 14])
def test_sides_of_a_prism_about_a_boss_stay(sides):
    poses = poses_of(on_a_boss(10.0 * unit_circle(sides)))
    assert sum(abs(pose.down[2]) < 0.1 for pose in poses) == sides


def test_a_cam_about_a_boss_keeps_its_sides():
    """Its axes are 5 % apart."""
    poses = poses_of(on_a_boss(10.0 * unit_circle(60) * (1.0, 0.95)))
    sides = [pose for pose in poses if abs(pose.down[2]) < 0.1]
    assert [round(abs(pose.down[1])) for pose in sides] == [1, 1]
    assert not any(pose.rolls for pose in sides)


def test_lobes_of_different_depth_stay():
    """Of twenty tips every fourth is 4 % lower: three others make no run of teeth."""
    angles = exports.circle(60)
    radius = np.tile([9.0, 9.0, 10.0], 20)
    radius[2::12] = 9.6
    section = radius[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    sides = [p for p in poses_of(on_a_boss(section)) if abs(p.down[2]) < 0.1]
    assert len(sides) == 15
