"""Which result of a part is shown, without a node."""

from __future__ import annotations

import math
from copy import deepcopy

import pytest
from ros_pose_stats_msgs.msg import PoseStatistics

from ros_pose_stats.ros.messages.part_messages import request_of_message
from ros_pose_stats.ros.parts.result_store import replaces
from ros_pose_stats.ros.settings import Settings

from ..harness.parts import WEDGE, flat, whole
from ..harness.quiet import FakeRecorder, fake_node, quiet_results


def result(error, drops=0, **fields):
    return PoseStatistics(expected_error=error, plate_error=0.05, drops=drops,
                          **{"part_digest": "digest", "final": True, **fields})


class TestReplaces:
    @pytest.mark.parametrize(("new", "old", "wanted"), [
        (0.01, 0.02, True), (0.02, 0.01, False), (0.01, 0.01, True),
        (0.06, math.nan, False), (0.04, math.nan, True), (math.nan, 0.04, False),
        (math.nan, 0.06, True), (math.nan, math.nan, True)])
    def test_a_larger_error_never_replaces_a_smaller_one(self, new, old, wanted):
        assert replaces(result(new), result(old)) is wanted

    def test_an_estimate_by_the_method_wanted_now_takes_the_place_of_another(self):
        old = result(0.01, method="combined")
        assert replaces(result(0.1, method="csae"), old)
        assert not replaces(result(0.1, method="combined"), old)
        assert not replaces(result(0.1, method="csae"), result(0.01, 100, method="simulation"))

    def test_drops_with_an_estimate_count_like_drops(self):
        estimated, together = result(0.02, method="split"), result(0.01, 100, method="hybrid")
        assert replaces(together, estimated) and not replaces(estimated, together)
        assert not replaces(result(0.03, 100, method="hybrid"), estimated)
        assert not replaces(result(0.02, 200, method="simulation"), together)
        assert replaces(result(0.005, 900, method="simulation"), together)

    def test_another_digest_is_another_part(self):
        assert replaces(result(0.5, part_digest="other"), result(0.01))

    def test_the_end_of_a_simulation_takes_the_place_of_what_it_showed_before(self):
        """With few drops the last ones may raise the error a little; it must end all the same."""
        before = result(0.0200, 95, job_id="job", final=False)
        assert replaces(result(0.0203, 100, job_id="job"), before)
        assert not replaces(result(0.0203, 100, job_id="other"), before)
        assert not replaces(result(0.0203, 98, job_id="job", final=False), before)


@pytest.fixture
def recorder():
    return FakeRecorder()


@pytest.fixture
def results(recorder):
    return quiet_results(Settings(), recorder, fake_node([]))


class TestOfTheLastRun:
    @pytest.fixture
    def last(self, results):
        """A result of the last run, with a small error."""
        known = results.take_part(request_of_message(flat(WEDGE, "part")))
        last = deepcopy(results.estimate(known, "", Settings().scene()))
        last.revision, last.drops, last.expected_error = 70, 1000, 0.001
        results.parts.forget("part")
        return last

    def test_is_latched_where_the_mesh_comes_first_by_itself(self, results, last):
        request = request_of_message(flat(WEDGE, "part"))
        results.take_part(request)
        known = results.take_part(request, last)
        assert (known.latched.drops, known.latched.revision) == (1000, 70)

    def test_is_latched_as_it_was_and_not_recorded_again(self, results, recorder, last):
        request = request_of_message(flat(WEDGE, "part"))
        recorder.topics.clear()
        assert results.holds(last, (-1.0, -1.0)) and results.relabel(last) is last
        known = results.take_part(request, last, recorded=True)
        assert whole(known.latched) == whole(last)
        assert recorder.topics.count("/pose_stats/pose_statistics") == 0

    @pytest.mark.parametrize("field", [
        {"restitution": 0.7}, {"cluster_tolerance": 0.0}, {"round_sides": 0}, {"version": ""}])
    def test_that_does_not_hold_lets_the_number_rise(self, results, last, field):
        ((name, value),) = field.items()
        setattr(last, name, value)
        assert not results.holds(last, (-1.0, -1.0))
        known = results.take_part(request_of_message(flat(WEDGE, "part")), last)
        assert known.latched.drops == 0 and known.latched.revision > 70
