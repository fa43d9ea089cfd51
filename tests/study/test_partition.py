"""The metric must find the error that was put in, and no other."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.errors import root_mean_square
from ros_pose_stats.study.errors.partition import accuracy, sensitivity
from ros_pose_stats.study.errors.simulated_poses import SimulatedPoses, pooled
from tests.statistics.simulations import bodies, simulated

SETS = 400


def error_bound(error, noise, values):
    """Five standard errors of `error` where both differences are about normal.

    A mean of N squares of variance v = error² + noise² is known to v sqrt(2 / N), and the root
    of it to that over 2 error.
    """
    return 5.0 * (error ** 2 + noise ** 2) * math.sqrt(2.0 / values) / (2.0 * error)


class TestAccuracy:
    @pytest.mark.parametrize("error", [0.02, 0.05, 0.15])
    @pytest.mark.parametrize("drops", [30, 100, 1000])
    def test_finds_the_error_put_in(self, error, drops):
        # The poses of a body are dependent: only N less the bodies are free. The bound is half of
        # the error where it is a third of the noise (30 drops, 0.02), else 20 % to 5 % of it.
        rng = np.random.default_rng(drops)
        body, p = bodies(rng, 1500)
        off = error * rng.normal(size=len(p))
        found = accuracy(p + off, simulated(rng, body, p, drops), resamples=100)
        noise = math.sqrt(np.mean(p * (1.0 - p) / drops))
        free = len(p) - 1500
        assert found.error == pytest.approx(root_mean_square(off),
                                            abs=error_bound(error, noise, free))
        assert found.noise == pytest.approx(noise, rel=5.0 / math.sqrt(2.0 * free))
        assert found.deviation ** 2 == pytest.approx(error ** 2 + noise ** 2,
                                                     rel=5.0 * math.sqrt(2.0 / free))
        assert found.low < found.error < found.high
        assert found.standard_error < error_bound(error, noise, free) / 5.0 * 1.5

    def test_with_different_drops_for_each_body(self):
        rng = np.random.default_rng(6)
        body, p = bodies(rng, 1500)
        drops = rng.integers(5, 200, 1500)
        noise = math.sqrt(np.mean(p * (1.0 - p) / drops[body]))
        off = 0.05 * rng.normal(size=len(p))
        found = accuracy(p + off, simulated(rng, body, p, drops), resamples=2)
        # Twice the bound for equal drops: the few drops of some bodies weigh more.
        assert found.error == pytest.approx(root_mean_square(off),
                                            abs=2.0 * error_bound(0.05, noise, len(p) - 1500))

    def test_nothing_is_left_of_a_perfect_estimator(self):
        # Even at 5 drops: the mean over 400 sets is 0 within four of its standard errors. With
        # the paper's noise a fifth of the noise stays.
        rng = np.random.default_rng(2)
        left, paper, noise = [], [], []
        for _ in range(SETS):
            body, p = bodies(rng, 60)
            simulation = simulated(rng, body, p, 5)
            left.append(accuracy(p, simulation, resamples=2))
            paper.append(accuracy(p, simulation, unbiased=False, resamples=2))
            noise.append(np.mean(p * (1.0 - p) / 5))
        variances = np.array([one.error_variance for one in left])
        bound = 4.0 * variances.std() / math.sqrt(SETS)
        assert bound < 0.05 * np.mean(noise)
        assert variances.mean() == pytest.approx(0.0, abs=bound)
        assert (np.mean([one.error_variance for one in paper])
                == pytest.approx(np.mean(noise) / 5, abs=bound))
        # About half of the sets fall below 0: binomial error 2.5 %, four of it and 5 % for skew.
        assert np.mean(variances < 0.0) == pytest.approx(0.5, abs=0.15)
        for one in left:
            assert one.error == math.sqrt(max(one.error_variance, 0.0))

    def test_by_hand(self):
        # s = 0.3, 0.7, 0.5, 0.5; off by 0.1, 0.1, -0.2, 0.
        simulation = SimulatedPoses([0, 0, 3, 3], [3, 7, 2, 2], [10, 10, 4, 4])
        found = accuracy([0.4, 0.8, 0.3, 0.5], simulation, unbiased=False)
        assert found.deviation == pytest.approx(math.sqrt(0.06 / 4))
        assert found.noise == pytest.approx(math.sqrt((2 * 0.021 + 2 * 0.0625) / 4))
        assert found.error_variance == pytest.approx(0.015 - 0.04175)
        assert (found.error, found.largest_at, found.values) == (0.0, 2, 4)
        assert found.largest == pytest.approx(0.2)

    @pytest.mark.parametrize("drops", [2, 10, 100])
    def test_the_paper_has_n_less_1_for_n(self, drops):
        rng = np.random.default_rng(3)
        body, p = bodies(rng, 20)
        simulation = simulated(rng, body, p, drops)
        ours, paper = (accuracy(p, simulation, unbiased=unbiased, resamples=2)
                       for unbiased in (True, False))
        assert ours.noise ** 2 / paper.noise ** 2 == pytest.approx(drops / (drops - 1), rel=1e-12)
        assert ours.deviation == paper.deviation

    def test_one_body_has_no_error_known(self):
        found = accuracy([0.5, 0.5], SimulatedPoses([2, 2], [10, 90], [100, 100]))
        assert found.error == pytest.approx(math.sqrt(0.16 - 0.09 / 99))
        assert np.isnan([found.standard_error, found.low, found.high]).all()

    def test_by_seed(self):
        rng = np.random.default_rng(4)
        body, p = bodies(rng, 30)
        simulation, estimate = simulated(rng, body, p, 50), p + 0.1 * rng.normal(size=len(p))
        first, again, other = (accuracy(estimate, simulation, seed=seed) for seed in (1, 1, 2))
        assert first == again
        assert first.standard_error != other.standard_error
        assert first.error == other.error


class TestProperties:
    @given(st.integers(0, 2 ** 32 - 1), st.integers(1, 40), st.booleans())
    def test_the_parts_add_up(self, seed, number, unbiased):
        rng = np.random.default_rng(seed)
        body, p = bodies(rng, number)
        simulation = simulated(rng, body, p, rng.integers(2, 60, number))
        found = accuracy(rng.random(len(p)), simulation, unbiased=unbiased, resamples=2)
        assert found.deviation ** 2 == pytest.approx(found.error_variance + found.noise ** 2,
                                                     abs=1e-15)
        assert found.error == math.sqrt(max(found.error_variance, 0.0))
        assert found.largest >= found.deviation * (1.0 - 1e-12)

    @given(st.integers(0, 2 ** 32 - 1))
    def test_the_order_of_the_values_is_no_matter(self, seed):
        rng = np.random.default_rng(seed)
        body, p = bodies(rng, 12)
        simulation, estimate = simulated(rng, body, p, 40), rng.random(len(p))
        order = rng.permutation(len(p))
        mixed = SimulatedPoses(body[order], simulation.count[order], simulation.settled[order])
        one, other = (asdict(accuracy(*pair, resamples=20))
                      for pair in ((estimate, simulation), (estimate[order], mixed)))
        assert order[other.pop("largest_at")] == one.pop("largest_at")
        assert other == pytest.approx(one, abs=1e-12)

    @given(st.integers(0, 2 ** 32 - 1), st.floats(0.01, 10.0))
    def test_scale(self, seed, factor):
        rng = np.random.default_rng(seed)
        body, p = bodies(rng, 12)
        simulation, off = simulated(rng, body, p, 40), rng.normal(size=len(p))
        one, other = (accuracy(simulation.probability + times * off, simulation, resamples=2)
                      for times in (1.0, factor))
        assert other.deviation == pytest.approx(factor * one.deviation, rel=1e-9)
        assert other.largest == pytest.approx(factor * one.largest, rel=1e-9)
        assert other.noise == one.noise


class TestSensitivity:
    def test_finds_the_deviation_of_the_exact_sets(self):
        # Two restitutions of the same 1500 bodies, with 100 and 60 drops.
        rng = np.random.default_rng(5)
        body, p = bodies(rng, 1500)
        other = p * np.exp(0.4 * rng.normal(size=len(p)))
        other /= np.bincount(body, other)[body]
        real = root_mean_square(p - other)
        found = sensitivity(simulated(rng, body, p, 100), simulated(rng, body, other, 60))
        noise = math.sqrt(np.mean(p * (1.0 - p) / 100 + other * (1.0 - other) / 60))
        assert 0.03 < real < 0.1
        assert found.error == pytest.approx(real, abs=error_bound(real, noise, len(p) - 1500))
        assert found.noise == pytest.approx(noise, rel=5.0 / math.sqrt(2.0 * (len(p) - 1500)))
        assert found.standard_error < 0.1 * real

    def test_equal_sets(self):
        # 400 pairs of runs of 5 and 8 drops: four standard errors of the mean.
        rng = np.random.default_rng(7)
        left, noise = [], []
        for _ in range(SETS):
            body, p = bodies(rng, 60)
            left.append(sensitivity(simulated(rng, body, p, 5), simulated(rng, body, p, 8),
                                    resamples=2).error_variance)
            noise.append(np.mean(p * (1.0 - p)) * (1 / 5 + 1 / 8))
        bound = 4.0 * np.std(left) / math.sqrt(SETS)
        assert bound < 0.05 * np.mean(noise)
        assert np.mean(left) == pytest.approx(0.0, abs=bound)

    def test_symmetric(self):
        rng = np.random.default_rng(8)
        body, p = bodies(rng, 20)
        pair = simulated(rng, body, p, 10), simulated(rng, body, p, 30)
        assert sensitivity(*pair) == sensitivity(*pair[::-1])

    def test_the_figures_of_the_paper(self):
        # (0.0728² - 0.0321² - 0.0332²)^(1/2) = 0.0563, with one value near 1/2 of each set and
        # drops for these noises. As counts are whole, the deviation is off by 0.0004.
        n = [round(0.25 / noise ** 2) for noise in (0.0321, 0.0332)]
        ends = [SimulatedPoses([0], [round(s * drops)], [drops])
                for s, drops in zip((0.5364, 0.4636), n, strict=True)]
        found = sensitivity(*ends, unbiased=False)
        assert found.noise == pytest.approx(math.hypot(0.0321, 0.0332), abs=0.0002)
        assert found.error == pytest.approx(0.0563, abs=0.0007)


class TestSimulatedPoses:
    def test_arrays(self):
        one = SimulatedPoses(np.array([7, 7], np.uint8), [1, 3], [4, 4])
        assert one.probability.tolist() == [0.25, 0.75]
        assert one.noise_variance(unbiased=False).tolist() == [0.1875 / 4] * 2
        assert one.noise_variance().tolist() == [0.1875 / 3] * 2
        assert one.body.dtype == np.int64

    def test_pooled(self):
        parts = [SimulatedPoses([0, 1], [1, 2], [3, 4]), SimulatedPoses([1], [5], [6])]
        both = pooled(parts)
        assert both.body.tolist() == [0, 1, 1]
        assert both.count.tolist() == [1, 2, 5]
        assert both.settled.tolist() == [3, 4, 6]

    @pytest.mark.parametrize(("body", "count", "settled", "told"), [
        ([0, 1], [1], [2], "as many"), ([0], [3], [2], "3 of 2"), ([0], [0], [0], "0 of 0"),
        ([0], [-1], [2], "count of each"), ([-1], [1], [2], "body of each"),
        ([0], [1.0], [2], "count of each"), ([0], [1], [[2]], "settled of each"),
        ([], [], [], "body of each"), ([True], [1], [2], "body of each")])
    def test_refused(self, body, count, settled, told):
        with pytest.raises(RequestError, match=told):
            SimulatedPoses(body, count, settled)

    def test_nothing_to_pool(self):
        with pytest.raises(RequestError, match="one simulation"):
            pooled([])


class TestRefused:
    simulation = SimulatedPoses([0, 0], [1, 3], [4, 4])

    @pytest.mark.parametrize("estimate", [[0.5], [0.5, math.nan], [[0.5, 0.5]], 0.5])
    def test_estimates(self, estimate):
        with pytest.raises(RequestError, match="2 finite probabilities"):
            accuracy(estimate, self.simulation)

    def test_a_single_drop(self):
        single = SimulatedPoses([0, 0], [0, 1], [1, 1])
        with pytest.raises(RequestError, match="2 settled drops"):
            accuracy([0.5, 0.5], single)
        assert accuracy([0.5, 0.5], single, unbiased=False).noise == 0.0

    @pytest.mark.parametrize("other", [SimulatedPoses([0, 1], [1, 3], [4, 4]),
                                       SimulatedPoses([0], [1], [4])])
    def test_other_bodies(self, other):
        with pytest.raises(RequestError, match="same poses"):
            sensitivity(self.simulation, other)
