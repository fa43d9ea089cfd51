"""Bounds and thinness against numpy's own reductions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.kernels.extents import bounds, boxes_around, largest_used_extent, thinness
from tests.bodies import rotation


def slow_thinness(points):
    """The same measure, written with whole arrays."""
    low, high = points.min(axis=0), points.max(axis=0)
    points = (points - (low + 0.5 * (high - low))) / (high - low).max()
    axis = int((high - low).argmax())
    base = points[points[:, axis].argmin()]
    line = points[points[:, axis].argmax()] - base
    longest = np.linalg.norm(line)
    aside = (points - base) - np.outer((points - base) @ line, line) / longest**2
    far = aside[np.linalg.norm(aside, axis=1).argmax()]
    width = np.linalg.norm(far)
    if width == 0.0:
        return 0.0
    return min(width, np.ptp(points @ np.cross(line, far)) / (width * longest)) / longest


@given(st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_bounds(count, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    low, high = bounds(points)
    assert low.tolist() == points.min(axis=0).tolist()
    assert high.tolist() == points.max(axis=0).tolist()


@given(st.integers(3, 30), st.integers(1, 20), st.integers(0, 2**32 - 1))
def test_extent_of_the_used_points_only(count, triangles, seed):
    random = np.random.default_rng(seed)
    points = random.normal(size=(count, 3))
    corners = random.integers(0, count, (triangles, 3)).astype(np.uint32)
    expected = np.ptp(points[corners.ravel()], axis=0).max()
    assert largest_used_extent(points, corners) == expected


@given(st.integers(2, 30), st.integers(-6, 0), st.integers(-9, 0), st.integers(0, 2**32 - 1))
def test_thinness(count, width, thickness, seed):
    random = np.random.default_rng(seed)
    points = random.normal(size=(count, 3)) * (1.0, 10.0**width, 10.0**thickness)
    points = points @ rotation(seed).T + random.normal(size=3)
    assert thinness(points, *bounds(points)) == pytest.approx(slow_thinness(points), rel=1e-6,
                                                              abs=1e-14)


def test_a_line_and_a_plane_are_flat():
    line = np.outer(np.arange(5.0), (1.0, 0.0, 0.0))
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    for points in (line, square):
        assert thinness(points, *bounds(points)) == 0.0


@given(st.integers(1, 20), st.integers(0, 2**32 - 1))
def test_boxes_around_a_box(count, seed):
    random = np.random.default_rng(seed)
    low = random.integers(0, 4, (count, 3)).astype(float)
    high = low + random.integers(1, 6, (count, 3))
    inner = int(random.integers(count))
    expected = [i for i in range(inner)
                if (low[i] <= low[inner] + 0.5).all() and (high[i] >= high[inner] - 0.5).all()]
    assert boxes_around(low, high, inner, 0.5).tolist() == expected
