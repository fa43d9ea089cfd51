"""Runs whose messages had other fields, by bags that describe them without the newer ones."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from mcap.reader import make_reader
from mcap_ros2.writer import Writer as McapWriter
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics, StablePose

from ros_pose_stats.recording.reader.raw_reader import raw_messages
from ros_pose_stats.recording.writer.run_log import RunLog
from ros_pose_stats.ros.restart.earlier_runs import RUNS_TAKEN_IN, Taken, earlier_runs
from ros_pose_stats.ros.restart.last_run import scene_of
from ros_pose_stats.ros.restart.recorded_messages import read_recorded
from ros_pose_stats.ros.restart.restore import end_unfinished_jobs
from ros_pose_stats.ros.settings import Settings
from ros_pose_stats.version import VERSION

from .test_last_run import RUNS, TYPES, Writing, factors, found

FIELDS = ("uint32 round_sides\n", "float64 largest_error\n", "string scene\n")


def older(definition):
    """A definition without the newer fields."""
    for field in FIELDS:
        definition = definition.replace(field, "")
    return definition


OLDER = {topic: replace(kind, definition=older(kind.definition)) for topic, kind in TYPES.items()}


def older_bytes(message, kind):
    """A message by an older definition, in the encoding of a library."""
    stream = io.BytesIO()
    with McapWriter(stream) as writer:
        writer.write_message("/x", writer.register_msgdef(kind.name, kind.definition), message)
    stream.seek(0)
    ((_, _, told),) = make_reader(stream).iter_messages()
    return told.data


class OlderWriting(Writing):
    """A run of a node from before the newer fields."""

    def __init__(self, folder, number):
        self.log = RunLog(folder, OLDER, max_bag_bytes=1 << 29, name=RUNS[number],
                          node="/pose_stats")

    def _write(self, topic, message):
        topic = f"/pose_stats/{topic}"
        self.log.write(topic, older_bytes(message, OLDER[topic]), durable=False)

    def job(self, **fields):
        self._write("job_events", JobEvent(
            event=JobEvent.QUEUED, part_id="part", restitution=0.25, drop_height=0.5,
            cluster_tolerance=0.005, max_seconds=60.0, drops=1000, **fields))

    def statistics(self, **fields):
        self._write("pose_statistics", PoseStatistics(**fields))


@pytest.fixture
def writing(tmp_path):
    return OlderWriting(tmp_path, 0)


class FakeJobs:
    """Takes ended jobs."""

    def add_ended(self, jobs):
        self.ended = list(jobs)


@pytest.mark.parametrize("seed", [0, 192, 2**40 + 7])
def test_an_unfinished_job_is_ended_as_it_was_asked_for(writing, tmp_path, seed):
    writing.job(job_id="cut off", seed=seed)
    writing.job(job_id="ended", seed=seed)
    writing.event(JobEvent.DONE, "ended")
    writing.die()
    run = found(tmp_path)
    assert run.problems == {}
    (event,) = run.unfinished.values()
    scene = scene_of(event)
    assert (scene.restitution, scene.drop_height) == (0.25, 0.5)
    assert (scene.cluster_tolerance, scene.round_sides) == (0.005, 0)
    jobs = FakeJobs()
    ((_, data),) = end_unfinished_jobs(run, Settings(), jobs, lambda line: None)
    end = deserialize_message(data, JobEvent)
    assert (end.event, end.job_id, end.seed, end.drops, end.max_seconds, end.round_sides) == (
        JobEvent.CANCELLED, "cut off", seed, 1000, 60.0, 0)
    assert [job.job_id for job in jobs.ended] == ["cut off"]


def test_parts_come_back_and_forgotten_ones_do_not(writing, tmp_path):
    writing.part("part", 1.0)
    writing.part("forgotten", 2.0)
    writing.event(JobEvent.PART_FORGOTTEN, part_id="forgotten")
    writing.end()
    run = found(tmp_path)
    assert factors(tmp_path, run) == {"part": 1.0} and run.problems == {}


def test_of_a_result_the_number_alone_is_gone_on_with(writing, tmp_path):
    """Versions may be equal while the messages have changed, as between two releases."""
    writing.mesh("part", 1.0)
    writing.statistics(part_id="part", part_digest="digest", revision=70, version=VERSION,
                       cluster_tolerance=0.005, poses=[StablePose(probability=1.0)])
    writing.end()
    run = found(tmp_path)
    result = run.results["part"]
    assert (result.part_digest, result.revision, result.version) == ("digest", 70, "")
    assert run.parts["part"].digest == "digest" and run.problems == {}


def test_runs_that_it_has_taken_in_stay_taken_in(tmp_path):
    first = Writing(tmp_path, 0)
    first.part("part", 1.0)
    first.end()
    second = OlderWriting(tmp_path, 1)
    second._write("job_events", JobEvent(event=RUNS_TAKEN_IN,
                                         message=Taken(True, RUNS[0]).text()))
    second.die()
    assert list(earlier_runs(tmp_path, "/pose_stats").bags) == [RUNS[1]]


def test_damage_costs_a_message(writing, tmp_path):
    data = older_bytes(JobEvent(job_id="x" * 40), OLDER["/pose_stats/job_events"])
    writing.log.write("/pose_stats/job_events", data[:40], durable=False)
    writing.job(job_id="cut off")
    writing.die()
    run = found(tmp_path)
    assert list(run.unfinished) == ["cut off"]
    assert "by the definition in the bag" in run.problems[tmp_path / RUNS[0]]


def test_lists_and_parts_of_a_message_come_along(writing, tmp_path):
    assert all(field in TYPES["/pose_stats/pose_statistics"].definition for field in FIELDS)
    told = PoseStatistics(part_id="part", warnings=["A: b", "C: d"], seed=2**63, radius=0.25)
    told.header.stamp.sec, told.header.frame_id = 5, "plate"
    told.compute_time.nanosec = 7
    writing._write("pose_statistics", told)
    writing.end()
    (message,) = (one for one in raw_messages(tmp_path / RUNS[0])
                  if one.topic == "/pose_stats/pose_statistics")
    assert read_recorded(message, PoseStatistics) == told
