"""What the last bag has beyond the state is taken in by the next start, from its beginning on."""

import shutil
from concurrent.futures import ThreadPoolExecutor

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PoseCounts

from ros_pose_stats.recording.repair import mend
from ros_pose_stats.ros.recorder import POSE_COUNTS, Recorder
from ros_pose_stats.ros.restore import tail_of
from ros_pose_stats.ros.settings import settings_of
from ros_pose_stats.ros.state import State

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")
"""Of a library by which rclpy reads messages."""


def started(folder):
    state = State(folder / "pose_stats.sqlite3")
    return state, Recorder(settings_of({"log_directory": str(folder / "log")}), "/pose_stats",
                           state, lambda line: None)


@pytest.mark.parametrize("fate", ["kept", "deleted", "mended"])
def test_counts_of_a_bag_that_was_never_synced(tmp_path, fate):
    """Also of one begun because another was deleted, and of one that another node has mended."""
    state, recorder = started(tmp_path)

    def count(number):
        assert recorder.record(POSE_COUNTS, serialize_message(
            PoseCounts(part_id="clamp", index=[0], count=[number])))

    recorder.note_place()
    if fate != "kept":
        count(1)
        recorder.note_place()
    if fate == "deleted":
        shutil.rmtree(recorder.log.directory)
    count(2)
    count(3)
    state.close()
    if fate == "mended":  # what was damaged before the place is cut off
        (bag,) = recorder.log.directory.glob("*.mcap")
        bag.write_bytes(bag.read_bytes().replace(b"clamp", b"clamq", 1))
        mend(recorder.log.directory)
    again = State(state.file)
    assert [counts.count[0] for counts in tail_of(again, pytest.fail).counts] == [2, 3]
    again.close()
    recorder.close()


def test_a_record_after_a_deleted_bag_waits_for_no_step(tmp_path):
    """Who records may hold a part's name, for which the holder of the step waits."""
    state, recorder = started(tmp_path)
    data = serialize_message(PoseCounts(part_id="clamp"))
    assert recorder.record(POSE_COUNTS, data)
    shutil.rmtree(recorder.log.directory)
    with ThreadPoolExecutor(1) as other, recorder.step:
        assert other.submit(recorder.record, POSE_COUNTS, data).result(timeout=60.0)
    recorder.close()
    state.close()
