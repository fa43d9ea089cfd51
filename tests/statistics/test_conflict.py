"""Drops that contradict an estimate."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats.statistics.posterior import PosePrior
from ros_pose_stats.statistics.posterior.conflict import FALSE_ALARMS

TIMES = 1000
ESTIMATE = (0.4, 0.3, 0.15, 0.1, 0.05)
OFF = (0.2, -0.1, -0.1, 0.0, 0.0)


def told_prior(rng):
    """A prior, and a truth as far from its estimate as its error says."""
    poses = int(rng.integers(2, 15))
    estimate, told = rng.dirichlet(np.full(poses, 0.5)), math.exp(rng.uniform(-5.8, -2.8))
    worth = float(np.mean(estimate * (1.0 - estimate))) / told ** 2 - 1.0
    return (PosePrior(estimate, np.arange(poses), told, 0.5),
            rng.dirichlet(max(worth, 1.0) * estimate + 1e-9))


@pytest.mark.parametrize("drops", [10, 300, 10_000])
def test_false_alarms_are_as_rare_as_they_say(drops):
    """Two thousandths of 1000 parts are 2; three standard errors more are 6."""
    rng, alarms = np.random.default_rng(4), 0
    for _ in range(TIMES):
        prior, true = told_prior(rng)
        alarms += bool(prior.contradicted(rng.multinomial(drops, true)).any())
    expected = TIMES * FALSE_ALARMS
    assert alarms <= expected + 3.0 * math.sqrt(expected)


def test_an_estimate_off_by_far_more_than_it_says_is_refuted():
    """Told one point, off by twenty in the first pose and by ten in two others."""
    prior = PosePrior(ESTIMATE, range(5), 0.01, 0.5)
    counts = 1000 * (np.add(ESTIMATE, OFF))
    assert prior.contradicted(counts.round()).tolist() == [True, True, True, False, False]


def test_as_far_off_with_an_error_as_large_is_none():
    prior = PosePrior(ESTIMATE, range(5), 0.15, 0.5)
    counts = 1000 * (np.add(ESTIMATE, OFF))
    assert not prior.contradicted(counts.round()).any()


def test_poses_that_symmetry_makes_equal_are_named_together():
    prior = PosePrior((0.4, 0.4, 0.2), (0, 0, 1), 0.005, 0.5)
    assert prior.contradicted((100, 100, 800)).all()


@pytest.mark.parametrize("counts", [(0, 0, 0, 0, 0), (1, 0, 0, 0, 0), (0, 0, 0, 0, 1)])
def test_a_drop_or_none_refutes_nothing(counts):
    assert not PosePrior(ESTIMATE, range(5), 0.02, 0.5).contradicted(counts).any()


def test_an_estimate_without_a_known_error_cannot_be_refuted():
    prior = PosePrior(ESTIMATE, range(5), math.nan, 0.5)
    assert not prior.contradicted((0, 0, 0, 500, 500)).any()
    assert not PosePrior((1.0,), (0,), 0.0, 0.5).contradicted((50,)).any()
