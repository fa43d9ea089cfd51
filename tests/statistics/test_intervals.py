"""Jeffreys intervals against scipy's beta distribution and by their coverage."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta, binom, binomtest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.intervals import jeffreys_interval


@pytest.mark.parametrize("total", [1, 7, 100, 12345, 10_000_000])
@pytest.mark.parametrize("level", [0.5, 0.9, 0.99])
def test_quantiles_of_the_beta_distribution(total, level):
    count = np.unique(np.linspace(1, total - 1, 9).astype(int)) if total > 1 else np.array([])
    low, high = jeffreys_interval(count, total, level)
    posterior = beta(count + 0.5, total - count + 0.5)
    np.testing.assert_allclose(low, posterior.ppf((1 - level) / 2), rtol=1e-9)
    np.testing.assert_allclose(high, posterior.isf((1 - level) / 2), rtol=1e-9)


def test_the_ends_are_closed():
    low, high = jeffreys_interval([0, 50, 0], [50, 50, 0])
    assert low.tolist() == [0.0, pytest.approx(beta.ppf(0.05, 50.5, 0.5)), 0.0]
    assert high.tolist() == [pytest.approx(beta.isf(0.05, 0.5, 50.5)), 1.0, 1.0]


def test_mean_coverage_is_the_level():
    # Exactly, over all outcomes of 100 drops; the mean over the truth, as Brown et al. figure 5.
    low, high = jeffreys_interval(np.arange(101), 100)
    truth = (np.arange(1000) + 0.5) / 1000
    inside = (low[:, None] <= truth) & (truth <= high[:, None])
    coverage = (inside * binom.pmf(np.arange(101)[:, None], 100, truth)).sum(axis=0)
    assert coverage.mean() == pytest.approx(0.9, abs=0.005)
    assert coverage.min() > 0.8


@pytest.mark.parametrize("count", [0, 3, 20, 50, 99])
def test_between_nothing_and_the_exact_interval(count):
    # Clopper-Pearson is wider for certain: it may never cover too little.
    low, high = jeffreys_interval(count, 100)
    exact = binomtest(count, 100).proportion_ci(0.9, "exact")
    assert exact.low <= low <= count / 100 <= high <= exact.high


@given(st.integers(0, 10_000_000), st.integers(0, 10_000_000),
       st.floats(1 / 64, 4.0), st.floats(0.01, 0.99))
def test_effective_totals(count, rest, factor, level):
    low, high = jeffreys_interval(count / factor, (count + rest) / factor, level)
    assert 0.0 <= low <= high <= 1.0
    if count and rest and count + rest > 40 * factor and level > 0.5:
        assert low < count / (count + rest) + 0.02
        assert high > count / (count + rest) - 0.02


@given(st.integers(1, 10_000), st.integers(1, 10_000))
def test_mirrored(count, rest):
    low, high = jeffreys_interval([count, rest], count + rest)
    np.testing.assert_allclose(low, 1.0 - high[::-1], atol=1e-12)


def test_shapes():
    low, high = jeffreys_interval(np.zeros((3, 1)), np.full(4, 9.0))
    assert low.shape == high.shape == (3, 4)
    assert float(jeffreys_interval(3, 10)[0]) < 0.3


@pytest.mark.parametrize(("count", "total", "level"), [
    (5, 4, 0.9), (-1, 4, 0.9), (float("nan"), 4, 0.9), (1, float("inf"), 0.9),
    (1, 4, 0.0), (1, 4, 1.0), ([1, 5], [4, 4], 0.9),
])
def test_refused(count, total, level):
    with pytest.raises(RequestError, match="expected"):
        jeffreys_interval(count, total, level)
