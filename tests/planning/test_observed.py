"""What counts on a plate add to a model's answer: closed ends, and many simulated plates."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ros_pose_stats import PoseStatsError, estimate, part_from_mesh, shapes, simulate
from ros_pose_stats.planning.observed import observe_counts
from ros_pose_stats.records.statistics import ranked

PLATE_ERROR = 0.05
CASES = 160
SEEN = (0, 10, 30, 100, 200, 300, 1000)


@pytest.fixture(scope="module")
def model():
    """Of a body without symmetry, of many poses."""
    points = np.random.default_rng(5).normal(size=(12, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    part = part_from_mesh(*shapes.hull_mesh(points))
    return replace(estimate(part, cluster_tolerance=0.0), expected_error=0.0)


def by_index(found, field="probability"):
    return np.array([getattr(pose, field) for pose in sorted(found.poses, key=lambda p: p.index)])


def with_shares(model, shares):
    """The same with other probabilities."""
    poses = sorted(model.poses, key=lambda pose: pose.index)[:len(shares)]
    return replace(model, poses=ranked([
        pose.with_probability(share) for pose, share in zip(poses, shares, strict=True)]))


def test_nothing_counted(model):
    assert observe_counts(model, np.zeros(len(model.poses), dtype=int)) is model


def test_many_counts_have_the_say(model):
    counts = np.random.default_rng(1).multinomial(10**6, by_index(model))
    found = observe_counts(model, counts)
    np.testing.assert_allclose(by_index(found), counts / 10**6, atol=1e-4)
    assert (found.method, found.observed, found.drops) == ("observed", 10**6, 0)
    assert by_index(found, "count").tolist() == counts.tolist()
    assert found.expected_error == found.plate_error < 1e-3
    assert found.warnings == model.warnings


def test_poses_that_symmetry_makes_equal_share_their_counts():
    box = simulate(part_from_mesh(*shapes.box(1.0, 0.8, 0.6)), 1000, seed=1)
    found = observe_counts(box, np.array([40, 0, 7, 3, 0, 0]))
    assert by_index(found)[0] == by_index(found)[1] > by_index(box)[0]


def test_a_plate_that_refutes_the_model(model):
    shares = by_index(model)
    counts = np.zeros(len(shares), dtype=int)
    counts[shares.argmin()] = 500
    found = observe_counts(model, counts)
    (line,) = [one for one in found.warnings if one.startswith("CONFLICT:")]
    assert f"pose {shares.argmin()}" in line or f"pose {shares.argmax()}" in line
    assert by_index(found)[shares.argmin()] > 0.98


@pytest.mark.parametrize("counts", [[1], 1.5, -1])
def test_refused(model, counts):
    wrong = counts if isinstance(counts, list) else [counts] * len(model.poses)
    with pytest.raises(PoseStatsError, match="whole numbers"):
        observe_counts(model, wrong)


def test_on_plates_that_the_model_gets_wrong_by_five_points(model):
    """Truths scatter about the model (Dirichlet), of four to nine poses.

    Of the coverage of some 700 intervals the standard error is about 1.5 points, since those of a
    part go together; the bounds are 3 points from 90.
    """
    random = np.random.default_rng(7)
    square = {seen: np.zeros(3) for seen in SEEN}
    kept = {seen: [] for seen in SEEN}
    for _ in range(CASES):
        shares = random.dirichlet(np.full(int(random.integers(4, 10)), random.choice([0.7, 2.0])))
        shares = np.maximum(shares, 2e-3) / np.maximum(shares, 2e-3).sum()
        spread = (shares * (1.0 - shares)).mean()
        truth = random.dirichlet(shares * max(spread / PLATE_ERROR**2 - 1.0, 1.0))
        told = with_shares(model, shares)
        for seen in SEEN:
            counts = random.multinomial(seen, truth)
            found = observe_counts(told, counts)
            counted = counts / seen if seen else np.full(len(shares), math.inf)
            square[seen] += [((one - truth) ** 2).mean()
                             for one in (by_index(found), shares, counted)]
            if seen:
                kept[seen].extend((by_index(found, "probability_low") <= truth)
                                  & (truth <= by_index(found, "probability_high")))
    for seen in SEEN:
        own, of_model, of_counts = np.sqrt(square[seen] / CASES)
        assert own <= 1.03 * min(of_model, of_counts)
        assert seen < 200 or own < 0.5 * of_model
        assert not seen or 0.87 < np.mean(kept[seen]) < 0.93
