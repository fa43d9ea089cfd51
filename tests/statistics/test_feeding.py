"""Feeding by closed forms of small chains, played out part by part, and its intervals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import PoseStatsError, estimate, part_from_mesh, shapes, simulate
from ros_pose_stats.planning.hybrid import hybrid
from ros_pose_stats.statistics.feeding import (
    PoseShares,
    drop_afresh,
    flip_wrong_ones,
    pose_shares,
)

from ..bodies import random_polyhedron

FRESH = np.array([0.5, 0.3, 0.15, 0.05])
MATRIX = np.array([[0.7, 0.2, 0.1, 0.0], [0.3, 0.6, 0.05, 0.05], [0.2, 0.1, 0.6, 0.1],
                   [0.1, 0.3, 0.2, 0.4]])


def shares(probability, drops=math.inf, unit=None):
    size = len(probability)
    return PoseShares(np.array(probability), drops, np.arange(size) if unit is None
                      else np.array(unit))


class TestAfresh:
    def test_half_of_them(self):
        found = drop_afresh(shares([0.5, 0.25, 0.25]), [1, 2], 40.0)
        assert found.accepted.value == 0.5 and found.passes.value == 2.0
        assert found.flips.value == 0.0 and found.per_minute.value == 20.0

    def test_a_pose_that_never_comes(self):
        found = drop_afresh(shares([1.0, 0.0], 50), [1], 40.0)
        assert found.passes.value == math.inf and found.per_minute.value == 0.0
        assert 0.0 < found.per_minute.high < 4.0

    def test_no_error_known(self):
        found = drop_afresh(shares([0.6, 0.4], math.nan), [0], 10.0)
        assert found.accepted.value == 0.6 and math.isnan(found.accepted.low)


class TestFlips:
    def test_two_poses(self):
        """A geometric series: out of the wrong pose with one chance in four."""
        found = flip_wrong_ones(shares([0.8, 0.2]), [[1, 0], [250, 750]], [0], 30.0, 3.0)
        assert found.flips.value == pytest.approx(0.2 * 4.0)
        assert found.per_minute.value == pytest.approx(60.0 / (2.0 + 0.8 * 3.0))
        assert found.accepted.value == found.passes.value == 1.0

    def test_played_out(self):
        """Flips of 40 000 parts, one by one."""
        random, flips = np.random.default_rng(3), []
        for pose in random.choice(4, 40_000, p=FRESH):
            count = 0
            while pose != 1:
                pose, count = random.choice(4, p=MATRIX[pose]), count + 1
            flips.append(count)
        found = flip_wrong_ones(shares(FRESH), 1e6 * MATRIX, [1], 60.0, 1.0)
        error = np.std(flips) / math.sqrt(len(flips))
        assert found.flips.value == pytest.approx(np.mean(flips), abs=4.0 * error)

    def test_a_pose_that_keeps_its_parts(self):
        found = flip_wrong_ones(shares([0.5, 0.4, 0.1]),
                                [[9, 1, 0], [5, 5, 0], [0, 0, 10]], [0], 30.0, 1.0)
        assert found.flips.value == math.inf and found.per_minute.value == 0.0

    def test_all_wanted(self):
        found = flip_wrong_ones(shares([0.5, 0.5]), np.eye(2), [0, 1], 30.0, 1.0)
        assert found.flips.value == 0.0 and found.per_minute == (30.0, 30.0, 30.0)


def test_intervals_are_kept():
    """Nine in ten, within 4 standard errors of 600 trials, and 0.01 for the first order."""
    truth = flip_wrong_ones(shares(FRESH), 1e9 * MATRIX, [0], 60.0, 2.0)
    afresh = drop_afresh(shares(FRESH), [0], 60.0)
    random, kept, kept_afresh, trials = np.random.default_rng(5), 0, 0, 600
    for _ in range(trials):
        counts = np.stack([random.multinomial(150, row) for row in MATRIX])
        drops = random.multinomial(400, FRESH)
        seen = shares(drops / 400, 400)
        low, high = flip_wrong_ones(seen, counts, [0], 60.0, 2.0).per_minute[1:]
        kept += low <= truth.per_minute.value <= high
        low, high = drop_afresh(seen, [0], 60.0).per_minute[1:]
        kept_afresh += low <= afresh.per_minute.value <= high
    slack = 4.0 * math.sqrt(0.09 / trials) + 0.01
    assert kept / trials == pytest.approx(0.9, abs=slack)
    assert kept_afresh / trials == pytest.approx(0.9, abs=slack)


@pytest.mark.parametrize(("wanted", "rate", "cycle", "words"), [
    ([], 1.0, 1.0, "at least one"), ([4], 1.0, 1.0, "out of 0 to 3"), ([-1], 1.0, 1.0, "0 to 3"),
    ([0], 0.0, 1.0, "rate above 0"), ([0], math.nan, 1.0, "rate above 0"),
    ([0], 1.0, -1.0, "cycle time")])
def test_refusals(wanted, rate, cycle, words):
    with pytest.raises(PoseStatsError, match=words):
        flip_wrong_ones(shares(FRESH), 100 * MATRIX, wanted, rate, cycle)


def test_flips_that_are_missing():
    with pytest.raises(PoseStatsError, match="none out of pose 1"):
        flip_wrong_ones(shares([0.5, 0.5]), [[5, 5], [0, 0]], [0], 1.0, 1.0)
