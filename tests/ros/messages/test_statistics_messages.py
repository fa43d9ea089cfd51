"""Pose statistics as messages, without a node."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ros_pose_stats import estimate, simulate
from ros_pose_stats.ros.messages.statistics_messages import (
    Answer,
    statistics_message,
    statistics_of_message,
)
from ros_pose_stats.ros.messages.times import duration_message, time_message

from ..harness.parts import WEDGE, library_part

STAMP = 1_700_000_000_123_456_789
ANSWER = Answer(STAMP, "tray", "brass", 7, "job_1", False, ("NOT_RECORDED: disk full.",))


@pytest.fixture(scope="module", params=[estimate, lambda part: simulate(part, 500, seed=3)])
def found(request):
    return request.param(library_part(WEDGE, "part"))


def nanoseconds(stamp):
    return 10**9 * stamp.sec + stamp.nanosec


class TestMessage:
    def test_says_what_the_answer_says(self, found):
        message = statistics_message(found, ANSWER)
        assert nanoseconds(message.header.stamp) == STAMP
        assert (message.header.frame_id, message.plate) == ("tray", "brass")
        assert message.largest_error == found.largest_error > 0.0
        assert message.scene == found.scene != ""
        assert (message.revision, message.job_id, message.final) == (7, "job_1", False)
        assert list(message.warnings) == [*found.warnings, "NOT_RECORDED: disk full."]

    def test_there_and_back(self, found):
        message = statistics_message(found, Answer(STAMP, "plate", "", 1))
        back = statistics_of_message(message)
        for field in dataclasses.fields(found):
            if field.name not in ("poses", "seconds", "choice"):  # that is the service's message
                np.testing.assert_equal(getattr(back, field.name), getattr(found, field.name))
        assert back.seconds == pytest.approx(found.seconds, abs=1e-9)
        for one, other in zip(back.poses, found.poses, strict=True):
            for field in dataclasses.fields(other):
                if field.name not in ("members", "shape"):
                    np.testing.assert_equal(getattr(one, field.name),
                                            getattr(other, field.name))
            np.testing.assert_array_equal(one.outline, other.outline)
            np.testing.assert_array_equal(one.support_polygon, other.support_polygon)

    def test_unknown_time_is_no_time(self, found):
        message = statistics_message(dataclasses.replace(found, seconds=math.nan), ANSWER)
        assert (message.compute_time.sec, message.compute_time.nanosec) == (0, 0)


class TestTimes:
    @pytest.mark.parametrize("stamp", [0, 1, 999_999_999, 10**9, STAMP, -1, -10**9])
    def test_stamps(self, stamp):
        assert nanoseconds(time_message(stamp)) == stamp

    @pytest.mark.parametrize("seconds", [0.0, 1e-9, 0.999999999, 1.0, 3600.5])
    def test_durations(self, seconds):
        found = duration_message(seconds)
        assert found.sec + 1e-9 * found.nanosec == pytest.approx(seconds, abs=1e-9)

    @pytest.mark.parametrize("seconds", [-1.0, math.nan])
    def test_what_is_no_duration(self, seconds):
        assert duration_message(seconds) == duration_message(0.0)
