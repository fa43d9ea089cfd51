"""Calibration of counts that are binomial, and of counts that are not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import hypergeom

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.errors import root_mean_square, standard_errors
from ros_pose_stats.statistics.intervals import jeffreys_interval
from ros_pose_stats.study.errors.calibration import calibration
from ros_pose_stats.study.errors.simulated_poses import SimulatedPoses, pooled
from tests.statistics.simulations import bodies, simulated


def pair(rng, body, p, first, second):
    return simulated(rng, body, p, first), simulated(rng, body, p, second)


def overdispersed(rng, body, p, drops, factor):
    """Counts whose variance is `factor` times the binomial one: Dirichlet-multinomial."""
    strength = (drops - factor) / (factor - 1.0)
    shaken = rng.gamma(strength * p)
    return simulated(rng, body, shaken / np.bincount(body, shaken)[body], drops)


def by_definition(first, second, level):
    """z and whether it is held, body by body and with the functions that are tested."""
    z, held = [], []
    for body in np.unique(first.body):
        of = first.body == body
        n, m = int(first.settled[of][0]), int(second.settled[of][0])
        error = np.hypot(standard_errors(first.count[of], n), standard_errors(second.count[of], m))
        z += ((first.count[of] / n - second.count[of] / m) / error).tolist()
        low, high = jeffreys_interval(first.count[of], n, level)
        s = second.count[of] / m
        held += ((low <= s) & (s <= high)).tolist()
    return root_mean_square(z), np.mean(held)


def test_by_definition():
    rng = np.random.default_rng(1)
    body, p = bodies(rng, 50)
    first, second = pair(rng, body, p, rng.integers(1, 80, 50), rng.integers(1, 900, 50))
    found = calibration(first, second, 0.8)
    z, held = by_definition(first, second, 0.8)
    assert found.z_rms == pytest.approx(z, rel=1e-12)
    assert found.coverage == held
    assert found.values == len(body)


@pytest.mark.parametrize(("settled", "counts"), [
    ((6, 9), ((0, 2, 4), (1, 0, 8))), ((3, 1), ((0, 3, 0), (0, 1, 0))), ((40, 3), ((20, 20, 0),
                                                                           (3, 0, 0)))])
def test_expectations_by_enumeration(settled, counts):
    # All ways to share each pose's total between the runs.
    n, m = settled
    first, second = (SimulatedPoses([5] * 3, one, [k] * 3)
                     for one, k in zip(counts, settled, strict=True))
    squares, held = [], []
    for total in np.add(*counts):
        shares = [c for c in range(n + 1) if 0 <= total - c <= m]
        weights = hypergeom(n + m, total, n).pmf(shares)
        # `standard_errors` of a pose among three with any counts of the other two.
        z = [(c / n - (total - c) / m) / math.hypot(standard_errors([c, 0, 0], n)[0],
                                                    standard_errors([total - c, 0, 0], m)[0])
             for c in shares]
        bounds = [jeffreys_interval(c, n) for c in shares]
        squares.append(weights @ np.square(z))
        held.append(weights @ [low <= (total - c) / m <= high
                               for c, (low, high) in zip(shares, bounds, strict=True)])
    found = calibration(first, second)
    assert found.expected_z_rms == pytest.approx(math.sqrt(np.mean(squares)), rel=1e-9)
    assert found.expected_coverage == pytest.approx(np.mean(held), rel=1e-9)
    assert found.certain == sum(total in (0, n + m) for total in np.add(*counts))
    assert math.isnan(found.z_rms_error) and math.isnan(found.coverage_error)


@pytest.mark.parametrize("cells", [1, 1000])
def test_expectations_piece_by_piece(monkeypatch, cells):
    rng = np.random.default_rng(2)
    body, p = bodies(rng, 30)
    runs = pair(rng, body, p, 50, 200)
    whole = calibration(*runs)
    monkeypatch.setattr("ros_pose_stats.study.errors.calibration._CELLS", cells)
    assert calibration(*runs).expected_z_rms == pytest.approx(whole.expected_z_rms, rel=1e-12)


def test_expectations_of_many_drops():
    # Only the likely shares are summed; compared with all of them.
    n, m, total = 3000, 5000, (3, 2401, 5596)
    first = SimulatedPoses([0] * 3, [1, 899, 2100], [n] * 3)
    second = SimulatedPoses([0] * 3, [2, 1502, 3496], [m] * 3)
    held = []
    for t in total:
        c = np.arange(max(0, t - m), min(n, t) + 1)
        low, high = jeffreys_interval(c, n)
        s = (t - c) / m
        held.append(hypergeom(n + m, t, n).pmf(c) @ ((low <= s) & (s <= high)))
    assert calibration(first, second).expected_coverage == pytest.approx(np.mean(held), rel=1e-8)


@pytest.mark.parametrize(("first", "second", "strength"), [
    (100, 1000, 1.0), (100, 100, 0.3), (20, 2000, 1.0), (500, 100_000, 20.0)])
def test_independent_drops_are_as_expected(first, second, strength):
    # 40 sets of 60 bodies, rare poses among them; four standard errors of the mean difference.
    rng = np.random.default_rng(first + second)
    squares, held = [], []
    for _ in range(40):
        body, p = bodies(rng, 60, strength)
        found = calibration(*pair(rng, body, p, first, second), resamples=2)
        squares.append(found.z_rms ** 2 - found.expected_z_rms ** 2)
        held.append(found.coverage - found.expected_coverage)
    for off, sharp in ((squares, 0.15), (held, 0.03)):
        bound = 4.0 * np.std(off) / math.sqrt(40)
        assert bound < sharp
        assert np.mean(off) == pytest.approx(0.0, abs=bound)


def test_frequent_poses_have_a_z_of_1():
    # About 400 bodies of 5 poses, none rare: known to 1 / sqrt(2 · 1600) = 1.8 %; four of it.
    rng = np.random.default_rng(3)
    body, p = bodies(rng, 400, strength=30.0)
    found = calibration(*pair(rng, body, p, 400, 4000))
    assert found.z_rms == pytest.approx(1.0, rel=0.07)
    assert found.expected_z_rms == pytest.approx(1.0, abs=0.02)
    assert found.z_rms_error == pytest.approx(0.018, rel=0.3)


@pytest.mark.parametrize(("second", "expected"), [(1_000_000, 0.9), (1000, 0.755)])
def test_the_noise_of_the_second_run_lowers_the_coverage(second, expected):
    # 0.755 = 2 Phi(1.645 / sqrt 2) - 1 for equally long runs. Counts are whole numbers: 0.01.
    rng = np.random.default_rng(4)
    body, p = bodies(rng, 200, strength=30.0)
    found = calibration(*pair(rng, body, p, 1000, second))
    assert found.expected_coverage == pytest.approx(expected, abs=0.01)
    # The binomial error of 800 free values is 1.5 % at most; four of it.
    assert found.coverage == pytest.approx(found.expected_coverage, abs=0.06)


def test_overdispersed_counts_are_found():
    # Twice the variance: z is 1.41, known to 2.5 % by the 800 free values; four of it. Of a
    # normal value 2 Phi(1.645 / sqrt 2) - 1 = 0.755 is held; binomial error 1.5 %.
    rng = np.random.default_rng(5)
    body, p = bodies(rng, 200, strength=30.0)
    found = calibration(overdispersed(rng, body, p, 400, 2.0),
                        simulated(rng, body, p, 100_000))
    assert found.z_rms == pytest.approx(math.sqrt(2.0), rel=0.1)
    assert found.z_rms > found.expected_z_rms + 5.0 * found.z_rms_error
    assert found.coverage == pytest.approx(0.755, abs=0.06)
    assert found.coverage < found.expected_coverage - 5.0 * found.coverage_error


def test_certain_poses_feign_no_misfit():
    # A body with a single pose, and one with a pose that is never seen.
    first = SimulatedPoses([0, 1, 1, 2, 2], [9, 9, 0, 4, 5], [9] * 5)
    second = SimulatedPoses([0, 1, 1, 2, 2], [70, 70, 0, 30, 40], [70] * 5)
    found, without = calibration(first, second), calibration(*(
        SimulatedPoses([2, 2], one.count[3:], one.settled[3:]) for one in (first, second)))
    assert found.certain == 3
    assert found.z_rms / found.expected_z_rms == pytest.approx(
        without.z_rms / without.expected_z_rms)
    assert 5 * (1.0 - found.expected_coverage) == pytest.approx(
        2 * (1.0 - without.expected_coverage))


def test_by_seed():
    rng = np.random.default_rng(6)
    body, p = bodies(rng, 30)
    runs = pair(rng, body, p, 50, 200)
    first, again, other = (calibration(*runs, seed=seed) for seed in (1, 1, 2))
    assert first == again
    assert first.z_rms_error != other.z_rms_error
    assert first.z_rms == other.z_rms


def test_restitutions_one_after_the_other():
    rng = np.random.default_rng(7)
    body, p = bodies(rng, 10)
    low, high = pair(rng, body, p, 50, 200), pair(rng, body, p, 60, 200)
    found = calibration(*(pooled(parts) for parts in zip(low, high, strict=True)))
    single = [calibration(*one) for one in (low, high)]
    assert found.z_rms ** 2 == pytest.approx(np.mean([one.z_rms ** 2 for one in single]))
    assert found.coverage == pytest.approx(np.mean([one.coverage for one in single]))


class TestRefused:
    run = SimulatedPoses([0, 0, 1, 1], [1, 3, 2, 2], [4] * 4)

    @pytest.mark.parametrize(("body", "counts", "told"), [
        ([0, 0, 1, 2], [1, 3, 2, 2], "same poses"), ([0, 0, 1, 1], [1, 3, 2, 1], "3 of 4")])
    def test_poses(self, body, counts, told):
        other = SimulatedPoses(body, counts, [4] * 4)
        for runs in ((self.run, other), (other, self.run)):
            with pytest.raises(RequestError, match=told):
                calibration(*runs)

    def test_bodies_that_are_interleaved(self):
        mixed = SimulatedPoses([0, 1, 0, 1], [1, 2, 3, 2], [4] * 4)
        with pytest.raises(RequestError, match="in a row"):
            calibration(mixed, mixed)

    @pytest.mark.parametrize("level", [0.0, 1.0])
    def test_level(self, level):
        with pytest.raises(RequestError, match="level"):
            calibration(self.run, self.run, level)
