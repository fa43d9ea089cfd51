"""Parts of an earlier run on their way back: room is made, and newer meshes come first."""

from __future__ import annotations

import pytest

from ros_pose_stats.recording.run_names import runs
from ros_pose_stats.ros.diagnostics import Refusals
from ros_pose_stats.ros.messages.part_messages import request_of_message
from ros_pose_stats.ros.parts.mesh_queue import MeshQueue
from ros_pose_stats.ros.recorder import JOB_EVENTS, Recorder
from ros_pose_stats.ros.restart.earlier_runs import earlier_runs
from ros_pose_stats.ros.restart.handover import Handover, RunsInUse
from ros_pose_stats.ros.restart.last_run import last_run
from ros_pose_stats.ros.restart.restore import parts_to_restore, records_to_come, restore_parts
from ros_pose_stats.ros.settings import Settings

from ..harness.bags import size_of
from ..harness.client import until
from ..harness.parts import WEDGE, flat
from ..harness.quiet import fake_node, quiet_results
from .test_kept_before_it_goes import event
from .test_last_run import Writing

BOUND = 1_000_000
NODE = "/node"


class Started:
    """What a node has after its start on a folder, but for the node; no mesh comes by itself."""

    def __init__(self, folder):
        settings = Settings(log_directory=str(folder), max_log_bytes=BOUND)
        self.recorder = Recorder(settings, NODE, print)
        self.results = quiet_results(settings, self.recorder, fake_node([]))
        self.queue = MeshQueue(lambda: BOUND)
        found = earlier_runs(folder, NODE)
        self.parts = parts_to_restore(last_run(found.bags, 10), self.results)
        self.handover = Handover(self.recorder, found, [
            record for part in self.parts for record in part.records()])
        self.recorder.before_record = self.handover.settle
        self.recorder.on_gap = self._record_again
        self.recorder.log.keep_runs(RunsInUse(
            self.handover, self.results.parts.meshes, self.recorder.have_recorded_again))
        self.coming = restore_parts(self.parts, folder, self.results, self.queue,
                                    Refusals(print))

    def _record_again(self):
        self.results.record_again()
        self.handover.repeat(records_to_come(self.parts, self.results.parts))

    def flood(self, events):
        for _ in range(events):
            assert self.recorder.record(JOB_EVENTS, event("", 10_000))


@pytest.fixture
def started(tmp_path):
    writing = Writing(tmp_path, 0, NODE[1:])
    writing.part("kept", 1.0)
    writing.end()
    made = Started(tmp_path)
    yield made
    made.queue.close()
    made.recorder.close()


def left_to_the_next(folder):
    return list(last_run(earlier_runs(folder, NODE).bags, 10).parts)


def test_parts_that_do_not_come_for_long_are_not_lost(started, tmp_path):
    """The bound is exceeded by no more than a quarter, and the next start finds them."""
    (first,) = runs(tmp_path)
    for _ in range(40):
        started.flood(10)
        until(lambda: size_of(tmp_path) < 1.3 * BOUND, "as much room as there may be")
    assert first.is_dir() and started.recorder.log.own_files.deleted > 10
    assert started.recorder.health().warn
    started.recorder.close()
    assert left_to_the_next(tmp_path) == ["kept"]


def test_a_run_goes_once_its_parts_have_come(started, tmp_path):
    (first,) = runs(tmp_path)
    started.flood(100)
    assert first.is_dir() and size_of(tmp_path) > BOUND
    started.queue.start()
    (kept,) = [coming.result(timeout=60.0).part.part_id for coming in started.coming]

    def gone():
        started.flood(1)
        return not first.is_dir()

    until(gone, "the first run to be deleted")
    until(lambda: size_of(tmp_path) <= BOUND, "the bound")
    started.recorder.close()
    assert left_to_the_next(tmp_path) == [kept] == ["kept"]


def test_a_newer_mesh_that_came_first_stays(started):
    vertices, triangles = WEDGE
    newer = started.results.take_part(request_of_message(flat((1.3 * vertices, triangles),
                                                              "kept")))
    started.queue.start()
    (coming,) = started.coming
    assert coming.result(timeout=60.0) is newer
    assert started.results.parts.current("kept") is newer
    assert not started.results.parts.meshes.coming
