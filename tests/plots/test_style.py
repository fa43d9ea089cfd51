"""Heights pushed apart."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.plots.style import apart

HEIGHTS = st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=12).map(np.array)


@given(heights=HEIGHTS, gap=st.floats(0.01, 10.0))
def test_they_lie_apart_in_the_same_order(heights, gap):
    placed = apart(heights, gap)
    order = np.argsort(heights, kind="stable")
    assert (np.diff(placed[order]) >= gap - 1e-9).all()


@given(heights=HEIGHTS, gap=st.floats(0.01, 10.0))
def test_they_lie_between_the_bounds(heights, gap):
    placed = apart(heights, gap, -150.0, 150.0)
    assert -150.0 - 1e-9 <= placed.min() <= placed.max() <= 150.0 + 1e-9
    assert (np.diff(np.sort(placed)) >= gap - 1e-9).all()


def test_what_fits_stays_and_the_rest_moves_evenly():
    assert apart(np.array([5.0, 0.0, 9.0]), 2.0).tolist() == [5.0, 0.0, 9.0]
    assert apart(np.array([1.0, 0.0]), 2.0) == pytest.approx([1.5, -0.5])
    assert apart(np.array([0.0, 0.0, 0.0]), 1.0) == pytest.approx([-1.0, 0.0, 1.0])
    assert apart(np.array([0.0, 0.0]), 1.0, low=0.0) == pytest.approx([0.0, 1.0])


@given(heights=HEIGHTS, gap=st.floats(0.01, 10.0), seed=st.integers(0, 2**31))
def test_no_other_placement_moves_them_less(heights, gap, seed):
    placed = apart(heights, gap)
    order = np.argsort(heights, kind="stable")
    other = np.empty_like(placed)
    steps = np.random.default_rng(seed).exponential(gap, size=len(heights))
    other[order] = np.cumsum(gap + steps)
    other += (heights - other).mean()
    assert ((placed - heights) ** 2).sum() <= ((other - heights) ** 2).sum() + 1e-6
