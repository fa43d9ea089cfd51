"""Chi-square against scipy, by hand, and on data whose distribution is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.chi_square import (
    ChiSquare,
    goodness_of_fit,
    homogeneity,
    pooled_bins,
)


class TestGoodnessOfFit:
    def test_by_hand(self):
        # 60 throws of a die: (5² + 2² + 3² + 1² + 4² + 1²) / 10 = 5.6.
        found = goodness_of_fit([5, 8, 13, 9, 14, 11], [1 / 6] * 6)
        assert found.statistic == pytest.approx(5.6)
        assert (found.degrees_of_freedom, found.bins, found.pooled) == (5, 6, 0)
        assert found.p_value == pytest.approx(0.3471, abs=5e-5)
        assert not found.too_few

    @pytest.mark.parametrize("seed", range(5))
    def test_as_scipy(self, seed):
        rng = np.random.default_rng(seed)
        p = rng.dirichlet(np.full(6, 8.0))
        counts = rng.multinomial(900, p)
        other = rng.dirichlet(np.full(6, 200.0))
        found, known = goodness_of_fit(counts, other), stats.chisquare(counts, 900 * other)
        assert found.statistic == pytest.approx(known.statistic, rel=1e-12)
        assert found.p_value == pytest.approx(known.pvalue, rel=1e-9)

    def test_rare_bins_are_pooled_by_hand(self):
        # Expected 94, 3, 2, 1: the last three make one bin of 6.
        found = goodness_of_fit([90, 4, 4, 2], [0.94, 0.03, 0.02, 0.01])
        assert found.statistic == pytest.approx(16 / 94 + 16 / 6)
        assert (found.degrees_of_freedom, found.bins, found.pooled) == (1, 2, 3)

    def test_a_bin_of_probability_0_with_counts_is_pooled(self):
        found = goodness_of_fit([58, 40, 2], [0.6, 0.4, 0.0])
        assert found.statistic == pytest.approx(4 / 60 + 4 / 40)
        assert (found.bins, found.pooled) == (2, 2)

    def test_a_bin_of_probability_0_without_counts_says_nothing(self):
        assert goodness_of_fit([60, 40, 0], [0.5, 0.5, 0.0]) == goodness_of_fit([60, 40],
                                                                                [0.5, 0.5])

    @pytest.mark.parametrize("drops", [200, 100_000])
    @pytest.mark.parametrize("unit", [(0, 1, 2, 3, 4, 5), (0, 1, 1, 2, 2, 2)])
    def test_predictions_with_an_error_of_their_own_give_uniform_p(self, drops, unit):
        """Truths as far from the prediction as it says: 2000 of them, with drops of each.

        A share of 2000 near 1/2 has the standard error 0.011, one of 0.05 0.005; four of each are
        allowed. Taken as exact, the prediction is refused in 99 % where drops are many.
        """
        rng, unit = np.random.default_rng(3), np.array(unit)
        size, worth = np.bincount(unit), 150.0
        whole = rng.dirichlet(np.full(size.size, 9.0))
        told = (whole / size)[unit]
        errors = (np.sqrt(whole * (1.0 - whole) / (worth + 1.0)) / size)[unit]
        true = (rng.dirichlet(worth * whole, 2000) / size)[:, unit]
        counts = rng.multinomial(drops, true)
        p = np.array([goodness_of_fit(one, told, errors, unit).p_value for one in counts])
        assert np.mean(p < 0.5) == pytest.approx(0.5, abs=0.045)
        assert np.mean(p < 0.05) == pytest.approx(0.05, abs=0.02)

    def test_an_error_that_nobody_knows_leaves_the_chance_unknown(self):
        found = goodness_of_fit([60, 40], [0.5, 0.5], [math.nan, 0.1])
        assert found.statistic == pytest.approx(4.0) and not found.too_few
        assert math.isnan(found.p_value)

    @pytest.mark.parametrize(("counts", "probabilities"), [
        ([0, 0], [0.5, 0.5]), ([3, 2], [0.5, 0.5]), ([100], [1.0]), ([9, 0], [0.5, 0.5]),
        ([1000, 3], [1.0, 0.0])])
    def test_too_few(self, counts, probabilities):
        found = goodness_of_fit(counts, probabilities)
        assert found.too_few
        assert math.isnan(found.statistic) and math.isnan(found.p_value)

    def test_exactly_five_is_enough(self):
        assert goodness_of_fit([5, 5], [0.5, 0.5]) == ChiSquare(0.0, 1, 1.0, 2, 0)
        assert not goodness_of_fit([45, 5], [0.9, 0.1]).too_few

    @pytest.mark.parametrize(("counts", "probabilities"), [
        ([1, 2], [1.0]), ([1, -2], [0.5, 0.5]), ([1, 2], [math.nan, 1.0]), ([1, 2], [0.0, 0.0]),
        ([[1, 2]], [[0.5, 0.5]])])
    def test_refused(self, counts, probabilities):
        with pytest.raises(RequestError, match="expected"):
            goodness_of_fit(counts, probabilities)

    @pytest.mark.parametrize("pooling", [False, True])
    def test_p_is_uniform_where_the_prediction_holds(self, pooling):
        # 2000 trials: the share below a level has the binomial error sqrt(a (1 - a) / 2000);
        # four of them, and 0.01 for counts being whole numbers.
        p = np.array([0.4, 0.3, 0.2, 0.07, 0.02, 0.006, 0.004][:7 if pooling else 4])
        p /= p.sum()
        draws = np.random.default_rng(3).multinomial(400, p, size=2000)
        found = [goodness_of_fit(draw, p) for draw in draws]
        assert {one.pooled for one in found} == {3 if pooling else 0}
        values = np.array([one.p_value for one in found])
        for level in (0.01, 0.05, 0.25, 0.5, 0.75, 0.95):
            bound = 4.0 * math.sqrt(level * (1.0 - level) / 2000) + 0.01
            assert np.mean(values < level) == pytest.approx(level, abs=bound)

    def test_a_wrong_distribution_is_found(self):
        # Five points from one pose to another, 1000 parts: non-centrality 1000 (0.05²/0.5 +
        # 0.05²/0.3) = 13.3 with 2 degrees of freedom; 91 % of trials have p < 0.05. The
        # binomial error of 500 trials is 1.3 %.
        draws = np.random.default_rng(4).multinomial(1000, (0.45, 0.35, 0.2), size=500)
        found = [goodness_of_fit(draw, (0.5, 0.3, 0.2)).p_value < 0.05 for draw in draws]
        assert np.mean(found) > 0.86


class TestHomogeneity:
    def test_by_hand(self):
        # Columns 30, 40, 50 of 120, equal rows: expected 15, 20, 25; 2 (25/15 + 0 + 25/25).
        found = homogeneity([10, 20, 30], [20, 20, 20])
        assert found.statistic == pytest.approx(2 * (25 / 15 + 25 / 25))
        assert found.degrees_of_freedom == 2

    @pytest.mark.parametrize("seed", range(5))
    def test_as_scipy(self, seed):
        rng = np.random.default_rng(seed)
        p = rng.dirichlet(np.full(6, 8.0))
        rows = rng.multinomial(500, p), rng.multinomial(9000, rng.dirichlet(300 * p))
        known = stats.chi2_contingency(rows, correction=False)
        found = homogeneity(*rows)
        assert found.statistic == pytest.approx(known.statistic, rel=1e-10)
        assert found.p_value == pytest.approx(known.pvalue, rel=1e-7)
        assert found.degrees_of_freedom == known.dof

    def test_it_does_not_matter_which_is_first(self):
        one, other = homogeneity([10, 20, 3], [200, 180, 9]), homogeneity([200, 180, 9],
                                                                          [10, 20, 3])
        assert one.statistic == pytest.approx(other.statistic)

    def test_bins_are_pooled_by_the_smaller_sample(self):
        # 100 of 1100: a column of 44 is expected 4 times in the small sample.
        found = homogeneity([56, 38, 6], [560, 402, 38])
        assert (found.bins, found.pooled) == (2, 2)

    def test_empty_in_both_says_nothing(self):
        assert homogeneity([30, 0, 70], [20, 0, 80]) == homogeneity([30, 70], [20, 80])

    @pytest.mark.parametrize(("first", "second"), [
        ([0, 0], [50, 50]), ([50, 50], [0, 0]), ([0], [0]), ([2, 3], [100, 200])])
    def test_too_few(self, first, second):
        assert homogeneity(first, second).too_few

    def test_refused(self):
        with pytest.raises(RequestError, match="equally long"):
            homogeneity([1, 2], [1, 2, 3])

    def test_p_is_uniform_where_the_two_agree(self):
        # As above; a simulation of 600 drops taken as certain would reject 20 % at 5 %.
        p, rng = (0.5, 0.3, 0.15, 0.05), np.random.default_rng(5)
        pairs = zip(rng.multinomial(400, p, size=2000), rng.multinomial(600, p, size=2000),
                    strict=True)
        values = np.array([homogeneity(*pair).p_value for pair in pairs])
        for level in (0.01, 0.05, 0.25, 0.5, 0.75, 0.95):
            bound = 4.0 * math.sqrt(level * (1.0 - level) / 2000) + 0.01
            assert np.mean(values < level) == pytest.approx(level, abs=bound)


class TestPooling:
    @pytest.mark.parametrize(("expected", "pooled", "bins"), [
        ([10, 20, 30], 0, 3), ([4, 20, 30], 2, 2), ([3, 3, 30], 2, 2), ([1, 2, 6, 30], 3, 2),
        ([1, 1], 2, 1), ([], 0, 0), ([4.0], 0, 1), ([2.5, 2.5, 7], 2, 2)])
    def test_smallest_first(self, expected, pooled, bins):
        found, together = pooled_bins(expected)
        assert together == pooled
        assert len(set(found.tolist())) == bins

    def test_every_new_bin_is_large_enough(self):
        rng = np.random.default_rng(6)
        for _ in range(200):
            expected = rng.gamma(0.5, 10.0, size=rng.integers(2, 30))
            found, _ = pooled_bins(expected)
            sums = np.bincount(found, expected)
            assert sums.sum() == pytest.approx(expected.sum())
            assert sums.size == 1 or sums.min() >= 5.0 - 1e-9
