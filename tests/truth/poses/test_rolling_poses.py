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

"""A pose rolls where the part goes on by a quarter of a turn without rising.

It may lean meanwhile, as a bolt does whose thread touches the plate now here, now
there, and goes over teeth that its pose goes over.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lab.bodies import exports, threaded
from lab.bodies.variants import moved, rotation
from ros_pose_stats import part_from_mesh, resting_poses

TOLERANCE = 0.0025
TOOTH = 0.025


def shaft_with_flats(count, width=20.0):
    """A shaft whose flats are so many degrees wide, 1.5 % nearer to its axis."""
    half = np.radians(0.5 * width)
    arc = np.linspace(half, 2.0 * np.pi / count - half, 360 // count)
    angles = np.concatenate([arc + 2.0 * np.pi * k / count for k in range(count)])
    return exports.extruded(np.column_stack((np.cos(angles), np.sin(angles))), 3.0)


def lying(surface):
    """Poses of a part along z that lies on its side."""
    resting = resting_poses(part_from_mesh(*surface, unit="mm"))
    return resting, [pose for pose in resting.poses if abs(pose.down[2]) < 0.9]


def rise_over_quarter_turns(resting, pose):
    """Least rise with which the part gets round by 90 degrees either way.

    At each angle about z it leans as is best, within 3 degrees. The height has a single
    least value there, which thirds of the range close in on.
    """
    angle = np.radians(np.arange(-90.0, 91.0)) + np.arctan2(*pose.down[1::-1])

    def height(lean):
        across = np.sqrt(1.0 - lean * lean)
        downs = np.stack((across * np.cos(angle), across * np.sin(angle), lean), -1)
        return resting.body.R(downs) * resting.body.radius

    low = np.full(len(angle), pose.down[2] - 0.05)
    high = np.full(len(angle), pose.down[2] + 0.05)
    for _ in range(20):
        third = (high - low) / 3.0
        falls = height(low + third) > height(high - third)
        low = np.where(falls, low + third, low)
        high = np.where(falls, high, high - third)
    rise = height(low) / pose.height - 1.0
    # A quarter of a turn may be made partly one way and partly the other.
    return min(rise[k : k + 91].max() for k in range(91))


ROLLING = {
    "cap screw": (lambda: threaded.cap_screw(36, start=17.0), TOLERANCE),
    "left-handed cap screw": (lambda: threaded.cap_screw(24, hand=-1), TOLERANCE),
    "threadlike spring": (lambda: threaded.spring(48), TOLERANCE),
    "open spring": (lambda: threaded.spring(64, 6.0, 4.0), TOLERANCE),
    "gear": (lambda: exports.gear(20), TOOTH),
    "gear with pointed teeth": (lambda: exports.gear(16, 0.0), TOOTH),
    "gear with chamfers": (lambda: exports.gear(40, 0.3, chamfer=0.03), TOOTH),
}


@pytest.mark.parametrize(("make", "allowed"), ROLLING.values(), ids=ROLLING)
def test_what_rolls(make, allowed):
    resting, poses = lying(make())
    assert any(pose.rolls for pose in poses)
    for pose in poses:
        assert pose.rolls == (rise_over_quarter_turns(resting, pose) < allowed)
        if pose.rolls:
            along = Rotation.from_quat(pose.orientation).apply((0.0, 0.0, 1.0))
            assert np.linalg.norm(np.cross(pose.roll_axis, (*along[:2], 0.0))) < 0.02
            assert pose.roll_axis[2] == 0.0


HELD = {
    "flat": lambda: shaft_with_flats(1),
    "four flats": lambda: shaft_with_flats(4),
    "wide flat": lambda: exports.d_shaft(60),
    "hexagon head": lambda: threaded.bolt(36),
    "six sides": lambda: exports.gear(6),
}


@pytest.mark.parametrize("make", HELD.values(), ids=HELD)
def test_what_a_flat_holds(make):
    resting, poses = lying(make())
    for pose in {pose.group: pose for pose in poses}.values():
        assert rise_over_quarter_turns(resting, pose) > TOLERANCE
        assert not pose.rolls
        assert not pose.roll_axis.any()


@pytest.mark.parametrize("name", ["cap screw", "threadlike spring", "gear"])
def test_turned_copies_roll_alike(name):
    make, _ = ROLLING[name]
    surface = make()
    turn = rotation(4)
    plain = resting_poses(part_from_mesh(*surface, unit="mm")).poses
    turned = resting_poses(part_from_mesh(*moved(surface, turn), unit="mm")).poses
    assert [pose.rolls for pose in turned] == [pose.rolls for pose in plain]


def test_a_gear_holds_where_each_tooth_is_a_pose():
    part = part_from_mesh(*exports.gear(20), unit="mm")
    assert not any(pose.rolls for pose in resting_poses(part, 0.0).poses)
    assert not any(pose.rolls for pose in resting_poses(part, 0.0, 0).poses)
