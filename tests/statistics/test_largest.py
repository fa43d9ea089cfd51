"""The bound that the errors of all poses keep together, against distributions drawn from."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

from ros_pose_stats.statistics.largest import largest_error


def multinomial_errors(probability, drops, random, size=40_000):
    p = np.asarray(probability, dtype=float)
    return np.abs(random.multinomial(drops, p, size=size) / drops - p).max(axis=1)


@pytest.mark.parametrize("probability", [
    (0.5, 0.5), (0.9, 0.1), (0.5, 0.3, 0.2), (0.98, 0.01, 0.01), (1 / 6,) * 6,
    (0.4, 0.3, 0.2, 0.05, 0.03, 0.01, 0.01)])
@pytest.mark.parametrize("level", [0.5, 0.9, 0.99])
def test_against_counted_shares(probability, level):
    p, drops = np.array(probability), 3000
    found = largest_error(np.sqrt(p * (1.0 - p) / drops), level)
    true = multinomial_errors(p, drops, np.random.default_rng(1))
    assert np.mean(true <= found) == pytest.approx(level, abs=0.06 if level == 0.5 else 0.035)
    assert found == pytest.approx(np.quantile(true, level), rel=0.1)


def test_one_error_is_normal():
    assert largest_error([0.03], 0.9) == pytest.approx(0.03 * norm.ppf(0.95), rel=6e-3)
    assert largest_error([0.02, 0.02], 0.9) == pytest.approx(0.02 * norm.ppf(0.95), rel=6e-3)


def test_cases_are_mixed_and_a_shift_counts():
    random = np.random.default_rng(2)
    spread, weight = np.array([[0.01], [0.1]]), np.array([0.8, 0.2])
    which = random.random(200_000) < 0.2
    true = np.abs(random.normal(size=which.size) * np.where(which, 0.1, 0.01)
                  + np.where(which, 0.05, 0.0))
    found = largest_error(spread, 0.9, weight=weight, away=[[0.0], [0.05]])
    assert found == pytest.approx(np.quantile(true, 0.9), rel=0.02)


def test_poses_of_a_unit_share_its_error():
    alone = largest_error([0.03, 0.03], 0.9)
    assert largest_error([0.03, 0.03], 0.9, size=[3, 3]) == pytest.approx(alone / 3.0)


def test_ends():
    assert largest_error([0.0, 0.0], 0.9) == 0.0
    assert math.isnan(largest_error([math.nan, 0.1], 0.9))
    assert largest_error([5.0], 0.9) == largest_error([math.inf, 0.1], 0.9) == 1.0
    assert largest_error([0.2, 0.1, 0.0], 0.9) == largest_error([0.2, 0.1], 0.9)
