"""No file of the running bag goes before what still counts in it was recorded again."""

from __future__ import annotations

import threading

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats.recording.reader.raw_reader import raw_messages
from ros_pose_stats.ros.recorder import JOB_EVENTS, Recorder
from ros_pose_stats.ros.settings import Settings

from ..harness.bags import size_of
from ..harness.client import until

BOUND = 1_000_000


def event(job_id: str, size: int = 0) -> bytes:
    return serialize_message(JobEvent(job_id=job_id, message="x" * size))


class Slow:
    """A recorder, and one event that counts; it is recorded again once `may` is set."""

    def __init__(self, folder):
        self.recorder = Recorder(Settings(log_directory=str(folder), max_log_bytes=BOUND),
                                 "/node", print)
        self.may = threading.Event()
        self.recorder.on_gap = self._again
        self.kept = event("kept")
        self._mark = 0
        self._record()

    def _record(self):
        mark = self.recorder.mark
        assert self.recorder.record(JOB_EVENTS, self.kept)
        self._mark = mark

    def _again(self):
        self.may.wait()
        if self._mark < self.recorder.trusted_from:
            self._record()

    def flood(self, events, size=10_000):
        for _ in range(events):
            assert self.recorder.record(JOB_EVENTS, event("flood", size))

    def is_there(self):
        return any(message.data == self.kept
                   for message in raw_messages(self.recorder.log.directory))


@pytest.fixture
def slow(tmp_path):
    made = Slow(tmp_path)
    yield made
    made.may.set()
    made.recorder.close()


def test_a_quick_flood_does_not_overtake_it(slow, tmp_path):
    slow.flood(150)
    assert slow.is_there()
    assert size_of(tmp_path) > BOUND
    assert slow.recorder.health().text == (
        "log_directory is larger than max_log_bytes, until what counts in its oldest files has "
        "been recorded again")
    slow.may.set()
    until(lambda: size_of(tmp_path) <= BOUND, "the bound")
    assert slow.is_there()
    until(lambda: not slow.recorder.log.over_bound, "the word that it is kept")


def test_a_record_larger_than_a_file_does_not_push_it_out(slow, tmp_path):
    slow.flood(60)
    slow.flood(1, 700_000)
    assert slow.is_there()
    slow.may.set()
    slow.flood(1)
    until(lambda: size_of(tmp_path) <= BOUND, "the bound")
    assert slow.is_there()
