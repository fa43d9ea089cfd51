"""The bootstrap over bodies against the scatter of fresh data."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.errors import RequestError
from ros_pose_stats.study.errors import bootstrap
from ros_pose_stats.study.errors.bootstrap import body_bootstrap
from ros_pose_stats.study.errors.partition import accuracy
from tests.statistics.simulations import bodies, simulated


def mean(sums):
    return sums[0] / sums[1]


def with_ones(values):
    return np.stack([values, np.ones(len(values))], axis=1)


def clustered(rng, number):
    """Values of which those of a body lie together."""
    body = np.arange(number).repeat(rng.integers(1, 6, number))
    return body, rng.normal(size=number)[body] + 0.3 * rng.normal(size=len(body))


class TestAgainstFreshData:
    # 300 sets of 150 bodies: their scatter is known to 1 / sqrt(600) = 4.1 %. The mean of the
    # bootstrap's errors, each of 200 resamples, is known far better. Four of it are 16 %.
    SETS = 300

    def test_of_a_mean(self):
        # With each value as a body of its own the error comes out near half as large: the up to
        # five values of a body are nearly one.
        rng = np.random.default_rng(1)
        means, told, blind = [], [], []
        for seed in range(self.SETS):
            body, values = clustered(rng, 150)
            means.append(values.mean())
            told.append(body_bootstrap(body, with_ones(values), mean, 200, seed).std(ddof=1))
            blind.append(body_bootstrap(np.arange(len(body)), with_ones(values), mean, 200,
                                        seed).std(ddof=1))
        assert np.mean(told) == pytest.approx(np.std(means, ddof=1), rel=0.16)
        assert np.mean(blind) < 0.7 * np.std(means, ddof=1)

    def test_of_the_error_of_an_estimator(self):
        # Each body is estimated well or badly as a whole. In the mean over bodies the squared
        # error is 0.05². The interval holds the truth in 95 % of the sets: binomial error
        # 1.3 %, and up to 3 % less as 150 bodies with few bad ones are no large sample.
        rng = np.random.default_rng(2)
        errors, told, held = [], [], []
        for seed in range(self.SETS):
            body, p = bodies(rng, 150)
            sizes = 0.05 * np.sqrt(rng.gamma(1.0, 1.0, 150))
            estimate = p + sizes[body] * rng.normal(size=len(p))
            found = accuracy(estimate, simulated(rng, body, p, 100), resamples=200, seed=seed)
            errors.append(found.error)
            told.append(found.standard_error)
            held.append(found.low <= 0.05 <= found.high)
        assert np.mean(told) == pytest.approx(np.std(errors, ddof=1), rel=0.16)
        assert np.mean(held) > 0.95 - 0.03 - 4 * 0.013


class TestBodies:
    def test_a_body_twice_in_itself_tells_nothing_new(self):
        body, values = clustered(np.random.default_rng(3), 200)
        once = body_bootstrap(body, with_ones(values), mean)
        twice = body_bootstrap(np.tile(body, 2), np.tile(with_ones(values), (2, 1)), mean)
        np.testing.assert_allclose(twice, once, rtol=0.0, atol=1e-12)

    def test_as_another_body_it_would(self):
        # 5000 resamples: each error is known to 1 %, their ratio to 1.4 %; five of these.
        body, values = clustered(np.random.default_rng(4), 200)
        once = body_bootstrap(body, with_ones(values), mean, 5000)
        apart = body_bootstrap(np.concatenate([body, body + 200]),
                               np.tile(with_ones(values), (2, 1)), mean, 5000)
        assert once.std() / apart.std() == pytest.approx(math.sqrt(2.0), rel=0.07)

    def test_drawn_as_whole_bodies(self):
        # Each body has a digit of its own in both sums: they show how often it was drawn.
        body = np.array([4, 4, 9, 4, 7])
        digits = {4: 1.0, 7: 10.0, 9: 100.0}
        terms = np.array([[digits[one], 1.0] for one in body.tolist()])
        drawn = body_bootstrap(body, terms, lambda sums: sums[0], 500).astype(int)
        times = np.stack([drawn % 10 / 3, drawn // 10 % 10, drawn // 100], axis=1)
        assert (times.sum(axis=1) == 3).all()
        assert set(np.unique(times)) == {0, 1, 2, 3}
        # Each is drawn once in the mean: standard deviation sqrt(2/3) / sqrt(500), five of it.
        assert times.mean(axis=0) == pytest.approx([1.0] * 3, abs=0.19)
        assert times.var(axis=0) == pytest.approx([2 / 3] * 3, rel=0.35)

    def test_one_body(self):
        found = body_bootstrap([5, 5], [[1.0], [2.0]], lambda sums: sums[0], 4)
        assert found.tolist() == [3.0] * 4


class TestDraws:
    def test_equal_by_seed(self):
        body, values = clustered(np.random.default_rng(5), 40)
        first, again, other = (body_bootstrap(body, with_ones(values), mean, 50, seed)
                               for seed in (7, 7, 8))
        assert first.tolist() == again.tolist()
        assert (first != other).all()

    @pytest.mark.parametrize("cells", [1, 40, 41, 999, 1 << 20])
    def test_memory_is_bounded_without_another_result(self, monkeypatch, cells):
        body, values = clustered(np.random.default_rng(6), 40)
        whole = body_bootstrap(body, with_ones(values), mean, 33)
        asked = []

        def noted(sums):
            asked.append(sums.shape)
            return mean(sums)

        monkeypatch.setattr(bootstrap, "_CELLS", cells)
        monkeypatch.setattr(bootstrap, "_KEPT_CELLS", 0)
        np.testing.assert_allclose(body_bootstrap(body, with_ones(values), noted, 33), whole,
                                   rtol=1e-12)
        assert all(rows == 2 and 40 * made <= max(40, cells) for rows, made in asked)

    @given(st.integers(0, 2 ** 32 - 1), st.integers(1, 60))
    def test_the_order_of_the_values_is_no_matter(self, seed, number):
        rng = np.random.default_rng(seed)
        body, terms = rng.integers(0, 12, number), rng.normal(size=(number, 3))
        order = rng.permutation(number)
        found = body_bootstrap(body, terms, lambda sums: sums.sum(axis=0), 20)
        np.testing.assert_allclose(
            body_bootstrap(body[order], terms[order], lambda sums: sums.sum(axis=0), 20), found,
            rtol=0.0, atol=1e-9)

    @given(st.integers(0, 2 ** 32 - 1), st.floats(-50.0, 50.0))
    def test_scale(self, seed, factor):
        rng = np.random.default_rng(seed)
        body, terms = rng.integers(0, 9, 30), with_ones(rng.normal(size=30))
        np.testing.assert_allclose(body_bootstrap(body, terms * (factor, 1.0), mean, 20),
                                   factor * body_bootstrap(body, terms, mean, 20),
                                   rtol=0.0, atol=1e-11)


@pytest.mark.parametrize(("body", "terms", "resamples", "seed"), [
    ([], np.empty((0, 1)), 10, 0), ([0, 1], [[1.0]], 10, 0), ([0], [1.0], 10, 0),
    ([[0]], [[1.0]], 10, 0), ([0.0], [[1.0]], 10, 0), ([0], [[math.nan]], 10, 0),
    ([0], [[1.0]], 1, 0), ([0], [[1.0]], 10, -1),
])
def test_refused(body, terms, resamples, seed):
    with pytest.raises(RequestError, match="expected"):
        body_bootstrap(body, terms, lambda sums: sums[0], resamples, seed)


def test_remembered_weights_give_the_same(monkeypatch):
    body, values = np.arange(50) % 7, np.random.default_rng(5).normal(size=50)
    kept = [body_bootstrap(body, values[:, None], lambda sums: sums[0], 30, seed)
            for seed in (1, 2, 1)]
    monkeypatch.setattr(bootstrap, "_KEPT_CELLS", 0)
    fresh = [body_bootstrap(body, values[:, None], lambda sums: sums[0], 30, seed)
             for seed in (1, 2)]
    np.testing.assert_array_equal(kept, [*fresh, fresh[0]])
    assert not np.array_equal(*fresh)
