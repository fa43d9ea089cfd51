"""What a feeder gets out of probabilities."""

import math

import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.report import feeding
from ros_pose_stats.statistics.intervals import jeffreys_interval
from tests.report.parts import block


def test_counts_are_added_before_the_interval_is_taken():
    found = block().simulated
    count = sum(pose.count for pose in found.poses if pose.index in (0, 2))
    one = feeding(found, (0, 2), 60.0)
    assert one.share == count / 300
    assert (one.low, one.high) == pytest.approx(tuple(map(float, jeffreys_interval(count, 300))))
    assert one.accepted == pytest.approx((60 * one.share, 60 * one.low, 60 * one.high))
    assert one.passes == pytest.approx((1 / one.share, 1 / one.high, 1 / one.low))


def test_one_pose_has_the_interval_of_its_count():
    found = block().simulated
    for pose in found.poses:
        one = feeding(found, (pose.index,))
        assert (one.share, one.low, one.high) == pytest.approx(
            (pose.probability, pose.probability_low, pose.probability_high))
        assert math.isnan(one.accepted[0])


def test_all_poses_need_one_pass():
    one = feeding(block().simulated, range(6))
    assert one.passes == (1.0, 1.0, pytest.approx(1.0, abs=0.02))


def test_a_pose_that_never_came_up_has_no_bound():
    found = block().simulated
    never = [pose.index for pose in found.poses if pose.count == 0]
    for index in never:
        middle, least, most = feeding(found, (index,)).passes
        assert middle == most == math.inf
        assert least > 50.0


def test_a_pose_named_twice_counts_once():
    found = block().simulated
    assert feeding(found, (1, 1)).share == feeding(found, (1,)).share


@pytest.mark.parametrize(("wanted", "rate", "told"), [
    ((6,), None, "poses from 0 to 5, got 6"), ((-1,), None, "got -1"), ((), None, "got none"),
    ((0,), 0.0, "a rate above 0"), ((0,), math.nan, "a rate above 0"),
    ((0,), math.inf, "a rate above 0"),
])
def test_what_is_not_there_is_refused(wanted, rate, told):
    with pytest.raises(RequestError, match=told):
        feeding(block().simulated, wanted, rate)
