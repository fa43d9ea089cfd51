"""Nested balls: every corner in exactly one leaf and inside all balls above it."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.simulation.drop_body import LEAF, ball_tree

SIZES = (1, 2, LEAF, LEAF + 1, 2 * LEAF + 1, 1000, 5000)


def points_of(kind, count):
    random = np.random.default_rng(count)
    points = random.standard_normal((count, 3))
    if kind == "line":
        points[:, 1:] = 0.0
    if kind == "same":
        points[:] = points[0]
    return points / max(np.linalg.norm(points, axis=1).max(), 1e-9)


@pytest.mark.parametrize("kind", ["cloud", "line", "same"])
@pytest.mark.parametrize("count", SIZES)
def test_balls_hold_their_corners(kind, count):
    points = points_of(kind, count)
    order, ball, ball_range = ball_tree(points)
    assert sorted(order.tolist()) == list(range(count))
    assert ball.shape == (len(ball_range), 5) and ball_range.dtype == np.int64
    placed = points[order]
    for (*center, radius, away), (begin, end, _) in zip(ball, ball_range, strict=True):
        assert np.linalg.norm(placed[begin:end] - center, axis=1).max() <= radius
        assert away == pytest.approx(np.linalg.norm(center), abs=1e-15)


@pytest.mark.parametrize("count", SIZES)
def test_nodes_are_nested(count):
    """A node's children share its corners; each names the node that follows its subtree."""
    _, _, ball_range = ball_tree(points_of("cloud", count))
    nodes = len(ball_range)
    assert tuple(ball_range[0]) == (0, count, nodes)
    leaves = []
    for node, (begin, end, after) in enumerate(ball_range):
        assert begin < end and node < after <= nodes
        if after == node + 1:
            leaves.append((begin, end))
            assert end - begin <= LEAF
            continue
        left, right = node + 1, ball_range[node + 1, 2]
        assert ball_range[right, 2] == after
        assert ball_range[left, 0] == begin and ball_range[right, 1] == end
        assert ball_range[left, 1] == ball_range[right, 0]
        assert abs(2 * ball_range[left, 1] - begin - end) <= 1
    assert [0, *(end for _, end in leaves)] == [*(begin for begin, _ in leaves), count]


def test_few_corners_make_one_ball():
    _, ball, _ = ball_tree(points_of("cloud", LEAF))
    assert len(ball) == 1
