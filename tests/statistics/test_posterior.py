"""Estimate and counts together: laws that hold for all of them, and their calibration."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta, betabinom, dirichlet

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.posterior import PosePrior, PriorFit, error_quantile
from ros_pose_stats.statistics.posterior.connor_mosimann import ConnorMosimann
from ros_pose_stats.statistics.posterior.fitted import FITTED, FITTED_AT
from ros_pose_stats.statistics.posterior.prior import FLOOR, prior_fit
from ros_pose_stats.statistics.posterior.shortest import shortest_interval

PLAIN = PriorFit(0.0, 0.5, 0.0, 0.0, 0.5)
"""A Dirichlet distribution around the estimate, but for the scatter of its strength."""


@st.composite
def cases(draw, most=7):
    """Estimate, groups that share it evenly, and counts."""
    poses = draw(st.integers(1, most))
    group = np.array(draw(st.lists(st.integers(0, 3), min_size=poses, max_size=poses)))
    weight = np.array(draw(st.lists(st.sampled_from((0.0, 1e-4, 0.01, 1.0, 3.0)), min_size=4,
                                    max_size=4)))[group] + 1e-9
    counts = np.array(draw(st.lists(st.integers(0, 300), min_size=poses, max_size=poses)))
    return weight / weight.sum(), group, counts, draw(st.sampled_from((0.0, 0.01, 0.05, math.nan)))


def drawn(prior, random, counts=None, size=4000):
    """Probabilities (size, G) of the units out of a prior, or a posterior."""
    pooled = np.zeros(prior.size.size) if counts is None else prior._pooled(counts)
    breaks, weight, _ = prior._updated(pooled)
    which = random.choice(weight.size, size, p=weight)
    likely = np.broadcast_to(np.exp(breaks.log_share), breaks.taken.shape)[0]
    kind = (random.random((size, likely.shape[1])) > likely[which]).astype(int)
    at = kind, which[:, None], np.arange(likely.shape[1])
    shares = random.beta(breaks.taken[at], breaks.left[at])
    rest = np.cumprod(np.column_stack((np.ones(size), 1.0 - shares)), axis=1)
    ordered = np.column_stack((shares, np.ones(size))) * rest
    return ordered[:, np.argsort(prior._order(pooled))]


class TestLaws:
    @given(cases())
    def test_a_distribution_shared_evenly_within_groups(self, case):
        estimate, group, counts, error = case
        found = PosePrior(estimate, group, error, 0.5).updated(counts)
        low, high = found.interval()
        assert found.probability.sum() == pytest.approx(1.0, abs=1e-12)
        assert found.probability.min() > 0.0
        assert (low >= 0.0).all() and (low <= high).all() and (high <= 1.0 + 1e-12).all()
        for one in np.unique(group):
            for values in (found.probability, found.standard_error, low, high):
                assert np.ptp(values[group == one]) <= 1e-12
        rms = math.sqrt(np.mean(found.standard_error ** 2))
        assert found.expected_error == pytest.approx(rms, abs=1e-9)

    @given(cases(), st.randoms(use_true_random=False))
    def test_the_order_of_the_poses_is_no_matter(self, case, random):
        estimate, group, counts, error = case
        order = list(range(len(group)))
        random.shuffle(order)
        one = PosePrior(estimate, group, error, 0.3).updated(counts)
        other = PosePrior(estimate[order], group[order], error, 0.3).updated(counts[order])
        np.testing.assert_allclose(other.probability, one.probability[order], rtol=1e-9)
        np.testing.assert_allclose(other.standard_error, one.standard_error[order], rtol=1e-6,
                                   atol=1e-12)
        assert other.error_quantile() == pytest.approx(one.error_quantile(), rel=1e-6, abs=1e-12)

    @given(cases())
    def test_wider_intervals_hold_more(self, case):
        estimate, group, counts, error = case
        found = PosePrior(estimate, group, error, 0.5).updated(counts)
        widths = [np.subtract(*found.interval(level)[::-1]) for level in (0.5, 0.8, 0.9, 0.99)]
        assert all((b >= a - 1e-9).all() for a, b in pairwise(widths))
        bounds = [found.error_quantile(level) for level in (0.5, 0.9, 0.99)]
        assert bounds == sorted(bounds)

    def test_before_the_first_drop_it_is_the_estimate(self):
        estimate = np.array((0.6, 0.3, 0.08, 0.02))
        found = PosePrior(estimate, range(4), 0.03, 0.5, PLAIN).updated(np.zeros(4))
        np.testing.assert_allclose(found.probability, estimate, atol=1e-9)

    @pytest.mark.parametrize("restitution", FITTED_AT)
    def test_the_fit_takes_off_what_is_overrated_in_rare_poses(self, restitution):
        estimate = np.array((0.6, 0.39, 0.01))
        found = PosePrior(estimate, range(3), 0.03, restitution).updated(np.zeros(3))
        assert found.probability[2] < estimate[2]
        np.testing.assert_allclose(found.probability, estimate, atol=0.03)

    @pytest.mark.parametrize("fit", [None, PLAIN])
    def test_with_ever_more_drops_it_is_the_counts(self, fit):
        estimate, true = np.array((0.6, 0.3, 0.1, 0.0)), np.array((0.1, 0.4, 0.2, 0.3))
        prior = PosePrior(estimate, range(4), 0.02, 0.5, fit)
        away = [np.abs(prior.updated(true * n).probability - true).max()
                for n in (0, 10 ** 2, 10 ** 3, 10 ** 4, 10 ** 6)]
        assert away == sorted(away, reverse=True)
        assert away[-1] < 1e-4
        assert prior.updated(true * 10 ** 6).expected_error == pytest.approx(
            math.sqrt(np.mean(true * (1.0 - true)) / 10 ** 6), rel=1e-3)

    def test_a_pose_that_is_ruled_out_wrongly(self):
        prior = PosePrior((0.5, 0.5, 0.0), range(3), 0.02, 0.5)
        assert prior.mean[2] == pytest.approx(FLOOR, rel=1e-3)
        after = [prior.updated(np.array((45, 45, 10)) * n).probability[2] for n in (1, 10, 100)]
        assert after[0] > 0.02
        assert after[1] == pytest.approx(0.1, abs=0.02)
        assert after[2] == pytest.approx(0.1, abs=0.002)

    def test_conflict_weakens_the_estimate(self):
        """Equal counts move the estimate further the less likely they are under it."""
        prior = PosePrior((0.5, 0.3, 0.2), range(3), 0.01, 0.5, PLAIN)
        true = np.array((0.25, 0.3, 0.45))
        moved = 1.0 - abs(prior.updated(1000 * true).probability - true).max() / 0.25
        typical = 1000.0 / (1000.0 + prior.strength)
        assert moved > typical + 0.1

    def test_symmetry_leaves_nothing_to_learn(self):
        prior = PosePrior(np.full(6, 1 / 6), np.zeros(6, int), 0.0, 0.5)
        found = prior.updated([9, 0, 0, 0, 0, 0])
        np.testing.assert_allclose(found.probability, 1 / 6)
        np.testing.assert_allclose(found.interval(), 1 / 6)
        assert found.expected_error < 1e-9

    def test_one_pose_is_certain(self):
        found = PosePrior([1.0], [0], math.nan, 0.5).updated([3])
        np.testing.assert_allclose((found.probability[0], *np.ravel(found.interval())), 1.0)
        assert found.error_quantile() < 1e-9

    @pytest.mark.parametrize(("estimate", "group", "counts"), [
        ([0.5, 0.4], [0, 1], [0, 0]), ([1.5, -0.5], [0, 1], [0, 0]), ([], [], []),
        ([0.5, math.nan], [0, 1], [0, 0]), ([0.5, 0.5], [0], [0, 0]),
        ([0.5, 0.5], [0, 1], [0, -1]), ([0.5, 0.5], [0, 1], [0, 0, 0]),
    ])
    def test_refusals(self, estimate, group, counts):
        with pytest.raises(RequestError, match=r"expected .*, got .*; "):
            PosePrior(estimate, group, 0.03, 0.5).updated(counts)


class TestLargestError:
    @pytest.mark.parametrize("counts", [(0, 0, 0, 0), (30, 8, 2, 0), (900, 500, 90, 10)])
    def test_against_draws_from_the_distribution(self, counts):
        prior = PosePrior((0.55, 0.33, 0.1, 0.02), range(4), 0.04, 0.5, PLAIN)
        found = prior.updated(counts)
        true = np.abs(drawn(prior, np.random.default_rng(4), counts, 20_000)
                      - found.probability).max(axis=1)
        for level in (0.5, 0.9):
            kept = np.mean(true <= found.largest_error(level))
            assert kept == pytest.approx(level, abs=0.04)

    def test_noise_of_other_drops_widens_it(self):
        found = PosePrior((0.6, 0.3, 0.1), range(3), 0.02, 0.5).updated((60, 30, 10))
        bounds = [found.largest_error(0.9, drops) for drops in (100, 1000, 1e9, math.inf)]
        assert bounds == sorted(bounds, reverse=True)
        assert bounds[2] == pytest.approx(bounds[3], rel=1e-3)

    def test_symmetry_leaves_none(self):
        assert PosePrior(np.full(4, 0.25), np.zeros(4, int), 0.0, 0.5).updated(
            np.zeros(4)).largest_error() < 1e-9


class TestSticks:
    def test_equal_strengths_are_a_dirichlet_distribution(self):
        mean = np.array((0.05, 0.15, 0.3, 0.5))
        prior = ConnorMosimann.around(mean, np.full((2, 1, 4), 20.0), np.array((0.3, 0.7)))
        found, _ = prior.updated(np.array((1.0, 0.0, 7.0, 2.0)))
        same = dirichlet(20.0 * mean + (1.0, 0.0, 7.0, 2.0))
        np.testing.assert_allclose(found.moments()[0][0], same.mean(), rtol=1e-12)
        np.testing.assert_allclose(found.moments()[1][0], same.var(), rtol=1e-9)

    def test_counts_tell_break_by_break_how_sure_the_estimate_was(self):
        """Against Bayes' rule for one break, of which two distributions are possible."""
        a, b = (0.3, 9.7), (6.0, 194.0)
        taken, left, share = (np.array(pair)[:, None, None] for pair in
                              (*zip(a, b, strict=True), (0.25, 0.75)))
        prior = ConnorMosimann(taken, left, np.log(share))
        after, evidence = prior.updated(np.array((4.0, 6.0)))
        likely = np.array((0.25, 0.75)) * np.exp([
            betabinom.logpmf(4, 10, *one) for one in (a, b)]) / math.comb(10, 4)
        assert math.exp(evidence[0]) == pytest.approx(likely.sum())
        np.testing.assert_allclose(np.exp(after.log_share[:, 0, 0]), likely / likely.sum())

    def test_the_evidence_of_all_outcomes_is_one(self):
        prior = PosePrior((0.7, 0.2, 0.1), range(3), 0.05, 0.5)
        total = sum(math.exp(prior.log_evidence(np.bincount(drops, minlength=3)))
                    for drops in product(range(3), repeat=4))
        assert total == pytest.approx(1.0, abs=1e-9)


def beta_moments(a, b):
    return np.array(a) / np.add(a, b), beta.var(a, b)


class TestShortest:
    @given(st.floats(1.01, 500.0), st.floats(1.01, 500.0), st.sampled_from((0.5, 0.9, 0.99)))
    def test_as_dense_at_both_ends(self, a, b, level):
        """Of one Beta distribution, against scipy's."""
        mean, variance = beta_moments([[a]], [[b]])
        (low,), (high,) = shortest_interval(np.ones((1, 1)), mean, variance, level)
        own = beta(a, b)
        assert own.cdf(high) - own.cdf(low) == pytest.approx(level, abs=1e-4)
        width = high - low
        for below in np.linspace(0.0, 1.0 - level, 20):
            assert own.ppf(min(below + level, 1.0)) - own.ppf(below) >= width * (1.0 - 3e-3)

    def test_a_density_that_falls_begins_at_nothing(self):
        moments = beta_moments([[0.5, 1.0, 9.0, 1e-3]], [[9.0, 9.0, 0.5, 2.0]])
        low, high = shortest_interval(np.ones((1, 4)), *moments, 0.9)
        assert low[[0, 1, 3]].tolist() == [0.0, 0.0, 0.0] and high[2] == 1.0
        np.testing.assert_allclose(beta.cdf(high[:2], (0.5, 1.0), 9.0), 0.9, atol=1e-4)
        assert high[3] < 1e-6

    @given(st.floats(0.05, 0.95), st.floats(2.0, 40.0), st.floats(0.003, 0.5),
           st.floats(1.5, 60.0))
    def test_of_two_kinds(self, share, b, mean, times):
        """A sure kind and an unsure one about the same mean: mass and length, against all
        intervals between quantiles of the mixture."""
        totals = np.array([b * times / mean, b / mean])
        sure, unsure = (beta(total * mean, total * (1.0 - mean)) for total in totals)
        weight = np.array([[share], [1.0 - share]])
        means, variances = np.array([[mean], [mean]]), np.array([[sure.var()], [unsure.var()]])
        (low,), (high,) = shortest_interval(weight, means, variances, 0.9)
        x = np.sort(np.concatenate([kind.ppf(np.linspace(1e-9, 1.0 - 1e-9, 1500))
                                    for kind in (sure, unsure)]))
        cdf = share * sure.cdf(x) + (1.0 - share) * unsure.cdf(x)
        held = np.interp(high, x, cdf) - np.interp(low, x, cdf)
        assert held == pytest.approx(0.9, abs=2e-3)
        begin = cdf <= cdf[-1] - 0.9
        best = (np.interp(cdf[begin] + 0.9, cdf, x) - x[begin]).min()
        assert high - low <= 1.01 * best


class TestIntervals:
    def test_two_poses_complement_each_other(self):
        """What one has not, the other has."""
        for counts in ((0, 0), (20, 0), (300, 2)):
            posterior = PosePrior((0.995, 0.005), range(2), 0.01, 0.5).updated(counts)
            low, high = posterior.interval()
            np.testing.assert_allclose(low, 1.0 - high[::-1], atol=1e-6)

    def test_shares_of_other_drops_scatter_within_a_group(self):
        """The poses of a cube have a sixth each; their shares in n drops the binomial error."""
        posterior = PosePrior(np.full(6, 1.0 / 6.0), np.zeros(6, dtype=int), 0.0, 0.5).updated(
            np.zeros(6, dtype=int))
        low, high = posterior.interval()
        np.testing.assert_allclose((low, high), 1.0 / 6.0)
        low, high = posterior.interval(0.9, 20_000)
        width = 2.0 * 1.6449 * math.sqrt(5.0 / 36.0 / 20_000)
        np.testing.assert_allclose(high - low, width, rtol=1e-2)


@pytest.mark.long
class TestCalibration:
    """Truths drawn from the prior, counts drawn from the truths: nine of ten must hold."""

    PARTS = 500

    @pytest.mark.parametrize("drops", [0, 20, 500])
    def test_intervals_and_bound_hold_as_often_as_they_say(self, drops):
        random = np.random.default_rng(drops)
        prior = PosePrior((0.45, 0.3, 0.2, 0.047, 0.003), range(5), 0.03, 0.5)
        inside, kept = [], []
        for true in drawn(prior, random, size=self.PARTS):
            found = prior.updated(random.multinomial(drops, true))
            low, high = found.interval()
            inside.append((low <= true) & (true <= high))
            error = math.sqrt(np.mean((found.probability - true) ** 2))
            kept.append(error <= found.error_quantile())
        # Four standard errors of a share among so many parts, and two points for Beta and gamma.
        allowed = 4.0 * math.sqrt(0.09 / self.PARTS) + 0.02
        assert np.mean(inside, axis=0) == pytest.approx(0.9, abs=allowed)
        assert np.mean(kept) == pytest.approx(0.9, abs=allowed)

    @pytest.mark.parametrize("counts", [(0, 0, 0, 0, 0), (9, 6, 4, 1, 0), (450, 300, 200, 40, 10)])
    def test_the_bound_is_a_quantile_of_the_posterior(self, counts):
        prior = PosePrior((0.45, 0.3, 0.2, 0.047, 0.003), range(5), 0.03, 0.5)
        found = prior.updated(counts)
        true = drawn(prior, np.random.default_rng(1), counts, 20_000)
        errors = np.sqrt(np.mean((true - found.probability) ** 2, axis=1))
        assert np.sqrt(np.mean(errors ** 2)) == pytest.approx(found.expected_error, rel=0.03)
        assert np.quantile(errors, 0.9) == pytest.approx(found.error_quantile(), rel=0.06)

    def test_of_plain_counts(self):
        random, p = np.random.default_rng(2), np.array((0.5, 0.3, 0.15, 0.05))
        errors = np.sqrt(np.mean((random.multinomial(400, p, 20_000) / 400 - p) ** 2, axis=1))
        assert np.quantile(errors, 0.9) == pytest.approx(error_quantile(p, 400, 0.9), rel=0.03)


def test_between_and_beyond_the_fitted_restitutions():
    assert prior_fit(0.2) == FITTED[0]
    assert prior_fit(0.0) == FITTED[0]
    assert prior_fit(0.35) == pytest.approx(np.mean(FITTED[:2], axis=0))
