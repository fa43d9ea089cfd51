"""Elementary functions against the C library's, which are right to a unit in the last place."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats.kernels.elementary import (
    arctangent,
    exponential,
    logarithm,
    logarithms,
    rough_root,
    sine_cosine,
    sines_cosines,
)

COUNT = 2000


def units_off(found, right, size=None):
    """Largest difference in units in the last place of the right value (or of a given size)."""
    spacing = np.spacing(np.abs(right) if size is None else size)
    return float(np.max(np.abs(np.asarray(found) - right) / spacing))


@pytest.mark.parametrize("span", [1e-3, 1.0, 100.0, 1e6])
def test_sine_and_cosine(span):
    angles = np.random.default_rng(1).uniform(-span, span, COUNT)
    sines, cosines = sines_cosines(angles)
    # A zero of the sine is known as well as the angle there.
    assert units_off(sines, np.sin(angles), np.maximum(np.abs(np.sin(angles)), 1e-3)) <= 2.0
    assert units_off(cosines, np.cos(angles), np.maximum(np.abs(np.cos(angles)), 1e-3)) <= 2.0
    assert sine_cosine(float(angles[0])) == (sines[0], cosines[0])


def test_quarters_of_a_turn():
    for k, (sine, cosine) in enumerate([(0, 1), (1, 0), (0, -1), (-1, 0), (0, 1)]):
        assert sine_cosine(k * math.pi / 2) == pytest.approx((sine, cosine), abs=1e-15)
        assert sine_cosine(-k * math.pi / 2) == pytest.approx((-sine, cosine), abs=1e-15)


def test_arctangent():
    random = np.random.default_rng(2)
    points = random.normal(size=(COUNT, 2)) * 10.0 ** random.uniform(-8.0, 8.0, (COUNT, 2))
    found = [arctangent(y, x) for y, x in points.tolist()]
    assert units_off(found, np.arctan2(*points.T)) <= 2.0


@pytest.mark.parametrize(("y", "x", "angle"), [
    (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, math.pi / 2), (0.0, -1.0, math.pi),
    (-1.0, 0.0, -math.pi / 2), (1.0, 1.0, math.pi / 4), (-1.0, -1.0, -3.0 * math.pi / 4),
])
def test_arctangent_on_axes_and_between(y, x, angle):
    assert arctangent(y, x) == pytest.approx(angle, abs=1e-15)


@pytest.mark.parametrize(("y", "x"), [(math.nan, 1.0), (1.0, math.nan), (math.inf, math.inf)])
def test_arctangent_of_no_point(y, x):
    """Where a drop has left the numbers, NaN goes on, and nothing is raised."""
    assert math.isnan(arctangent(y, x))


def test_exponential_and_logarithm():
    powers = np.random.default_rng(3).uniform(-708.0, 709.0, COUNT)
    assert units_off([exponential(x) for x in powers.tolist()], np.exp(powers)) <= 2.0
    for values in (np.exp(powers), np.random.default_rng(4).uniform(0.5, 2.0, COUNT)):
        found = logarithms(values)
        assert units_off(found, np.log(values)) <= 2.0
        assert found[0] == logarithm(float(values[0]))
    assert (exponential(0.0), logarithm(1.0)) == (1.0, 0.0)
    assert (exponential(-1e9), exponential(1e9)) == (0.0, math.inf)


def test_rough_root():
    values = 10.0 ** np.random.default_rng(5).uniform(-300.0, 300.0, COUNT)
    for order in (1, 2, 3, 16):
        found = np.array([rough_root(x, order) for x in values.tolist()])
        assert np.abs(found / values ** (1.0 / order) - 1.0).max() < 1e-5
