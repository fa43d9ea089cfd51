"""The choice of method: what each kind of request is answered by, and what is said of it."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from ros_pose_stats import DropScene, auto, estimate, hybrid, part_from_mesh, resting_poses, shapes
from ros_pose_stats.errors import RequestError
from ros_pose_stats.estimators import best_method
from ros_pose_stats.estimators.fitted_weights import USUAL_ERRORS
from ros_pose_stats.planning import confidence
from ros_pose_stats.planning.confidence import (
    estimate_bound,
    pose_prior,
    prior_of,
)
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron
from ros_pose_stats.statistics.error_bound import counted_bound
from ros_pose_stats.statistics.posterior.fitted import FITTED_METHOD


@pytest.fixture(scope="module")
def part():
    return random_polyhedron(5, 2, 0.25).part()


def test_no_target_is_the_best_estimate_at_once(part):
    found = auto(part, restitution=0.5)
    assert found.method == best_method(0.5)
    assert found.drops == 0
    assert "no target error" in found.choice
    same = estimate(part, found.method)
    assert [pose.probability for pose in found.poses] == [pose.probability for pose in same.poses]


def test_an_estimate_that_is_sure_enough(part):
    bound = estimate_bound(pose_prior(resting_poses(part), DropScene()))
    found = auto(part, 1.01 * bound)
    assert (found.method, found.drops) == (best_method(0.5), 0)
    assert "with 90 % confidence" in found.choice
    dropped = auto(part, 0.99 * bound, seed=1)
    assert dropped.method == "hybrid" and dropped.drops > 0


@pytest.mark.parametrize("workers", [1, 3])
def test_drops_are_added_up_to_the_bound(part, workers):
    found = auto(part, 0.015, seed=1, workers=workers)
    assert found.method == "hybrid"
    assert found.expected_error < 0.015
    assert found.warnings == estimate(part).warnings
    assert f"so {found.drops} drops were added." in found.choice
    same = hybrid(part, found.drops, seed=1)
    assert [pose.probability for pose in found.poses] == [pose.probability for pose in same.poses]


def test_an_estimate_worth_nothing_is_left_out(part, monkeypatch):
    monkeypatch.setattr(confidence, "WORTHLESS", 10.0)
    found = auto(part, 0.02, seed=1)
    assert found.method == "simulation"
    assert "worth too few drops" in found.choice
    counts = np.array([pose.count for pose in found.poses])
    assert counted_bound(counts) <= 0.02


def test_a_conflict_is_told_and_the_target_kept_by_drops(part, monkeypatch):
    import ros_pose_stats.planning.targeted as targeted

    true = targeted.prior_of

    def wrong_prior(found, resting, scene):
        prior = true(found, resting, scene)
        prior.mean = prior.mean[::-1].copy()
        return prior

    monkeypatch.setattr(targeted, "prior_of", wrong_prior)
    found = auto(part, 0.015, seed=1)
    assert (found.method, found.choice.split(", and ")[1][:24]) == (
        "simulation", "drops contradict it; so ")
    assert any(line.startswith("CONFLICT: ") for line in found.warnings)
    assert counted_bound(np.array([pose.count for pose in found.poses])) <= 0.015


def test_a_low_drop_is_estimated_where_the_estimate_knows_it(part):
    low = 1.5 * resting_poses(part).body.radius
    found = auto(part, 0.2, drop_height=low)
    assert (found.method, found.drops) == ("split", 0)


def test_a_low_drop_is_counted_where_the_estimate_does_not_know_it(part, monkeypatch):
    monkeypatch.setattr(sys.modules["ros_pose_stats.estimators.estimate"], "best_method",
                        lambda _: "combined")
    found = auto(part, 0.03, seed=1, drop_height=1.5 * resting_poses(part).body.radius)
    assert found.drops > 0
    assert "so low a drop" in found.choice


@pytest.mark.parametrize("method", ["split", "meae", "area"])
def test_a_finished_estimate_says_as_much_as_a_new_one(part, method):
    """Of the library, or as a message brings it."""
    scene, resting = DropScene(0.4), resting_poses(part)
    found = prior_of(estimate(part, method, restitution=0.4), resting, scene)
    again = pose_prior(resting, scene, method)
    np.testing.assert_allclose(found.mean, again.mean)
    assert estimate_bound(found) == pytest.approx(estimate_bound(again))


def test_symmetry_bounds_what_an_estimate_does_not_know():
    resting = resting_poses(part_from_mesh(*shapes.box(1.0, 1.0, 1.0)))
    low = DropScene(0.5, 1.2 * resting.body.radius)
    assert estimate_bound(pose_prior(resting, low, "combined")) < 1e-6


def test_symmetry_alone_may_answer():
    found = auto(part_from_mesh(*shapes.tetrahedron()), 0.001)
    assert found.drops == 0
    assert [pose.probability for pose in found.poses] == pytest.approx([0.25] * 4)


def test_bounds_end_it_and_are_told(part):
    found = auto(part, 0.001, drops=60, seed=1)
    assert found.drops == 60
    assert any(line.startswith("TARGET_MISSED: the 90 % bound") for line in found.warnings)
    late = auto(part, 0.0005, seed=1, max_seconds=1e-6)
    assert any(line.startswith("TIME_LIMIT: ") for line in late.warnings)
    stopped = auto(part, 0.0005, seed=1, should_stop=lambda: True)
    assert not any(line.startswith("TIME_LIMIT: ") for line in stopped.warnings)


def test_the_best_method_is_the_one_of_least_usual_error():
    for at, restitution in enumerate((0.2, 0.5, 0.8)):
        assert USUAL_ERRORS[best_method(restitution)][at] == min(
            errors[at] for errors in USUAL_ERRORS.values())
    assert best_method(0.0) == best_method(0.2)


@pytest.mark.parametrize("restitution", np.linspace(0.0, 0.99, 12))
def test_the_prior_is_fitted_to_the_best_method(restitution):
    assert best_method(restitution) == FITTED_METHOD


def test_plain_counts_without_drops_bound_nothing():
    assert counted_bound(np.zeros(3, np.int64)) == math.inf


@pytest.mark.parametrize("options", [
    {"target_error": 1.0}, {"target_error": -0.1}, {"target_error": "small"}, {"drops": 0},
    {"seed": -1}, {"workers": 0}, {"restitution": 1.0}, {"drop_height": -1.0},
    {"max_seconds": -1.0}, {"max_seconds": math.nan}, {"cluster_tolerance": 1.0}])
def test_refusals(part, options):
    with pytest.raises(RequestError, match=r"expected .*, got .*; "):
        auto(part, **options)
