"""The error that an estimate says is to be expected of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.fit_expected_errors import expected_errors
from ros_pose_stats import estimate_all, part_from_mesh
from ros_pose_stats.estimators.coefficients import EXPECTED_AT, EXPECTED_ERRORS
from ros_pose_stats.estimators.expected import expected_error
from ros_pose_stats.estimators.registry import ESTIMATORS
from ros_pose_stats.geometry.shapes import box


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*box(0.01, 0.02, 0.03))


def test_every_method_has_one_and_tells_it(part):
    assert EXPECTED_ERRORS.keys() == ESTIMATORS.keys()
    for restitution, place in zip(EXPECTED_AT, range(3), strict=True):
        for found in estimate_all(part, restitution=restitution):
            assert found.expected_error == EXPECTED_ERRORS[found.method][place]


def test_between_and_beyond_the_measured_restitutions():
    low, middle, high = EXPECTED_ERRORS["meae"]
    assert expected_error("meae", 0.35, 5) == pytest.approx(0.5 * (low + middle))
    assert expected_error("meae", 0.0, 5) == low and expected_error("meae", 0.95, 5) == high
    assert math.isnan(expected_error("unheard of", 0.5, 5))


def test_a_single_pose_is_certain():
    assert all(expected_error(name, 0.5, 1) == 0.0 for name in ESTIMATORS)


def test_they_are_what_the_benchmark_measures():
    """To the digits in the source."""
    for name, errors in expected_errors().items():
        np.testing.assert_allclose(EXPECTED_ERRORS[name], errors, atol=5.001e-4)
