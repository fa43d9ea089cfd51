"""Corners that count as one: closed forms, plain sums over all pairs, and continuity."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ros_pose_stats import part_from_mesh, resting_poses, shapes
from ros_pose_stats.kernels.features.corner_crowding import corner_crowding
from ros_pose_stats.resting.poses import CORNER_REACHES


def body_of(points):
    return resting_poses(part_from_mesh(*shapes.hull_mesh(np.asarray(points, dtype=float))),
                         round_sides=0).body


def crowding(points, reaches=CORNER_REACHES):
    body = body_of(points)
    return corner_crowding(body.points, body.arrays, np.asarray(reaches, dtype=float))


def box_corners(x=1.0, y=1.0, z=1.0):
    return np.array([(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])


def cloud(seed, count=40):
    return np.random.default_rng(seed).normal(size=(count, 3))


def test_equal_corners_far_apart():
    np.testing.assert_allclose(crowding(box_corners()), 1.0 / 8.0, rtol=1e-12)
    tetrahedron = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    np.testing.assert_allclose(crowding(tetrahedron), 1.0 / 4.0, rtol=1e-12)


def test_right_angled_corner_of_a_wedge():
    """Corners of a half cube: defects pi less the angles of its triangle there, by hand."""
    wedge = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
    shares = np.repeat([math.pi / 2, math.pi - math.pi / 4, math.pi - math.pi / 4], 2)
    np.testing.assert_allclose(crowding(wedge), np.sum((shares / (4 * math.pi)) ** 2), rtol=1e-12)


def sphere(seed, count):
    points = cloud(seed, count)
    return points / np.linalg.norm(points, axis=1, keepdims=True) * (1.0, 0.6, 0.3)


@pytest.mark.parametrize("points", [*(cloud(seed) for seed in range(4)), sphere(5, 200),
                                    sphere(6, 1500)], ids=lambda points: len(points))
def test_all_pairs(points):
    """Against triangles of scipy's hull, whose angles add up the same way."""
    body = body_of(points)
    from scipy.spatial import ConvexHull
    angle = np.zeros(len(body.points))
    for triangle in ConvexHull(body.points).simplices:
        for turn in range(3):
            at, p, q = np.roll(triangle, turn)
            a, b = body.points[p] - body.points[at], body.points[q] - body.points[at]
            angle[at] += math.acos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))
    share = np.where(angle > 0.0, 2 * math.pi - angle, 0.0) / (4 * math.pi)
    assert share.sum() == pytest.approx(1.0, abs=1e-12)
    away = np.linalg.norm(body.points[:, None] - body.points, axis=2)
    reaches = np.array([0.05, 0.3, 1.0])
    for reach, found in zip(reaches, corner_crowding(body.points, body.arrays, reaches),
                            strict=True):
        wanted = share @ np.clip(1.0 - (away / reach) ** 2, 0.0, None) ** 2 @ share
        assert found == pytest.approx(wanted, rel=1e-7)  # flat triangles are one face


@given(seed=st.integers(0, 10_000), size=st.floats(1e-3, 1e3))
def test_neither_place_nor_size_matters(seed, size):
    points = cloud(seed, 12)
    moved = size * points @ Rotation.random(random_state=seed).as_matrix().T + 3.0 * size
    np.testing.assert_allclose(crowding(moved), crowding(points), rtol=1e-6)


@pytest.mark.parametrize("cut", [1e-3, 1e-5])
def test_a_corner_cut_off_by_a_hair(cut):
    corners = box_corners()
    tip = corners[-1]
    replaced = np.vstack((corners[:-1], tip - 2.0 * cut * np.eye(3)))
    np.testing.assert_allclose(crowding(replaced), crowding(corners), rtol=1e4 * cut * cut + cut)


def test_one_more_corner_on_an_edge():
    corners = box_corners(1.0, 0.7, 0.4)
    more = np.vstack((corners, (corners[0] + corners[1]) / 2 * (1.0 + 1e-9)))
    np.testing.assert_allclose(crowding(more), crowding(corners), rtol=1e-6)


def test_many_corners_crowd_little():
    coarse, fine = (crowding(shapes.cylinder(sides, 1.0, 1.0)[0]) for sides in (12, 96))
    assert fine[0] < 0.5 * coarse[0]
    assert fine[1] > fine[0] > 0.999 / (2 * 96)  # neighbours count at the larger reach
