"""The likelihood of counts, its intervals, and the fit of smooth functions, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from ros_pose_stats.plates.gaussian_process import BinomialProcess, Kernel
from ros_pose_stats.plates.likelihood import (
    SCATTERS,
    WEIGHTS,
    averaged,
    most_likely,
    plausible_bounds,
    scene_likelihood,
)
from ros_pose_stats.plates.response import Shares
from ros_pose_stats.plates.scenes import SceneGrid, SceneRange
from ros_pose_stats.statistics.dirichlet_multinomial import log_likelihood


class TestDirichletMultinomial:
    @pytest.mark.parametrize("dispersion", [0.001, 0.05, 0.4])
    def test_differences_are_those_of_scipy(self, dispersion):
        counts = np.array([7, 0, 12])
        shares = np.array([[0.3, 0.1, 0.6], [0.5, 0.25, 0.25]])
        found = log_likelihood(counts, shares, np.full(2, dispersion))
        known = [stats.dirichlet_multinomial(row * (1.0 / dispersion - 1.0), 19).logpmf(counts)
                 for row in shares]
        assert found[0] - found[1] == pytest.approx(known[0] - known[1], rel=1e-9)

    def test_without_dispersion_it_is_multinomial(self):
        counts, shares = np.array([30, 70]), np.array([[0.3, 0.7], [0.5, 0.5]])
        found = log_likelihood(counts, shares, np.zeros(2))
        known = stats.multinomial.logpmf(counts, 100, shares)
        np.testing.assert_allclose(found - found[0], known - known[0])
        near = log_likelihood(counts, shares, np.full(2, 2e-9))
        np.testing.assert_allclose(near - near[0], found - found[0], atol=1e-5)


class TestExactPart:
    """A part whose two shares are known exactly: p is the restitution, whatever the height."""

    GRID = SceneGrid(np.linspace(0.01, 0.89, 441), np.log(np.array([0.01, 0.1])))

    def logarithm(self, met, of):
        share = self.GRID.points[:, 0]
        shares = Shares(np.stack((share, 1.0 - share), axis=1), np.zeros(share.size))
        return scene_likelihood(np.array([met, of - met], dtype=float), shares)

    def test_value_and_interval_without_scatter(self):
        found = most_likely(self.GRID, self.logarithm(120, 400)[0])
        assert found.restitution[0] == pytest.approx(0.3, abs=0.0011)

        def fallen(p):
            return 2.0 * (stats.binom.logpmf(120, 400, 0.3) - stats.binom.logpmf(120, 400, p))

        assert fallen(np.array(found.restitution[1:])) == pytest.approx(2.7055, rel=0.02)
        assert found.drop_height[1:] == pytest.approx((0.01, 0.1))  # of which nothing is known

    def test_scatter_widens_where_parts_contradict_each_other(self):
        agreeing = self.logarithm(120, 400) + self.logarithm(122, 400)
        apart = self.logarithm(80, 400) + self.logarithm(160, 400)

        def width(logarithm):
            _, low, high = most_likely(self.GRID, logarithm).restitution
            return high - low

        assert width(averaged(agreeing)) < 1.5 * width(agreeing[0])
        assert width(averaged(apart)) > 2.0 * width(apart[0])

    def test_the_box_holds_the_interval(self):
        logarithm = averaged(self.logarithm(120, 400))
        found = most_likely(self.GRID, logarithm)
        low, high = plausible_bounds(self.GRID, logarithm, 3.0)[:, 0]
        assert low < found.restitution[1] and high > found.restitution[2]

    def test_coverage(self):
        """The 90 % interval over 2000 plates; three standard errors are 2 points."""
        random, held = np.random.default_rng(3), 0
        tables = {met: most_likely(self.GRID, averaged(self.logarithm(met, 300))).restitution
                  for met in range(20, 260)}
        for _ in range(2000):
            truth = random.uniform(0.2, 0.7)
            _, low, high = tables[int(random.binomial(300, truth))]
            held += low <= truth <= high
        assert 0.88 <= held / 2000 <= 0.96  # the weight of scatters that are not there widens


def test_weights_of_scatters_sum_to_one():
    assert WEIGHTS.sum() == 1.0 and WEIGHTS.size == SCATTERS.size


class TestBinomialProcess:
    def test_a_constant_is_the_logit_of_the_share(self):
        points, trials = np.zeros((3, 1)), np.array([500.0, 700.0, 800.0])
        kernel = Kernel(10.0, 0.0, np.array([1.0]))
        process = BinomialProcess(kernel(points, points), 0.2 * trials, trials, np.zeros(3))
        mean, variance = process.predict(kernel(np.zeros((1, 1)), points), kernel.variance)
        assert mean[0] == pytest.approx(np.log(0.25), abs=1e-3)
        assert variance[0] == pytest.approx(1.0 / (2000.0 * 0.16), rel=0.01)

    def test_far_from_all_points_only_the_constant_is_known(self):
        kernel, points = Kernel(0.5, 0.4, np.array([0.1])), np.zeros((1, 1))
        process = BinomialProcess(kernel(points, points), np.array([1e6]), np.array([2e6]),
                                  np.zeros(1))
        _, variance = process.predict(kernel(np.full((1, 1), 9.0), points), kernel.variance)
        assert variance[0] == pytest.approx(0.41 - 0.25 ** 2 / 0.41, rel=1e-3)

    def test_a_known_curve(self):
        random, points = np.random.default_rng(5), np.linspace(0.0, 1.0, 60)[:, None]
        kernel, curve = Kernel(1.0, 0.6, np.array([0.5])), np.sin(4.0 * points[:, 0])
        trials = np.full(60, 400.0)
        met = random.binomial(400, 1.0 / (1.0 + np.exp(-curve))).astype(float)
        process = BinomialProcess(kernel(points, points), met, trials, np.zeros(60))
        mean, variance = process.predict(kernel(points, points), kernel.variance)
        assert np.mean(np.square(mean - curve) / variance) < 2.0
        assert np.sqrt(np.mean(np.square(mean - curve))) < 0.06  # a point alone: 0.1


def test_points_fill_the_range():
    within = SceneRange.of_radii([0.01, 0.03])
    assert (within.lowest, within.highest) == pytest.approx((0.0075, 3.0))
    points = within.spread_points(200)
    low, high = within.bounds
    unit = (points - low) / (high - low)
    cells = np.floor(unit * 4.0).astype(int)
    assert np.unique(cells, axis=0).shape[0] == 16
    assert ((unit > 0.0) & (unit < 1.0)).all()
