"""Feeding by closed forms of small chains, played out part by part, and its intervals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ros_pose_stats import (
    PoseStatsError,
    estimate,
    part_from_mesh,
    shapes,
    simulate,
    simulate_flips,
)
from ros_pose_stats.planning.hybrid import hybrid
from ros_pose_stats.records import DropScene
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_motions, drop_rules, states_at_rest
from ros_pose_stats.simulation.kicks import kicks_of
from ros_pose_stats.statistics.feeding import drop_afresh, flip_wrong_ones
from ros_pose_stats.statistics.pose_shares import PoseShares, pose_shares

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
        # Five in ten lie right, and of the four in ten all get there that are not kept.
        assert found.accepted.value == pytest.approx(0.9)

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


class TestShares:
    def test_of_counts_are_the_drops(self):
        part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
        found = pose_shares(simulate(part, 300, seed=1, workers=1))
        assert found.drops == 300.0 and len(set(found.unit.tolist())) == 6

    def test_alike_poses_of_an_estimate_share_their_error(self):
        """Of a square prism the share of the two ends is unsure; how it is parted is not."""
        found = estimate(part_from_mesh(*shapes.box(1.0, 1.0, 1.3)))
        groups = {}
        for pose in found.poses:
            groups.setdefault(pose.group, []).append(pose)
        ends = next(poses for poses in groups.values() if len(poses) == 2)
        dropped = pose_shares(found)
        both = drop_afresh(dropped, [pose.index for pose in ends]).accepted
        one = drop_afresh(dropped, [ends[0].index]).accepted
        error = 2.0 * ends[0].standard_error
        assert (both.high - both.low) / (2.0 * 1.645 * error) == pytest.approx(1.0, abs=0.1)
        assert one.value == pytest.approx(0.5 * both.value)
        assert one.high - one.low == pytest.approx(0.5 * (both.high - both.low), rel=0.1)

    def test_what_symmetry_decides_is_certain(self):
        found = drop_afresh(pose_shares(estimate(part_from_mesh(*shapes.box(1.0, 1.0, 1.0)))), [3])
        assert found.accepted == pytest.approx((1 / 6, 1 / 6, 1 / 6))

    def test_shares_of_one_unit_may_round_to_above_one(self):
        found = estimate(part_from_mesh(*shapes.box(1.0, 1.0, 1.0)))
        above = 1.0 / 6.0 + 1e-16
        rounded = replace(found, poses=tuple(
            replace(pose, probability=above, standard_error=1e-9) for pose in found.poses))
        accepted = drop_afresh(pose_shares(rounded), range(6)).accepted
        assert accepted == pytest.approx((1.0, 1.0, 1.0))

    def test_drops_beside_an_estimate_make_it_surer(self):
        part = part_from_mesh(*random_polyhedron(9, 4))
        widths = [np.ptp(drop_afresh(pose_shares(found), [0, 1]).accepted[1:])
                  for found in (estimate(part), hybrid(part, 2000, seed=1, workers=1))]
        assert 0.0 < widths[1] < 0.5 * widths[0]

    def test_an_unknown_error_gives_no_bounds(self):
        found = estimate(part_from_mesh(*random_polyhedron(9, 4)))
        poses = [pose.with_probability(pose.probability) for pose in found.poses]
        accepted = drop_afresh(pose_shares(replace(found, poses=poses)), [0]).accepted
        assert 0.0 < accepted.value < 1.0 and math.isnan(accepted.low)

    def test_nothing_counted_is_refused(self):
        part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
        found = simulate(part, 10, seed=1, workers=1)
        poses = [pose.with_probability(math.nan) for pose in found.poses]
        with pytest.raises(PoseStatsError, match="drop the part more often"):
            pose_shares(replace(found, poses=poses))


def test_intervals_of_estimates_are_kept():
    """Of bodies that the estimator has not seen, against drops of their own.

    The drops' noise is taken off the misses: with 1000 of them 0.7 standard errors either way is
    half of what it adds. Kept are nine in ten; 60 sets of 20 bodies are some 30 independent ones,
    so four standard errors are 0.22.
    """
    random, kept = np.random.default_rng(6), []
    for seed in range(20):
        part = part_from_mesh(*random_polyhedron(6 + seed % 7, 1000 + seed))
        dropped = pose_shares(estimate(part))
        truth = simulate(part, 1000, seed=seed)
        shares_ = {pose.index: pose.probability for pose in truth.poses}
        poses = len(shares_)
        for _ in range(3):
            wanted = random.choice(poses, max(1, poses // 2), replace=False)
            share = sum(shares_[int(index)] for index in wanted)
            noise = 0.7 * math.sqrt(share * (1.0 - share) / 1000)
            _, low, high = drop_afresh(dropped, wanted).accepted
            kept.append(low - noise <= share <= high + noise)
    assert np.mean(kept) > 0.9 - 0.22


class TestAgainstSimulation:
    """Feeding of a real body, played out by drops and flips of other seeds."""

    def test_parts_are_dropped_and_flipped_one_by_one(self):
        part = part_from_mesh(*random_polyhedron(8, 21))
        kick, wanted = 0.4, [0, 1]
        fresh = simulate(part, 4000, seed=1)
        flips = simulate_flips(part, kick, 1500, seed=2)
        found = flip_wrong_ones(pose_shares(fresh), flips.counts, wanted, 60.0, 1.0)
        needed = play_out(part, kick, wanted, 4000)
        error = np.std(needed) / math.sqrt(len(needed))
        told = (found.flips.high - found.flips.low) / (2.0 * 1.645)
        assert found.flips.value == pytest.approx(np.mean(needed),
                                                  abs=4.0 * math.hypot(error, told))
        share = np.mean(needed == 0)
        accepted = drop_afresh(pose_shares(fresh), wanted).accepted.value
        assert accepted == pytest.approx(share, abs=4.0 * math.sqrt(2.0 * 0.25 / 4000))


def play_out(part, kick, wanted, count):
    """Flips (count,) that each of some parts took, kicked one after the other by the kernels."""
    body = drop_body(part, 0.0025, 192)
    rules, kicks = drop_rules(DropScene(), body.radius), kicks_of(body, kick / body.radius)
    poses = len(body.resting.poses)
    lying = simulate_poses(body, rules, count)
    needed, round_ = np.zeros(count, dtype=int), 0
    while not np.isin(lying, wanted).all():
        wrong = np.flatnonzero(~np.isin(lying, wanted))
        # Kick k goes out of pose k modulo their number: each part takes one of its own.
        numbers = (round_ * count + wrong) * poses + lying[wrong]
        states = np.concatenate([kicks.states(99, int(number), 1) for number in numbers])
        outcome = compute_motions(body, rules, states).pose
        settled = outcome >= 0
        lying[wrong[settled]] = outcome[settled]
        needed[wrong[settled]] += 1
        round_ += 1
    return needed


def simulate_poses(body, rules, count):
    """Poses (count,) of drops from random orientations."""
    downs = np.random.default_rng(77).standard_normal((count, 3))
    downs /= np.linalg.norm(downs, axis=1)[:, None]
    heights = np.full(count, 20.0)
    found = compute_motions(body, rules, states_at_rest(body, heights, downs)).pose
    assert (found >= 0).all()
    return found.astype(int)


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
