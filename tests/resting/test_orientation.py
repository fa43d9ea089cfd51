"""The smallest rotation that brings a pose's `down` to -z."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ros_pose_stats.kernels.body.standing import POLE
from ros_pose_stats.resting.orientation import resting_quaternions, rotation_matrices
from ros_pose_stats.shapes import sphere_points

DOWN = np.array((0.0, 0.0, -1.0))


def resting(down):
    return resting_quaternions(np.atleast_2d(np.asarray(down, dtype=float)))[0]


def direction(tilt, azimuth):
    return np.array((np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth),
                     np.cos(tilt)))


class TestEveryDirection:
    def test_down_comes_to_lie_down(self):
        downs = sphere_points(2000, 5)
        turned = np.einsum("pij,pj->pi", rotation_matrices(resting_quaternions(downs)), downs)
        assert np.abs(turned - DOWN).max() < 1e-13

    def test_unit_quaternions_of_proper_rotations(self):
        quaternions = resting_quaternions(sphere_points(2000, 6))
        matrices = rotation_matrices(quaternions)
        assert np.linalg.norm(quaternions, axis=1) == pytest.approx(1.0, abs=1e-15)
        assert np.linalg.det(matrices) == pytest.approx(1.0, abs=1e-13)

    def test_no_smaller_rotation_does_it(self):
        downs = sphere_points(2000, 7)
        angle = Rotation.from_quat(resting_quaternions(downs)).magnitude()
        assert angle == pytest.approx(np.arccos(-downs[:, 2]), abs=1e-12)

    def test_matrices_are_those_of_scipy(self):
        quaternions = resting_quaternions(sphere_points(100, 8))
        assert rotation_matrices(quaternions) == pytest.approx(
            Rotation.from_quat(quaternions).as_matrix(), abs=1e-15)


def test_lying_already():
    assert resting(DOWN).tolist() == [0.0, 0.0, 0.0, 1.0]


def test_upside_down_is_a_half_turn_about_x():
    assert np.abs(resting(-DOWN)) == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-15)


@pytest.mark.parametrize(("down", "expected"), [
    ((1.0, 0.0, 0.0), (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))),
    ((0.0, 1.0, 0.0), (-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))),
])
def test_quarter_turns(down, expected):
    assert resting(down) == pytest.approx(expected, abs=1e-15)


@given(st.floats(-8.0, -2.0), st.floats(0.0, 6.3))
def test_near_upside_down_the_result_is_still_right(exponent, azimuth):
    down = direction(10.0**exponent, azimuth)
    matrix = rotation_matrices(resting(down)[None])[0]
    assert matrix @ down == pytest.approx(DOWN, abs=1e-9)


@given(st.floats(0.0, 0.9 * POLE), st.floats(0.0, 6.3))
def test_rounding_at_the_pole_does_not_turn_the_axis(tilt, azimuth):
    # All of these are the half turn about x, but for their own tilt.
    angle = Rotation.from_quat(resting(direction(tilt, azimuth))).inv() * Rotation.from_quat(
        (1.0, 0.0, 0.0, 0.0))
    assert angle.magnitude() <= POLE
