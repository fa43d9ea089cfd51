"""What a StablePose says about the part at rest, checked on the mesh itself."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ros_pose_stats import shapes
from tests.bodies import clamp_hull, moved, random_polyhedron, rotation

from ..harness.parts import WEDGE, flat, library_part, new_id

SURFACES = {
    "wedge": WEDGE,
    "away from the origin": moved(WEDGE, rotation(3), (0.3, -0.7, 0.2)),
    "random": moved(random_polyhedron(14, 5), scale=0.02),
    "prism": shapes.prism(6, 0.01, 0.03),
    "clamp": moved(clamp_hull(), scale=0.001),
}


def array(vector):
    return np.array([vector.x, vector.y, vector.z])


@pytest.fixture(params=SURFACES)
def surface(request):
    return SURFACES[request.param]


@pytest.fixture
def poses(cell, surface):
    return cell.good("estimate", part=flat(surface, new_id())).statistics.poses


def at_rest(pose, points):
    """Points of the part in the plate frame."""
    turn = pose.pose.orientation
    matrix = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    return points @ matrix.T + array(pose.pose.position)


def area(polygon):
    """Signed; positive if counter-clockwise."""
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_the_lowest_point_is_on_the_plate_and_the_centre_above_the_origin(poses, surface):
    center = library_part(surface).center_of_mass
    for pose in poses:
        z = at_rest(pose, surface[0])[:, 2]
        assert z.min() == pytest.approx(0.0, abs=1e-9)
        assert z.max() == pytest.approx(pose.top, abs=1e-9)
        np.testing.assert_allclose(at_rest(pose, center), (0.0, 0.0, pose.height), atol=1e-9)


def test_down_points_down_by_the_smallest_rotation(poses):
    for pose in poses:
        turn = pose.pose.orientation
        rotation = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])
        np.testing.assert_allclose(rotation.apply(array(pose.down)), (0, 0, -1), atol=1e-9)
        angle = np.arccos(np.clip(-pose.down.z, -1.0, 1.0))
        assert rotation.magnitude() == pytest.approx(angle, abs=1e-6)


def test_numbers_rise_with_the_height_and_the_most_probable_comes_first(poses):
    by_index = sorted(poses, key=lambda pose: pose.index)
    assert [pose.index for pose in by_index] == list(range(len(poses)))
    assert np.all(np.diff([pose.height for pose in by_index]) > -1e-6)
    chances = [pose.probability for pose in poses]
    assert np.all(np.diff(chances) < 1e-9)
    assert sum(chances) == pytest.approx(1.0)


def test_support_polygon_is_the_contact_and_holds_the_centre(poses, surface):
    for pose in poses:
        polygon = np.array(pose.support_polygon).reshape(-1, 2)
        assert area(polygon) > 0.0
        touching = at_rest(pose, surface[0])
        touching = touching[touching[:, 2] < 1e-9][:, :2]
        assert area(polygon) == pytest.approx(ConvexHull(touching).volume, rel=1e-6)
        ends = np.roll(polygon, -1, axis=0)
        assert np.all(polygon[:, 0] * ends[:, 1] - polygon[:, 1] * ends[:, 0] > 0.0)


def test_outline_is_the_silhouette(poses, surface):
    for pose in poses:
        outline = np.array(pose.outline).reshape(-1, 2)
        silhouette = ConvexHull(at_rest(pose, surface[0])[:, :2])
        assert area(outline) == pytest.approx(silhouette.volume, rel=1e-6)
