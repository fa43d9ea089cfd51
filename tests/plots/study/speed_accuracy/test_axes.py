"""Limits and ticks of the chart."""

from __future__ import annotations

import math

import pytest

from ros_pose_stats.plots.study.speed_accuracy import ChartPoint
from ros_pose_stats.plots.study.speed_accuracy.figure import error_range, time_label, time_range

POINTS = [ChartPoint("fast", "outside", 1e-4, 0.02, -0.01, 0.03),
          ChartPoint("slow", "outside", 1.0, 0.004, 0.003, 0.005)]


@pytest.mark.parametrize(("seconds", "says"), [
    (1e-8, "10 ns"), (1e-6, "1 µs"), (1e-5, "10 µs"), (1e-3, "1 ms"), (0.1, "100 ms"),
    (1.0, "1 s"), (10.0, "10 s"), (1000.0, "1 000 s")])
def test_times_read_in_their_own_unit(seconds, says):
    assert time_label(seconds) == says
    assert time_label(10.0 ** math.log10(seconds)) == says


def test_labels_have_their_room_on_both_sides():
    low, high = time_range(POINTS, width=100.0, left=15.0, right=5.0)
    decades = math.log10(high / low)
    assert math.log10(1e-4 / low) == pytest.approx(0.15 * decades)
    assert math.log10(high / 1.0) == pytest.approx(0.05 * decades)


def test_equal_times_still_span_a_decade():
    low, high = time_range(POINTS[:1], width=100.0, left=15.0, right=5.0)
    assert low < 1e-4 < 1e-3 < high


def test_errors_and_upper_ends_lie_within_whatever_the_lower_ends():
    low, high = error_range(POINTS)
    assert 0.0 < low < 0.4
    assert high > 3.0
