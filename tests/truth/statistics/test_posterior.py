# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Estimate and counts together: laws that hold for all of them, closed forms,
calibration.
"""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given, strategies
from scipy.stats import beta, binom, dirichlet, norm

from ros_pose_stats.core.planning import confidence
from ros_pose_stats.core.statistics.errors import largest_error
from ros_pose_stats.core.statistics.posterior import shortest_interval
from ros_pose_stats.core.statistics.prior import ConnorMosimann, PosePrior, prior_fit


@strategies.composite
def cases(draw):
    """Estimate, groups that share it evenly, counts, and the error of the estimate."""
    poses = draw(strategies.integers(1, 7))
    group = np.array(
        draw(
            strategies.lists(strategies.integers(0, 3), min_size=poses, max_size=poses)
        )
    )
    weight = (
        np.array(
            draw(
                strategies.lists(
                    strategies.sampled_from((0.0, 1e-4, 0.01, 1.0, 3.0)),
                    min_size=4,
                    max_size=4,
                )
            )
        )[group]
        + 1e-9
    )
    counts = np.array(
        draw(
            strategies.lists(
                strategies.integers(0, 300), min_size=poses, max_size=poses
            )
        )
    )
    return (
        weight / weight.sum(),
        group,
        counts,
        draw(strategies.sampled_from((0.0, 0.01, 0.05, math.nan))),
    )


class TestLaws:
    @given(cases(), strategies.randoms(use_true_random=False))
    def test_a_distribution_shared_evenly_within_groups_whatever_the_order(
        self, case, random
    ):
        estimate, group, counts, error = case
        posterior = PosePrior(estimate, group, error, 0.5).update(counts)
        low, high = posterior.interval()
        assert posterior.probability.sum() == pytest.approx(1.0, abs=1e-12)
        assert posterior.probability.min() > 0.0
        assert (
            (low >= 0.0).all() and (low <= high).all() and (high <= 1.0 + 1e-12).all()
        )
        for group_ in np.unique(group):
            for values in (posterior.probability, posterior.standard_error, low, high):
                assert np.ptp(values[group == group_]) <= 1e-12
        rms = math.sqrt(np.mean(posterior.standard_error**2))
        assert posterior.expected_error == pytest.approx(rms, abs=1e-9)
        order = list(range(len(group)))
        random.shuffle(order)
        reordered = PosePrior(estimate[order], group[order], error, 0.5).update(
            counts[order]
        )
        np.testing.assert_allclose(
            reordered.probability, posterior.probability[order], rtol=1e-9
        )
        assert reordered.error_quantile() == pytest.approx(
            posterior.error_quantile(), rel=1e-6, abs=1e-12
        )


class TestLimits:
    def test_with_ever_more_drops_it_is_the_counts(self):
        """Also in a pose that was ruled out wrongly."""
        estimate = np.array((0.6, 0.3, 0.1, 0.0))
        true = np.array((0.1, 0.4, 0.2, 0.3))
        prior = PosePrior(estimate, range(4), 0.02, 0.5)
        away = [
            np.abs(prior.update(true * n).probability - true).max()
            for n in (0, 10**2, 10**3, 10**4, 10**6)
        ]
        assert away == sorted(away, reverse=True) and away[-1] < 1e-4
        assert prior.update(true * 10**6).expected_error == pytest.approx(
            math.sqrt(np.mean(true * (1.0 - true)) / 10**6), rel=1e-3
        )

    def test_symmetry_leaves_nothing_to_learn(self):
        for shares, counts in ((np.full(6, 1 / 6), [9, 0, 0, 0, 0, 0]), ([1.0], [3])):
            posterior = PosePrior(shares, np.zeros(len(counts), int), 0.0, 0.5).update(
                counts
            )
            np.testing.assert_allclose(posterior.probability, shares)
            np.testing.assert_allclose(posterior.interval(), [shares, shares])
            assert (
                max(
                    posterior.expected_error,
                    posterior.error_quantile(),
                    posterior.largest_error(),
                )
                < 1e-9
            )

    def test_the_evidence_of_all_outcomes_is_one(self):
        prior = PosePrior((0.7, 0.2, 0.1), range(3), 0.05, 0.5)
        total = sum(
            math.exp(prior.log_evidence(np.bincount(drops, minlength=3)))
            for drops in product(range(3), repeat=4)
        )
        assert total == pytest.approx(1.0, abs=1e-9)

    def test_broken_sticks_of_equal_strengths_are_a_dirichlet_distribution(self):
        mean = np.array((0.05, 0.15, 0.3, 0.5))
        counts = np.array((1.0, 0.0, 7.0, 2.0))
        prior = ConnorMosimann.from_means(
            mean, np.full((2, 1, 4), 20.0), np.array((0.3, 0.7))
        )
        posterior = prior.update(counts)[0]
        reference = dirichlet(20.0 * mean + counts)
        np.testing.assert_allclose(
            posterior.moments()[0][0], reference.mean(), rtol=1e-12
        )
        np.testing.assert_allclose(
            posterior.moments()[1][0], reference.var(), rtol=1e-9
        )


@given(
    strategies.floats(1.01, 500.0),
    strategies.floats(1.01, 500.0),
    strategies.sampled_from((0.5, 0.9, 0.99)),
)
def test_the_shortest_interval_of_a_beta_distribution(a, b, level):
    """Against scipy's: it holds its share, and none between other quantiles is
    shorter.
    """
    shortest = beta(a, b)
    (low,), (high,) = shortest_interval(
        np.ones((1, 1)),
        np.array([[shortest.mean()]]),
        np.array([[shortest.var()]]),
        level,
    )
    assert shortest.cdf(high) - shortest.cdf(low) == pytest.approx(level, abs=1e-4)
    below = np.linspace(0.0, 1.0 - level, 20)
    widths = shortest.ppf(np.minimum(below + level, 1.0)) - shortest.ppf(below)
    assert widths.min() >= (high - low) * (
        1.0 - 1e-2
    )  # of a grid, half a percent each end


@pytest.mark.parametrize("probability", [(0.5, 0.5), (0.98, 0.01, 0.01), (1 / 6,) * 6])
@pytest.mark.parametrize("level", [0.5, 0.9])
def test_the_bound_of_all_errors_of_counted_shares(probability, level):
    """Shares of whole drops are coarse; 40 000 runs are known to a quarter of a
    point.
    """
    p = np.array(probability)
    drops = 3000
    bound = largest_error(np.sqrt(p * (1.0 - p) / drops), level)
    samples = np.random.default_rng(1).multinomial(drops, p, size=40_000)
    within = np.abs(samples / drops - p).max(axis=1) <= bound
    assert within.mean() == pytest.approx(level, abs=0.06 if level == 0.5 else 0.035)
    assert largest_error([0.03], level) == pytest.approx(
        0.03 * norm.ppf(0.5 + level / 2.0), rel=6e-3
    )


def test_the_bound_of_errors_that_poses_share():
    """Two units have one error, of which the poses of the smaller one have more.

    40 000 runs are known to a quarter of a point, as above.
    """
    share = 0.56
    drops = 3000
    size = np.array((2, 6))
    deviation = np.full(2, math.sqrt(share * (1.0 - share) / drops))
    bound = largest_error(deviation, 0.9, size=size)
    counts = np.random.default_rng(1).binomial(drops, share, size=40_000)
    within = np.abs(counts / drops - share) / size.min() <= bound
    assert within.mean() == pytest.approx(0.9, abs=0.02)


@pytest.mark.parametrize("drops", [400, 1600])
@pytest.mark.parametrize("offset", [0.03, 0.09])
def test_an_estimate_that_is_wrong_loses(drops, offset):
    """A nut whose ends are off by up to three times what the estimate tells.

    Nine bounds in ten are kept, but for three standard errors of 500 runs and three
    points of what the estimate has its share in.
    """
    ends = np.array((0.56, 0.44))
    unit = np.repeat((0, 1), (2, 6))
    estimate = np.add(ends, (offset, -offset))[unit] / np.bincount(unit)[unit]
    fit = prior_fit(0.5)._replace(
        strange=confidence.STRANGE_CHANCE, doubt=confidence.DOUBT
    )
    prior = PosePrior(estimate, unit, 0.008, 0.5, fit)
    truth = ends[unit] / np.bincount(unit)[unit]
    runs = np.random.default_rng(2).multinomial(drops, truth, size=500)
    kept = []
    for counts in runs:
        posterior = prior.update(counts)
        error = np.abs(posterior.probability - truth).max()
        kept.append(error <= posterior.largest_error())
    assert np.mean(kept) >= 0.9 - 3.0 * math.sqrt(0.09 / 500) - 0.03


@pytest.mark.parametrize("drops", [1, 3, 10, 30, 100])
def test_few_drops_cost_a_good_estimate_little(drops):
    """Exact errors, where an estimate is off by as much as it tells, either way.

    Ten drops alone are off by six times as much; a fifth is what they may add.
    """
    stated_error = 0.025
    estimate = (0.3, 0.7)
    fit = prior_fit(0.5)._replace(
        strange=confidence.STRANGE_CHANCE, doubt=confidence.DOUBT
    )
    prior = PosePrior(estimate, [0, 1], stated_error, 0.5, fit)
    k = np.arange(drops + 1)
    answer = np.array(
        [prior.update([count, drops - count]).probability[0] for count in k.tolist()]
    )
    truth = np.add(estimate[0], (-stated_error, stated_error))[:, None]
    square = (binom.pmf(k, drops, truth) * np.square(answer - truth)).sum(axis=1)
    assert math.sqrt(square.mean()) <= 1.2 * stated_error


def drawn_parts(number, seed=4):
    """Priors, and truths as far from their estimates as their errors say
    (Dirichlet).
    """
    random = np.random.default_rng(seed)
    for _ in range(number):
        poses = int(random.integers(2, 15))
        estimate = random.dirichlet(np.full(poses, 0.5))
        stated_error = math.exp(random.uniform(-5.8, -2.8))
        worth = float(np.mean(estimate * (1.0 - estimate))) / stated_error**2 - 1.0
        yield (
            PosePrior(estimate, np.arange(poses), stated_error, 0.5),
            random.dirichlet(max(worth, 1.0) * estimate + 1e-9),
            random,
        )


@pytest.mark.parametrize("drops", [10, 300, 10_000])
def test_intervals_hold_and_false_alarms_are_rare(drops):
    """Nine in ten, but for four standard errors of 160 parts and two points of the
    form.

    Two thousandths of 160 parts that are as they should be are refuted: 0.3; three
    standard errors more are 2.0.
    """
    alarms = 0
    hits = []
    for prior, true, random in drawn_parts(160):
        counts = random.multinomial(drops, true)
        alarms += bool(prior.contradicted_poses(counts).any())
        low, high = prior.update(counts).interval()
        hits.append(np.mean((low <= true) & (true <= high)))
    assert alarms <= 2
    assert np.mean(hits) == pytest.approx(0.9, abs=4.0 * math.sqrt(0.09 / 160) + 0.02)


def test_only_an_estimate_off_by_far_more_than_it_says_is_refuted():
    """Off by twenty points in the first pose and by ten in two others; a drop refutes
    nothing.
    """
    estimate = (0.4, 0.3, 0.15, 0.1, 0.05)
    offsets = (0.2, -0.1, -0.1, 0.0, 0.0)
    counts = (1000 * np.add(estimate, offsets)).round()
    wrong = [
        PosePrior(estimate, range(5), stated_error, 0.5)
        .contradicted_poses(counts)
        .tolist()
        for stated_error in (0.01, 0.15, math.nan)
    ]
    assert wrong == [[True, True, True, False, False], [False] * 5, [False] * 5]
    for counts_ in ((0, 0, 0, 0, 0), (0, 0, 0, 0, 1)):
        assert (
            not PosePrior(estimate, range(5), 0.02, 0.5)
            .contradicted_poses(counts_)
            .any()
        )
    assert (
        PosePrior((0.4, 0.4, 0.2), (0, 0, 1), 0.005, 0.5)
        .contradicted_poses((100, 100, 800))
        .all()
    )


def test_an_estimate_far_off_costs_next_to_nothing():
    """Exact errors for two poses: a sum over all counts, weighed by their
    probabilities.

    A strange kind starts at a single pseudo-drop; a tenth of the drops would cost 1.1.
    """
    drops = 200
    truth = np.array([0.65, 0.75, 0.9])
    prior = PosePrior(
        [0.4, 0.6], [0, 1], 0.02, 0.5, prior_fit(0.5)._replace(strange=0.8)
    )
    k = np.arange(drops + 1)
    middle = np.array(
        [prior.update([count, drops - count]).probability[0] for count in k.tolist()]
    )
    square = binom.pmf(k, drops, truth[:, None]) * (middle - truth[:, None]) ** 2
    assert (np.sqrt(square.sum(axis=1) / (truth * (1.0 - truth) / drops)) < 1.1).all()


def test_doubt_of_errors_alone_leaves_the_answer_without_drops_as_it_is():
    """Where no part is taken to be strange, the answer comes to doubt by drops."""
    usual = prior_fit(0.5)._replace(strange=0.0, doubt=0.0)
    answers = [
        PosePrior([0.4, 0.6], [0, 1], 0.02, 0.5, fit)
        for fit in (usual, usual._replace(doubt=0.95))
    ]
    before = [prior.update([0, 0]) for prior in answers]
    np.testing.assert_allclose(before[1].probability, [0.4, 0.6], atol=1e-12)
    assert (before[1].standard_error > before[0].standard_error).all()
    after = [prior.update([400, 0]).probability[0] for prior in answers]
    assert after[1] > after[0]
