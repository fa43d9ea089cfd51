"""Flips as their caller sees them: a matrix, the same whatever the timing, stopped, refused."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import PoseStatsError, part_from_mesh, resting_poses, shapes, simulate_flips


@pytest.fixture(scope="module")
def box():
    return part_from_mesh(*shapes.box(1.0, 2.0, 3.0))


def test_a_row_a_pose_by_index(box):
    found = simulate_flips(box, 0.9, 300, seed=6)
    assert [pose.index for pose in found.poses] == list(range(6))
    assert [pose.down.tolist() for pose in found.poses] == [
        pose.down.tolist() for pose in resting_poses(box).poses]
    np.testing.assert_array_equal(found.counts.sum(axis=1) + found.unsettled, 300)
    np.testing.assert_allclose(found.transition.sum(axis=1), 1.0, rtol=1e-12)
    assert (found.flips, found.kick_height, found.seed, found.restitution) == (1800, 0.9, 6, 0.5)
    assert found.part_digest == box.digest


def test_workers_and_stops_change_nothing(box):
    one, two = (simulate_flips(box, 1.0, 300, seed=7, workers=workers) for workers in (1, 2))
    np.testing.assert_array_equal(one.counts, two.counts)
    seen = []
    cut = simulate_flips(box, 1.0, 100_000, seed=7, workers=1,
                         on_progress=lambda done, total: seen.append((done, total)),
                         should_stop=lambda: bool(seen))
    assert 0 < cut.flips == seen[-1][0] < seen[-1][1] == 600_000
    longer = simulate_flips(box, 1.0, -(-cut.flips // 6), seed=7)
    assert (longer.counts - cut.counts).sum() == longer.flips - cut.flips
    assert (longer.counts >= cut.counts).all()


@pytest.mark.parametrize(("values", "words"), [
    ({"kick_height": -0.1}, "kick height of 0 m or more"),
    ({"kick_height": float("nan")}, "kick height of 0 m or more"),
    ({"kick_height": "high"}, "number for kick_height"),
    ({"kick_height": 1.0, "drops": 0}, "drops"),
    ({"kick_height": 1.0, "restitution": 1.0}, "restitution"),
])
def test_refusals(box, values, words):
    with pytest.raises(PoseStatsError, match=words):
        simulate_flips(box, **values)
