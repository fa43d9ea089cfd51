"""Principal axes against LAPACK's, where these are well defined, and where they are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.kernels.principal_axes import principal_axes
from tests.bodies import rotation

ROUNDING = 8.0 * np.finfo(np.float64).eps
"""A few roundings of the largest moment, by so much the tensors themselves are rounded."""


def assert_principal(tensor):
    moments, axes = principal_axes(tensor)
    size = max(np.abs(tensor).max(), 1e-300)
    assert (np.diff(moments) >= 0.0).all()
    assert np.abs(axes.T @ axes - np.eye(3)).max() <= ROUNDING
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=ROUNDING)
    assert np.abs(axes @ np.diag(moments) @ axes.T - tensor).max() <= ROUNDING * size
    assert np.abs(moments - np.linalg.eigvalsh(tensor)).max() <= ROUNDING * size
    for axis in axes.T[:2]:
        assert axis[np.abs(axis).argmax()] > 0.0
    return moments, axes


@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=6), st.floats(1e-60, 1e60))
def test_any_tensor(entries, scale):
    a, b, c, d, e, f = (entry * scale for entry in entries)
    assert_principal(np.array([[a, d, e], [d, b, f], [e, f, c]]))


@pytest.mark.parametrize("moments", [
    (1.0, 1.0, 1.0), (1.0, 1.0, 2.0), (1.0, 2.0, 2.0), (1e-14, 1.0, 1.0), (0.0, 0.0, 1.0),
    (1.0, 1.0 + 1e-12, 1.0 + 1e-9),
])
def test_equal_moments_up_to_rounding(moments):
    for seed in range(20):
        turn = rotation(seed)
        tensor = turn @ np.diag(moments) @ turn.T
        found, _ = assert_principal(0.5 * (tensor + tensor.T))
        assert found == pytest.approx(moments, rel=0.0, abs=ROUNDING)


def test_a_diagonal_tensor_keeps_its_axes():
    moments, axes = principal_axes(np.diag([3.0, 1.0, 2.0]))
    assert moments.tolist() == [1.0, 2.0, 3.0]
    assert axes.tolist() == [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


def test_what_stands_below_the_diagonal_is_not_read():
    tensor = np.array([[2.0, 0.5, 0.1], [9.0, 3.0, 0.2], [9.0, 9.0, 4.0]])
    symmetric = np.triu(tensor) + np.triu(tensor, 1).T
    for one, other in zip(principal_axes(tensor), principal_axes(symmetric), strict=True):
        assert one.tolist() == other.tolist()
