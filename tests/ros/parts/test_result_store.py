"""Which result of a part is shown, without a node."""

from __future__ import annotations

import math
from copy import deepcopy

import pytest
from ros_pose_stats_msgs.msg import PoseStatistics

from ros_pose_stats.ros.messages.part_messages import request_of_message
from ros_pose_stats.ros.parts import result_store
from ros_pose_stats.ros.parts.result_rules import replaces
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

    def test_what_drops_refuted_comes_back_with_as_many_drops_only(self):
        """An estimate that is wrong tells of a small error; so may a few drops with its help."""
        refuted = result(0.02, 400, method="simulation", warnings=["CONFLICT: drops contradict."])
        estimated, few = result(0.005, method="split"), result(0.004, 100, method="hybrid")
        assert replaces(refuted, estimated) and replaces(refuted, few)
        assert not replaces(estimated, refuted) and not replaces(few, refuted)
        assert replaces(result(0.03, 500, method="hybrid"), refuted)
        better = result(0.01, 900, method="simulation", warnings=["CONFLICT: drops contradict."])
        assert replaces(better, refuted) and not replaces(refuted, better)

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


class TestSwaps:
    """Two publishers send two meshes of one part in turn."""

    STATISTICS = "/pose_stats/pose_statistics"

    @pytest.fixture
    def swap(self, results, monkeypatch):
        """Takes the mesh of this number; 10 ms pass on the clock, or as many seconds as given."""
        vertices, triangles = WEDGE
        now = [100.0]
        monkeypatch.setattr(result_store.time, "monotonic", lambda: now[0])

        def take(number, seconds=0.01):
            now[0] += seconds
            return results.take_part(request_of_message(
                flat(((1.0 + 0.1 * number) * vertices, triangles), "part")))
        return take

    def test_are_published_each_and_recorded_once_a_second(self, recorder, results, swap):
        revisions = [swap(number % 2).latched.revision for number in range(100)]
        assert revisions == sorted(set(revisions))
        assert recorder.topics.count("/pose_stats/part_mesh") == 2
        assert recorder.topics.count(self.STATISTICS) == 2
        swap(0, seconds=1.1)
        assert recorder.topics.count(self.STATISTICS) == 3

    def test_are_published_once_each(self, results, swap, monkeypatch):
        shown = []
        monkeypatch.setattr(results.announcer, "publish_result",
                            lambda part, message, data: shown.append(message.revision))
        known = [swap(number % 2) for number in range(6)]
        assert shown == [one.latched.revision for one in known]

    def test_the_last_one_is_recorded_in_the_end(self, recorder, results, swap):
        for number in range(7):
            known = swap(number % 2)
        assert known.mark < 0
        results.record_waiting()
        assert known.mark >= 0
        assert recorder.topics.count(self.STATISTICS) == 3
        results.record_waiting()
        assert recorder.topics.count(self.STATISTICS) == 3

    def test_a_mesh_that_is_recorded_again_is_followed_by_its_result(self, recorder, swap):
        """Readers take the first result after a mesh for that mesh's."""
        for number in range(4):
            swap(number % 2)
        recorder.mark = recorder.trusted_from = 1
        recorder.topics.clear()
        for number in range(6):
            swap(number % 2)
        assert recorder.topics == 2 * ["/pose_stats/part_mesh", self.STATISTICS]

    def test_what_is_new_is_recorded_at_once(self, recorder, swap):
        for number in range(20):
            swap(number)
        assert recorder.topics.count(self.STATISTICS) == 20


def test_what_was_recorded_below_a_mark_is_recorded_again(recorder, results):
    vertices, triangles = WEDGE
    meshes = [flat(((1.0 + 0.1 * number) * vertices, triangles), f"part {number}")
              for number in range(3)]
    for recorder.mark, mesh in enumerate(meshes):
        results.take_part(request_of_message(mesh))
    recorder.topics.clear()
    recorder.trusted_from = 2
    for _ in range(2):
        results.record_again()
        assert recorder.topics == 2 * ["/pose_stats/part_mesh", "/pose_stats/pose_statistics"]


def test_what_is_too_large_to_be_kept_is_still_moved_out_of_an_earlier_run(
        recorder, results, monkeypatch):
    """Of the parts of a full log only those go on record again that are in a run that goes."""
    vertices, triangles = WEDGE
    own, moved = (results.take_part(request_of_message(flat((size * vertices, triangles), name)))
                  for size, name in ((1.0, "own"), (1.1, "moved")))
    meshes = results.parts.meshes
    meshes.count_as_recorded((moved.part.part_id, moved.part.digest), moved.scene_override, "old")
    meshes.coming.clear()
    monkeypatch.setattr(recorder, "has_room_for", lambda size: False)
    recorder.topics.clear()
    recorder.mark = recorder.trusted_from = 1
    results.record_again()
    assert recorder.topics == [] and not meshes.holds(moved) and not meshes.holds(own)
    assert meshes.distrust("old") and meshes.must_move(moved) and not meshes.must_move(own)
    for _ in range(2):
        results.record_again()
        assert recorder.topics == ["/pose_stats/part_mesh", "/pose_stats/pose_statistics"]
    assert not meshes.must_move(moved) and not meshes.distrust("old")
