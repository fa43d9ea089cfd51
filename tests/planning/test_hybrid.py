"""Estimate and drops combined: the drops are those of a simulation, the answer is surer."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from ros_pose_stats import (
    DropScene,
    estimate,
    hybrid,
    part_from_mesh,
    resting_poses,
    shapes,
    simulate,
)
from ros_pose_stats.errors import RequestError
from ros_pose_stats.planning.confidence import judge_drops, pose_prior
from ros_pose_stats.planning.hybrid import FIRST_LOOK, hybrid_statistics
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron
from ros_pose_stats.statistics.error_bound import counted_bound
from ros_pose_stats.statistics.posterior.fitted import FITTED_METHOD


def by_index(found, name="probability"):
    return np.array([getattr(pose, name) for pose in sorted(found.poses,
                                                            key=lambda pose: pose.index)])


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


@pytest.fixture(scope="module")
def part():
    return random_polyhedron(5, 2, 0.25).part()


def test_counts_and_scene_are_those_of_the_simulation(part):
    found = hybrid(part, 200, 0.3, 7, workers=1)
    same = simulate(part, 200, 0.3, 7, workers=1)
    assert found.method == "hybrid"
    assert by_index(found, "count").tolist() == by_index(same, "count").tolist()
    for name in ("drops", "unsettled", "seed", "drop_height", "part_digest", "restitution"):
        assert getattr(found, name) == getattr(same, name)
    assert by_index(found).sum() == pytest.approx(1.0)
    assert [pose.probability for pose in found.poses] == sorted(by_index(found), reverse=True)
    assert found.choice == ""


def test_it_lies_between_estimate_and_counts_and_is_surer(part):
    found, counted = hybrid(part, 100, seed=3, workers=1), simulate(part, 100, seed=3, workers=1)
    guess = estimate(part, FITTED_METHOD)
    assert found.expected_error < min(counted.expected_error, guess.expected_error)
    assert rms(by_index(found) - by_index(counted)) < rms(by_index(guess) - by_index(counted))
    low, high = by_index(found, "probability_low"), by_index(found, "probability_high")
    assert (low <= high).all()
    assert (high - low).mean() < np.mean(by_index(counted, "probability_high")
                                         - by_index(counted, "probability_low"))


@pytest.mark.parametrize("workers", [1, 3])
def test_a_target_ends_it_at_a_fixed_prefix_whatever_the_workers(part, workers):
    found = hybrid(part, 10_000, seed=1, target_error=0.02, workers=workers)
    again = hybrid(part, found.drops, seed=1, workers=1)
    counts, prior = by_index(found, "count"), pose_prior(resting_poses(part), DropScene())
    assert judge_drops(prior, counts).bound <= 0.02 < counted_bound(counts)
    assert by_index(found).tolist() == by_index(again).tolist()


def test_the_first_look_is_early(part):
    assert hybrid(part, seed=1, target_error=0.2, workers=1).drops == FIRST_LOOK


def test_a_target_out_of_reach_is_told(part):
    found = hybrid(part, 50, seed=1, target_error=0.001, workers=1)
    assert any(line.startswith("TARGET_MISSED") for line in found.warnings)


def test_progress_carries_the_hybrid_and_a_stop_is_heeded(part):
    told = []
    found = hybrid(part, 1_000_000, seed=1, workers=1, on_progress=told.append,
                   should_stop=lambda: len(told) > 2)
    assert 0 < found.drops < 1_000_000
    assert told[-1].statistics().method == "hybrid"
    assert told[-1].expected_error == pytest.approx(found.expected_error)


def test_poses_of_a_group_share_their_counts():
    part = part_from_mesh(*shapes.box(0.02, 0.03, 0.04))
    found = hybrid(part, 300, seed=2, workers=1)
    for group in {pose.group for pose in found.poses}:
        same = {pose.probability for pose in found.poses if pose.group == group}
        assert max(same) - min(same) < 1e-12
    # Pooling pairs halves the variance; the estimate does the rest.
    assert found.expected_error < simulate(part, 300, seed=2).expected_error / math.sqrt(2.0)


def test_a_low_drop_has_a_prior_of_its_own(part):
    resting, low = resting_poses(part), 1.5 * resting_poses(part).body.radius
    near, far = (pose_prior(resting, DropScene(0.5, height)) for height in (low, None))
    assert min(near.strength, far.strength) > 20.0
    assert np.abs(near.mean - far.mean).max() > 0.0005


def test_a_low_drop_that_the_estimate_does_not_know_leaves_the_say_to_the_drops(part):
    resting = resting_poses(part)
    low = 1.5 * resting.body.radius
    prior = pose_prior(resting, DropScene(0.5, low), "combined")
    assert prior.strength < 2.0
    assert pose_prior(resting, DropScene(0.5, None), "combined").strength > 20.0
    counted = simulate(part, 500, 0.5, 4, low, workers=1)
    assert rms(by_index(hybrid_statistics(counted, prior)) - by_index(counted)) < 0.01


def test_counts_at_any_moment(part):
    """What the node does with a job's counts."""
    prior = pose_prior(resting_poses(part), DropScene())
    counted = simulate(part, 64, seed=8, workers=1)
    found = hybrid_statistics(counted, prior)
    assert by_index(found).tolist() == by_index(hybrid(part, 64, seed=8, workers=1)).tolist()
    with pytest.raises(RequestError, match="counts from 0 up"):
        hybrid_statistics(simulate(part_from_mesh(*shapes.tetrahedron()), 5, seed=1), prior)


@pytest.mark.long
def test_the_error_over_parts_is_less_than_either_alone():
    """24 parts that no fit has seen, 100 drops of each, five times over.

    Drawn anew, the parts give a ratio to the better one that scatters by 0.06.
    """
    squares = {name: [] for name in ("hybrid", "counted", "estimated")}
    for number in range(24):
        part = random_polyhedron(99, number, 0.25).part()
        true = by_index(simulate(part, 1500, seed=10_000 + number, cluster_tolerance=0.0))
        prior = pose_prior(resting_poses(part, 0.0), DropScene(cluster_tolerance=0.0))
        for seed in range(5):
            counted = simulate(part, 100, seed=100 * seed + number, cluster_tolerance=0.0)
            answers = {"counted": counted, "hybrid": hybrid_statistics(counted, prior),
                       "estimated": estimate(part, FITTED_METHOD, cluster_tolerance=0.0)}
            for name, answer in answers.items():
                squares[name] += np.square(by_index(answer) - true).tolist()
    errors = {name: math.sqrt(np.mean(values)) for name, values in squares.items()}
    assert errors["hybrid"] < 1.02 * min(errors["counted"], errors["estimated"]), errors
    assert errors["hybrid"] < 0.8 * errors["counted"], errors


@pytest.mark.parametrize("options", [
    {"restitution": 1.0}, {"drops": 0}, {"target_error": 1.0}, {"seed": -1}, {"workers": 0},
    {"drop_height": 0.0}, {"cluster_tolerance": -1.0}])
def test_refusals(part, options):
    with pytest.raises(RequestError, match=r"expected .*, got .*; "):
        hybrid(part, **options)


def test_the_bound_of_every_pose_shrinks_with_the_drops(part):
    bounds = [hybrid(part, drops, seed=3, workers=1).largest_error for drops in (10, 300, 3000)]
    assert bounds == sorted(bounds, reverse=True)
    found = hybrid(part, 300, seed=3, workers=1)
    errors = by_index(found, "standard_error")
    assert errors.max() < found.largest_error < 4.0 * errors.max()


@pytest.fixture
def deceived(monkeypatch):
    """An estimator that turns the probabilities round and says that it is sure."""
    true = sys.modules["ros_pose_stats.planning.confidence"].estimated
    monkeypatch.setattr("ros_pose_stats.planning.confidence.estimated",
                        lambda *given: true(*given)[::-1].copy())


class TestAConflict:
    def test_the_drops_win_and_the_poses_are_named(self, part, deceived):
        found, counted = hybrid(part, 1000, seed=3), simulate(part, 1000, seed=3)
        assert found.method == "simulation"
        for name in ("probability", "probability_low", "probability_high", "standard_error"):
            assert by_index(found, name).tolist() == by_index(counted, name).tolist()
        assert (found.expected_error, found.largest_error) == (
            counted.expected_error, counted.largest_error)
        (line,) = (line for line in found.warnings if line.startswith("CONFLICT: "))
        share = by_index(counted)
        apart = np.abs(share - pose_prior(resting_poses(part), DropScene()).mean)
        worst = apart.argmax()
        assert f"in pose {worst} most: counted {100.0 * share[worst]:.2f} %" in line

    def test_a_target_is_kept_by_the_drops_alone(self, part, deceived):
        found = hybrid(part, 100_000, seed=3, target_error=0.01)
        assert found.method == "simulation"
        assert counted_bound(by_index(found, "count")) <= 0.01
        assert not any(line.startswith("TARGET_MISSED") for line in found.warnings)

    def test_none_where_they_agree(self, part):
        assert not any("CONFLICT" in line for line in hybrid(part, 1000, seed=3).warnings)
