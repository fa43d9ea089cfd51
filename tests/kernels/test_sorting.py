"""Sorting by digits against numpy's stable sort."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ros_pose_stats.kernels.sorting import DIGIT, falling_order, rising_order

KEYS = st.one_of(st.integers(0, 3), st.integers(0, 2**DIGIT + 1), st.integers(0, 2**63 - 1))
VALUES = st.one_of(st.sampled_from([0.0, -0.0, 1.0, 5e-324, np.inf]),
                   st.floats(0.0, allow_infinity=False))


@given(arrays.arrays(np.int64, st.integers(0, 60), elements=KEYS))
def test_integers_rise_and_ties_stay(keys):
    assert rising_order(keys).tolist() == np.argsort(keys, kind="stable").tolist()


@given(arrays.arrays(np.float64, st.integers(0, 60), elements=VALUES))
def test_numbers_fall_and_ties_stay(values):
    assert falling_order(values).tolist() == np.argsort(-values, kind="stable").tolist()


@pytest.mark.parametrize("count", [1, 1000, 20_000])
def test_many(count):
    values = np.random.default_rng(count).lognormal(sigma=20.0, size=count).round(2)
    assert falling_order(values).tolist() == np.argsort(-values, kind="stable").tolist()
