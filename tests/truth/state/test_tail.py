"""What the last bag has beyond the state is taken in by the next start, from its beginning on."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PoseCounts

from ros_pose_stats.ros.recorder import POSE_COUNTS, Recorder
from ros_pose_stats.ros.restore import tail_of
from ros_pose_stats.ros.settings import settings_of
from ros_pose_stats.ros.state import State

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")
"""Of a library by which rclpy reads messages."""


@pytest.mark.parametrize("deleted", [False, True])
def test_counts_of_a_bag_that_was_never_synced(tmp_path, deleted):
    """Also of one that was begun because another was deleted."""
    file = tmp_path / "pose_stats.sqlite3"
    state = State(file)
    recorder = Recorder(settings_of({"log_directory": str(tmp_path / "log")}), "/pose_stats",
                        state, lambda line: None)

    def count(number):
        assert recorder.record(POSE_COUNTS, serialize_message(
            PoseCounts(part_id="clamp", index=[0], count=[number])))

    recorder.note_place()
    if deleted:
        count(1)
        recorder.note_place()
        shutil.rmtree(recorder.log.directory)
    count(2)
    count(3)
    state.close()
    again = State(file)
    assert [counts.count[0] for counts in tail_of(again, pytest.fail).counts] == [2, 3]
    again.close()
    recorder.close()


def test_a_record_after_a_deleted_bag_waits_for_no_step(tmp_path):
    """Who records may hold a part's name, for which the holder of the step waits."""
    state = State(tmp_path / "pose_stats.sqlite3")
    recorder = Recorder(settings_of({"log_directory": str(tmp_path / "log")}), "/pose_stats",
                        state, lambda line: None)
    data = serialize_message(PoseCounts(part_id="clamp"))
    assert recorder.record(POSE_COUNTS, data)
    shutil.rmtree(recorder.log.directory)
    with ThreadPoolExecutor(1) as other, recorder.step:
        assert other.submit(recorder.record, POSE_COUNTS, data).result(timeout=60.0)
    recorder.close()
    state.close()
