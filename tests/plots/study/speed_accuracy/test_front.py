"""The Pareto front against its definition."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.plots.study.speed_accuracy import pareto_front
from ros_pose_stats.plots.study.speed_accuracy.points import stair


class Point(NamedTuple):
    seconds: float
    error: float


ROUND = st.integers(1, 6).map(float)  # so that there are ties
POINTS = st.lists(st.builds(Point, ROUND, ROUND) | st.builds(
    Point, st.floats(1e-6, 1e3), st.floats(1e-4, 1.0)), min_size=1, max_size=25)


def beaten(point, points):
    return any(other.seconds < point.seconds and other.error < point.error for other in points)


@given(points=POINTS)
def test_exactly_those_that_no_other_beats(points):
    front = pareto_front(points)
    assert sorted(front) == [place for place, point in enumerate(points)
                             if not beaten(point, points)]


@given(points=POINTS)
def test_times_never_fall_and_errors_never_rise(points):
    front = np.array([points[place] for place in pareto_front(points)])
    assert (np.diff(front[:, 0]) >= 0.0).all()
    assert (np.diff(front[:, 1]) <= 0.0).all()


@given(points=POINTS)
def test_no_point_lies_below_and_left_of_the_stair(points):
    seconds, error = stair(points, 1e4, 10.0)
    assert (np.diff(seconds) >= 0.0).all()
    assert (np.diff(error) <= 0.0).all()
    assert seconds[-1] == 1e4
    assert error[0] == 10.0
    assert len(seconds) == len(error) == 2 * len(pareto_front(points)) + 1
    for corner in zip(seconds, error, strict=True):
        assert not beaten(Point(*corner), points)


def test_a_known_front():
    points = [Point(1.0, 5.0), Point(2.0, 6.0), Point(3.0, 2.0), Point(0.5, 9.0), Point(4.0, 2.5)]
    assert pareto_front(points) == [3, 0, 2]
    assert pareto_front([]) == []
