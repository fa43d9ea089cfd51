"""Coincident points against all pairs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from ros_pose_stats.kernels.grid import WIDTH
from ros_pose_stats.kernels.mesh.coincidence import first_of_coincident


def slow_first(points, tolerance):
    label = connected_components(cdist(points, points) <= tolerance, directed=False)[1]
    return [int(np.flatnonzero(label == k)[0]) for k in label]


def check(points, tolerance):
    found, first = first_of_coincident(points, points.min(axis=0), tolerance)
    expected = slow_first(points, tolerance)
    assert first.tolist() == expected
    assert found == (expected != list(range(len(points))))


@given(st.integers(1, 60), st.sampled_from([0.1, 0.5, 1.0, 3.0, 30.0]), st.integers(0, 2**32 - 1))
def test_chains_across_the_borders_of_cubes(count, spread, seed):
    # Points all around a corner where eight cubes meet, repeated ones among them.
    random = np.random.default_rng(seed)
    points = WIDTH + random.normal(scale=spread, size=(count, 3))
    points = np.concatenate((np.zeros((1, 3)), points, points[random.integers(0, count, 5)]))
    check(random.permutation(points), 1.0)


@pytest.mark.parametrize("axis", range(3))
def test_a_chain_along_an_axis_is_one(axis):
    points = np.zeros((200, 3))
    points[:, axis] = 0.9 * np.random.default_rng(axis).permutation(200)
    found, first = first_of_coincident(points, np.zeros(3), 1.0)
    assert found
    assert not first.any()


def test_thousands_of_repeats_take_no_time():
    points = np.repeat(np.eye(3), 50_000, axis=0)
    _, first = first_of_coincident(points, np.zeros(3), 1e-8)
    assert first.tolist() == np.repeat([0, 50_000, 100_000], 50_000).tolist()
