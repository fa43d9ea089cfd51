"""What a feeder gets out of probabilities."""

import math

import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.report import Feeder, investigate
from ros_pose_stats.statistics.feeding import drop_afresh
from ros_pose_stats.statistics.intervals import jeffreys_interval
from ros_pose_stats.statistics.pose_shares import pose_shares
from tests.report.parts import block


def feeding(found, wanted, rate=math.nan):
    return drop_afresh(pose_shares(found), wanted, rate)


def test_counts_are_added_before_the_interval_is_taken():
    found = block().simulated
    count = sum(pose.count for pose in found.poses if pose.index in (0, 2))
    one = feeding(found, (0, 2), 60.0)
    share, low, high = one.accepted
    assert share == pytest.approx(count / 300)
    assert (low, high) == pytest.approx(tuple(map(float, jeffreys_interval(count, 300))))
    assert one.per_minute == pytest.approx((60 * share, 60 * low, 60 * high))
    assert one.passes == pytest.approx((1 / share, 1 / high, 1 / low))


def test_one_pose_has_the_interval_of_its_count():
    found = block().simulated
    for pose in found.poses:
        one = feeding(found, (pose.index,))
        assert one.accepted == pytest.approx(
            (pose.probability, pose.probability_low, pose.probability_high))
        assert math.isnan(one.per_minute.value)


def test_all_poses_need_one_pass():
    one = feeding(block().simulated, range(6))
    assert one.passes == (1.0, 1.0, 1.0)


def test_a_pose_that_never_came_up_has_no_bound():
    found = block().simulated
    never = [pose.index for pose in found.poses if pose.count == 0]
    for index in never:
        middle, least, most = feeding(found, (index,)).passes
        assert middle == most == math.inf
        assert least > 50.0


def test_a_pose_named_twice_counts_once():
    found = block().simulated
    assert feeding(found, (1, 1)).accepted == feeding(found, (1,)).accepted


@pytest.mark.parametrize(("feeder", "told"), [
    (Feeder((6,)), "wanted poses out of 0 to 5, at least one, got 6"), (Feeder((-1,)), "got -1"),
    (Feeder((), 60.0), "got none"), (Feeder((0,), 0.0), "a rate above 0"),
    (Feeder((0,), math.inf), "a rate above 0"),
    (Feeder((0,), math.nan), "a rate above 0"),
    (Feeder((0,), kick_height=0.02), "a rate of parts a minute beside the kick height"),
    (Feeder((0,), 60.0, -1.0), "a kick height of 0 m or more"),
    (Feeder((0,), 60.0, 0.02, -1.0), "a cycle time"),
])
def test_what_is_not_there_is_refused_before_anything_is_dropped(feeder, told):
    with pytest.raises(RequestError, match=told):
        investigate(block().part, drops=10**9, feeder=feeder)
