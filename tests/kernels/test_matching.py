"""Matching of turned features against a k-d tree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from ros_pose_stats.kernels.features.matching import feature_grid, first_unmatched
from tests.bodies import rotation

REACH = 1e-5
ALL = np.empty(0, dtype=np.int64)


def slow_first_unmatched(rows, turn, chosen):
    """First image without a feature of its own nearer than `REACH`."""
    image = np.column_stack([rows[:, :3] @ turn.T, *([rows[:, 3:6] @ turn.T, rows[:, 6:]]
                                                     if rows.shape[1] == 7 else [])])
    taken = set()
    gaps, partners = cKDTree(rows).query(image, distance_upper_bound=REACH)
    for i in (chosen.tolist() if len(chosen) else range(len(rows))):
        if not np.isfinite(gaps[i]) or partners[i] in taken:
            return i
        taken.add(partners[i])
    return -1


def symmetric(seed, width, turns=4):
    """Features that quarter turns about z carry into each other, in random order."""
    random = np.random.default_rng(seed)
    base = random.uniform(-0.6, 0.6, (7, width))
    copies = []
    for k in range(turns):
        angle = 2.0 * np.pi * k / turns
        turn = np.array(((np.cos(angle), -np.sin(angle), 0.0),
                         (np.sin(angle), np.cos(angle), 0.0), (0.0, 0.0, 1.0)))
        blocks = [base[:, :3] @ turn.T]
        if width == 7:
            blocks += [base[:, 3:6] @ turn.T, base[:, 6:]]
        copies.append(np.column_stack(blocks))
    return random.permutation(np.concatenate(copies))


QUARTER = np.array(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))


@pytest.mark.parametrize("width", [3, 7])
@given(seed=st.integers(0, 2**32 - 1), noise=st.sampled_from([0.0, 1e-7, 2e-6, 2e-5]),
       some=st.booleans())
def test_like_a_tree(width, seed, noise, some):
    random = np.random.default_rng(seed)
    rows = symmetric(seed, width)
    rows += noise * random.normal(size=rows.shape)
    grid = feature_grid(rows, REACH)
    chosen = random.permutation(len(rows))[:9] if some else ALL
    for turn in (QUARTER, np.eye(3), QUARTER @ QUARTER, rotation(seed)):
        assert first_unmatched(grid, turn, chosen) == slow_first_unmatched(rows, turn, chosen)


def test_two_features_may_not_share_one_image():
    rows = np.array([(0.5, 0.0, 0.0), (0.5, 2e-6, 0.0), (-0.5, 0.0, 0.0), (-0.5, 0.3, 0.0)])
    half = np.diag((-1.0, -1.0, 1.0))
    grid = feature_grid(rows, REACH)
    assert first_unmatched(grid, half, ALL) == 1
    assert first_unmatched(grid, half, np.array([1, 2])) == -1


def test_nothing_is_unmatched_among_nothing():
    assert first_unmatched(feature_grid(np.zeros((0, 3)), REACH), QUARTER, ALL) == -1
