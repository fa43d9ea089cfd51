"""Poses that symmetry makes alike, told together: totals, intervals, order."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ros_pose_stats import estimate, hybrid, part_from_mesh, shapes, simulate
from ros_pose_stats.statistics.pose_groups import pose_groups, single_poses
from ros_pose_stats.text import ranges

DROPS = 300


@pytest.fixture(scope="module")
def prism():
    """A hexagonal prism: six sides alike, and two ends."""
    angles = np.arange(6) * math.pi / 3.0
    rim = np.column_stack([0.01 * np.cos(angles), 0.01 * np.sin(angles)])
    points = np.vstack([np.column_stack([rim, np.full(6, z)]) for z in (-0.008, 0.008)])
    return part_from_mesh(*shapes.hull_mesh(points))


def test_a_group_holds_what_the_library_says_it_holds(prism):
    found = estimate(prism)
    groups = pose_groups(found)
    assert sorted(group.size for group in groups) == [2, 6]
    assert sorted(index for group in groups for index in group.indices) == list(range(8))
    for group in groups:
        assert group.first is min(group.poses, key=lambda pose: pose.index)
        assert {pose.group_size for pose in group.poses} == {group.size}
        assert {pose.group_probability for pose in group.poses} == {group.probability}
    shares = [group.probability for group in groups]
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) == pytest.approx(1.0)


def test_the_interval_of_counted_poses_is_that_of_their_sum(prism):
    for group in pose_groups(simulate(prism, DROPS, seed=1)):
        assert group.count == sum(pose.count for pose in group.poses)
        assert group.probability == pytest.approx(group.count / DROPS)
        expected = stats.beta(group.count + 0.5, DROPS - group.count + 0.5).ppf([0.05, 0.95])
        assert (group.probability_low, group.probability_high) == pytest.approx(expected)


def test_the_intervals_of_totals_keep_their_promise(prism):
    true = {group.first.group: group.probability
            for group in pose_groups(simulate(prism, 40_000, seed=99))}
    held = [group.probability_low <= true[group.first.group] <= group.probability_high
            for seed in range(150) for group in pose_groups(simulate(prism, 60, seed=seed))]
    assert 0.84 < np.mean(held) < 0.97


@pytest.mark.parametrize("method", [estimate, lambda part: hybrid(part, 100, seed=3)])
def test_methods_that_know_of_the_symmetry_share_one_error(prism, method):
    for group in pose_groups(method(prism)):
        one = group.first
        assert group.probability_low == pytest.approx(group.size * one.probability_low)
        assert group.probability_high == pytest.approx(
            min(1.0, group.size * one.probability_high))


def test_what_is_not_known_stays_unknown(prism):
    found = estimate(prism)
    poses = tuple(pose.with_probability(pose.probability) for pose in found.poses)
    for group in pose_groups(replace(found, poses=poses)):
        assert math.isnan(group.probability_low) and math.isnan(group.probability_high)
    for group in pose_groups(replace(found, poses=tuple(
            pose.with_probability(math.nan) for pose in poses))):
        assert math.isnan(group.probability)


def test_a_pose_by_itself_is_told_as_it_is(prism):
    found = simulate(prism, DROPS, seed=1, sampling="lattice")
    assert [one.first for one in single_poses(found)] == list(found.poses)
    for one in single_poses(found):
        pose = one.first
        assert (one.probability, one.probability_low, one.probability_high, one.count) == (
            pose.probability, pose.probability_low, pose.probability_high, pose.count)


@pytest.mark.parametrize(("numbers", "said"), [
    ((), ""), ((3,), "3"), ((0, 1), "0, 1"), ((0, 1, 2), "0-2"), ((0, 1, 4), "0, 1, 4"),
    ((0, 2, 3, 4, 9, 10), "0, 2-4, 9, 10")])
def test_numbers_in_a_row_are_told_by_their_ends(numbers, said):
    assert ranges(numbers) == said
