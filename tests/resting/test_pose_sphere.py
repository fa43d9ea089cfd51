"""The maps of the sphere of poses."""

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.resting.pose_sphere import on_map, pose_sphere
from ros_pose_stats.shapes.closed_forms import box
from tests.bodies import random_polyhedron


@pytest.fixture(scope="module")
def sphere():
    return pose_sphere(resting_poses(part_from_mesh(*box(0.04, 0.03, 0.02))), 64)


def test_directions_are_unit_vectors_of_the_right_half(sphere):
    inside = np.isfinite(sphere.directions[..., 0])
    assert np.linalg.norm(sphere.directions[inside], axis=1) == pytest.approx(1.0)
    assert (sphere.directions[0][inside[0]][:, 2] <= 1e-12).all()
    assert (sphere.directions[1][inside[1]][:, 2] >= -1e-12).all()
    assert inside.mean() == pytest.approx(np.pi / 4.0, rel=0.02)


def test_places_on_the_page_are_those_of_the_pixels(sphere):
    middle = (2.0 * np.arange(64) + 1.0) / 64 - 1.0
    for half in range(2):
        rows, columns = np.nonzero(np.isfinite(sphere.directions[half][..., 0]))
        hemisphere, place = on_map(sphere.directions[half][rows, columns])
        assert (hemisphere == half).all()
        assert place == pytest.approx(np.stack([middle[columns], middle[rows]], axis=1))


def test_r_and_R_of_a_box_are_those_of_its_formulas(sphere):
    inside = np.isfinite(sphere.r)
    u = np.abs(sphere.directions[inside])
    half = np.array([0.02, 0.015, 0.01])
    with np.errstate(divide="ignore"):
        assert sphere.r[inside] == pytest.approx((half / u).min(axis=1))
    assert sphere.R[inside] == pytest.approx(u @ half)


def test_basins_of_a_box_are_the_solid_angles_of_its_faces(sphere):
    shares = np.bincount(sphere.pose[sphere.pose >= 0], minlength=6) / (sphere.pose >= 0).sum()
    a, b, c = 0.02, 0.015, 0.01
    for index, (x, y, z) in ((0, (a, b, c)), (4, (b, c, a))):
        angle = 4.0 * np.arctan(x * y / (z * np.sqrt(x * x + y * y + z * z)))
        assert shares[index] == pytest.approx(angle / (4.0 * np.pi), abs=0.01)


def test_r_is_nowhere_above_R_and_the_poses_are_its_lowest_points():
    resting = resting_poses(part_from_mesh(*random_polyhedron(14, 5)))
    found = pose_sphere(resting, 80)
    inside = np.isfinite(found.r)
    assert (found.r[inside] <= found.R[inside] * (1.0 + 1e-12)).all()
    body = resting.body
    for pose, down in zip(resting.poses, found.downs, strict=True):
        assert body.R(down) * body.radius == pytest.approx(pose.height)
    assert set(np.unique(found.pose)) <= {-1, *range(len(resting.poses))}
