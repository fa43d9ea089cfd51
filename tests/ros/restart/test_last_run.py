"""Which parts and results the last run leaves, without a node."""

from __future__ import annotations

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics, StablePose

from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.writer.run_log import RunLog
from ros_pose_stats.ros.messages.part_messages import request_of_part_bytes
from ros_pose_stats.ros.recorder import bag_types
from ros_pose_stats.ros.restart.earlier_runs import earlier_runs
from ros_pose_stats.ros.restart.last_run import last_run
from ros_pose_stats.ros.restart.places import read_at

from ..harness.parts import WEDGE, flat

TYPES = bag_types()
VERTICES, TRIANGLES = WEDGE
RUNS = [f"pose_stats_20260102T030405_{k:06}_7" for k in range(16)]


class Writing:
    """A run that writes what a node would, in short."""

    def __init__(self, folder, number, node="pose_stats"):
        self.log = RunLog(folder, TYPES, max_bag_bytes=1 << 29, name=RUNS[number],
                          node="/" + node)

    def _write(self, topic, message):
        self.log.write(f"/pose_stats/{topic}", serialize_message(message), durable=False)

    def mesh(self, part_id, factor):
        self._write("part_mesh", flat((factor * VERTICES, TRIANGLES), part_id))

    def result(self, part_id, factor, revision=1):
        self._write("pose_statistics", PoseStatistics(
            part_id=part_id, part_digest=f"digest {factor}", revision=revision))

    def farewell(self, part_id, factor, poses=()):
        self._write("pose_statistics", PoseStatistics(
            part_id=part_id, part_digest=f"digest {factor}", poses=poses,
            warnings=["LOW_DROP: low.", "FORGOTTEN: for a reason."]))

    def part(self, part_id, factor, revision=1):
        self.mesh(part_id, factor)
        self.result(part_id, factor, revision)

    def event(self, kind, job_id="", part_id=""):
        self._write("job_events", JobEvent(event=kind, job_id=job_id, part_id=part_id))

    def end(self):
        self.log.close()

    def die(self):
        self.log.sync()
        self.log._bag.abandon()


def found(folder):
    return last_run(earlier_runs(folder, "/pose_stats").bags, 1000)


def vertices(folder, run, part_id):
    """Of the mesh of a part, read where it lies."""
    return request_of_part_bytes(read_at(folder, run.parts[part_id].place)).vertices


def factors(folder, run):
    """The present mesh of each part, told by its size."""
    return {part_id: round(float(vertices(folder, run, part_id).max() / VERTICES.max()), 6)
            for part_id in run.parts}


class TestMeshes:
    @pytest.fixture
    def writing(self, tmp_path):
        return Writing(tmp_path, 0)

    def test_the_last_one(self, writing, tmp_path):
        for factor in (1.0, 2.0, 3.0):
            writing.part("part", factor)
        writing.end()
        assert factors(tmp_path, found(tmp_path)) == {"part": 3.0}

    def test_an_earlier_one_that_came_back(self, writing, tmp_path):
        for factor in (1.0, 2.0, 3.0):
            writing.part("part", factor)
            writing.part(f"other {factor}", 5.0)
        writing.result("part", 2.0, 4)
        writing.end()
        run = found(tmp_path)
        assert factors(tmp_path, run) == {
            "other 1.0": 5.0, "other 2.0": 5.0, "other 3.0": 5.0, "part": 2.0}
        assert list(run.parts)[-1] == "part"
        assert run.results["part"].revision == 4

    def test_one_without_a_result(self, writing, tmp_path):
        writing.part("part", 1.0)
        writing.mesh("part", 2.0)
        writing.end()
        assert factors(tmp_path, found(tmp_path)) == {"part": 2.0}

    def test_a_forgotten_part(self, writing, tmp_path):
        writing.part("part", 1.0)
        writing.part("other", 1.0)
        writing.event(JobEvent.PART_FORGOTTEN, part_id="part")
        writing.end()
        run = found(tmp_path)
        assert factors(tmp_path, run) == {"other": 1.0} and "part" not in run.results

    def test_a_part_whose_last_word_is_that_it_was_forgotten(self, writing, tmp_path):
        """Where the node ended before it could say so in a second way."""
        for part_id in ("part", "other", "FORGOTTEN: for a reason"):
            writing.part(part_id, 1.0)
        writing.farewell("part", 1.0)
        writing.farewell("other", 1.0, poses=[StablePose()])  # there they are
        writing.end()
        run = found(tmp_path)
        assert factors(tmp_path, run) == {"other": 1.0, "FORGOTTEN: for a reason": 1.0}
        assert "part" not in run.results

    def test_a_forgotten_part_that_came_back(self, writing, tmp_path):
        writing.part("part", 1.0)
        writing.part("part", 2.0)
        writing.event(JobEvent.PART_FORGOTTEN, part_id="part")
        writing.result("part", 1.0, 7)
        writing.end()
        run = found(tmp_path)
        assert factors(tmp_path, run) == {"part": 1.0} and run.results["part"].revision == 7

    def test_a_result_without_a_mesh(self, writing, tmp_path):
        writing.result("part", 1.0)
        writing.end()
        assert factors(tmp_path, found(tmp_path)) == {}


class TestBags:
    def test_the_newest_of_those_that_ended_well(self, tmp_path):
        for number in range(3):
            writing = Writing(tmp_path, number)
            writing.part(f"part {number}", 1.0)
            writing.end()
        assert list(found(tmp_path).parts) == ["part 2"]

    def test_nothing_there(self, tmp_path):
        assert found(tmp_path).parts == found(tmp_path / "missing").parts == {}
        (tmp_path / "file").write_text("")
        assert found(tmp_path / "file").parts == {}

    def test_those_of_another_node_are_not_taken(self, tmp_path):
        for number, node in enumerate(("pose_stats", "other", "other")):
            writing = Writing(tmp_path, number, node)
            writing.part(f"part {number}", 1.0)
            writing.event(JobEvent.QUEUED, f"job {number}")
            writing.die() if number == 2 else writing.end()
        run = found(tmp_path)
        assert list(run.parts) == ["part 0"] and list(run.unfinished) == ["job 0"]

    def test_starts_that_were_killed_on_the_way(self, tmp_path):
        """A node mends bags only when all that they leave is in its own."""
        first = Writing(tmp_path, 0)
        for part_id in "abc":
            first.part(part_id, 1.0)
        for job_id in ("one", "two"):
            first.event(JobEvent.QUEUED, job_id)
        first.die()
        second = Writing(tmp_path, 1)
        second.event(JobEvent.CANCELLED, "one")
        second.die()
        third = Writing(tmp_path, 2)
        third.event(JobEvent.CANCELLED, "two")
        third.part("a", 1.0)
        third.die()
        run = found(tmp_path)
        assert sorted(run.parts) == ["a", "b", "c"] and run.unfinished == {}
        repair_bags(tmp_path)
        assert sorted(found(tmp_path).parts) == ["a"]

    def test_a_run_that_was_killed_and_the_one_before(self, tmp_path):
        first = Writing(tmp_path, 0)
        first.part("kept", 1.0)
        first.part("forgotten", 1.0)
        first.end()
        second = Writing(tmp_path, 1)
        second.event(JobEvent.PART_FORGOTTEN, part_id="forgotten")
        second.part("new", 2.0)
        second.event(JobEvent.QUEUED, "job")
        second.die()
        run = found(tmp_path)
        assert sorted(run.parts) == ["kept", "new"] and list(run.unfinished) == ["job"]

    def test_a_bag_that_cannot_be_read_is_named(self, tmp_path):
        writing = Writing(tmp_path, 0)
        writing.log.write("/pose_stats/part_mesh", serialize_message(JobEvent()), durable=False)
        writing.end()
        run = found(tmp_path)
        assert run.parts == {} and [bag.name for bag in run.problems] == [RUNS[0]]
