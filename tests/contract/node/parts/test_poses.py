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

"""What a StablePose says about the part at rest, checked on the mesh itself."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from lab.bodies.samples import clamp_hull
from lab.bodies.variants import moved, rotation

from ..harness.parts import WEDGE, flat, library_part, new_id

SURFACES = {
    "wedge": WEDGE,
    "away from the origin": moved(WEDGE, rotation(3), (0.3, -0.7, 0.2)),
    "clamp": moved(clamp_hull(), scale=0.001),
}
NEAR = 1e-9
"""Metres; of parts of some centimetres, a metre from the origin."""


def array(vector):
    return np.array([vector.x, vector.y, vector.z])


def turn_of(pose):
    turn = pose.pose.orientation
    return Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])


def at_rest(pose, points):
    """Points of the part in the plate frame."""
    return turn_of(pose).apply(points) + array(pose.pose.position)


def area(polygon):
    """Signed; positive if counter-clockwise."""
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.fixture(params=SURFACES)
def surface(request):
    return SURFACES[request.param]


@pytest.fixture
def poses(cell, surface):
    return cell.good("estimate", part=flat(surface, new_id())).statistics.poses


def test_the_lowest_point_is_on_the_plate_and_the_centre_above_the_origin(
    poses, surface
):
    centre = library_part(surface).center_of_mass
    for pose in poses:
        z = at_rest(pose, surface[0])[:, 2]
        assert (z.min(), z.max()) == pytest.approx((0.0, pose.top), abs=NEAR)
        np.testing.assert_allclose(
            at_rest(pose, centre), (0.0, 0.0, pose.height), atol=NEAR
        )


def test_down_points_down_by_the_smallest_rotation(poses):
    for pose in poses:
        np.testing.assert_allclose(
            turn_of(pose).apply(array(pose.down)), (0, 0, -1), atol=NEAR
        )
        angle = np.arctan2(np.hypot(pose.down.x, pose.down.y), -pose.down.z)
        assert turn_of(pose).magnitude() == pytest.approx(angle, abs=1e-7)


def test_numbers_rise_with_the_height_and_the_most_probable_comes_first(poses):
    by_index = sorted(poses, key=lambda pose: pose.index)
    assert [pose.index for pose in by_index] == list(range(len(poses)))
    assert np.all(np.diff([pose.height for pose in by_index]) > -1e-6)
    chances = [pose.probability for pose in poses]
    assert np.all(np.diff(chances) < NEAR) and sum(chances) == pytest.approx(1.0)


def test_support_polygon_is_the_contact_and_outline_the_silhouette(poses, surface):
    for pose in poses:
        resting = at_rest(pose, surface[0])
        silhouette = ConvexHull(resting[:, :2]).volume
        assert area(np.reshape(pose.outline, (-1, 2))) == pytest.approx(silhouette)
        support = np.reshape(pose.support_polygon, (-1, 2))
        contact = ConvexHull(resting[resting[:, 2] < NEAR][:, :2]).volume
        assert area(support) == pytest.approx(contact)
        ends = np.roll(
            support, -1, axis=0
        )  # it holds the point below the centre of mass
        assert np.all(support[:, 0] * ends[:, 1] - support[:, 1] * ends[:, 0] > 0.0)
