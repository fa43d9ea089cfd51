"""Differences of paired shares, against scipy's exact test, plain formulas and simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.paired_counts import (
    adjust_together,
    chance_of_split,
    difference_of_counts,
    paired_difference,
)


def pairs(seed, trials, both, first_only, second_only):
    """Outcomes of trials in which both, the first or the second happens so often."""
    kind = np.random.default_rng(seed).choice(
        4, size=trials, p=(both, first_only, second_only, 1.0 - both - first_only - second_only))
    return (kind == 0) | (kind == 1), (kind == 0) | (kind == 2)


@pytest.mark.parametrize(("gained", "lost"), [(0, 0), (3, 9), (40, 40), (120, 77), (1, 0)])
def test_the_chance_is_that_of_a_fair_coin(gained, lost):
    expected = stats.binomtest(gained, gained + lost).pvalue if gained + lost else 1.0
    assert chance_of_split(gained, lost) == pytest.approx(expected, rel=1e-12)


def test_the_standard_error_is_that_of_the_mean_of_differences():
    first, second = pairs(1, 5000, 0.3, 0.02, 0.05)
    found = paired_difference(first, second)
    single = second.astype(float) - first.astype(float)
    assert found.value == pytest.approx(single.mean(), abs=1e-15)
    assert found.standard_error == pytest.approx(single.std() / math.sqrt(5000), rel=1e-12)
    assert (found.gained, found.lost) == (int((single > 0).sum()), int((single < 0).sum()))


def test_what_both_have_in_common_cancels():
    first, second = pairs(2, 4000, 0.5, 0.005, 0.005)
    apart = math.sqrt(2.0 * 0.25 / 4000)
    assert paired_difference(first, second).standard_error < 0.2 * apart


@pytest.mark.parametrize(("trials", "kinds"), [(60, (0.2, 0.1, 0.15)), (400, (0.3, 0.01, 0.02))])
def test_the_interval_covers_the_difference_as_often_as_it_says(trials, kinds):
    truth, runs = kinds[2] - kinds[1], 2000
    covered = 0
    for seed in range(runs):
        found = paired_difference(*pairs(seed, trials, *kinds))
        covered += found.low <= truth <= found.high
    # 90 % but for four standard errors; the interval of few discordant pairs is a little wide.
    assert 0.9 - 4.0 * math.sqrt(0.09 / runs) <= covered / runs <= 0.97


def test_without_trials_nothing_is_known():
    found = difference_of_counts(0, 0, 0)
    assert math.isnan(found.value)
    assert (found.low, found.high, found.p_value) == (-1.0, 1.0, 1.0)


def test_rows_of_different_length_are_refused():
    with pytest.raises(RequestError, match="equally long"):
        paired_difference([True, False], [True])


class TestHolm:
    def test_against_the_definition(self):
        # Holm's steps: 4 x 0.005, 3 x 0.01, 2 x 0.03, then no smaller than the one before.
        assert adjust_together([0.01, 0.04, 0.03, 0.005]) == pytest.approx(
            [0.03, 0.06, 0.06, 0.02])

    def test_none_stands_wrongly_more_often_than_one_in_twenty(self):
        chances = np.random.default_rng(3).uniform(size=(4000, 6))
        wrong = np.mean([adjust_together(row).min() <= 0.05 for row in chances])
        assert wrong <= 0.05 + 4.0 * math.sqrt(0.05 * 0.95 / 4000)

    def test_no_test_at_all(self):
        assert adjust_together([]).size == 0
