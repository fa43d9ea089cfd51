"""Bags with real messages, read by other people's tools."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.run_names import bag_files
from ros_pose_stats.recording.writer.message_types import CdrLength, message_type
from ros_pose_stats.recording.writer.run_log import RunLog
from tests.matching import same
from tests.recording.bags import let_die

pytest.importorskip("rclpy")
pytest.importorskip("ros_pose_stats_msgs")

# What rclpy imports still uses old names of modules of Python.
pytestmark = pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")

TOPICS = {"/pose_stats/part_mesh": "PartMesh", "/pose_stats/pose_statistics": "PoseStatistics",
          "/pose_stats/answers": "PoseStatistics", "/pose_stats/job_events": "JobEvent",
          "/pose_stats/pose_counts": "PoseCounts", "/pose_stats/drop_records": "DropRecords"}


@pytest.fixture(scope="module")
def messages():
    """A topic and a message each."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_PYTHON_CHECK_FIELDS", "1")
        from ros_pose_stats_msgs.msg import (
            DropRecords,
            JobEvent,
            PartMesh,
            PoseCounts,
            PoseStatistics,
            StablePose,
        )

        part = PartMesh(part_id="clamp", vertices=np.arange(12.0) / 7, unit=0.001,
                        triangles=np.arange(12, dtype=np.uint32))
        part.inertia.m = 0.25
        statistics = PoseStatistics(part_id="clamp", method="combined", drops=2**40,
                                    expected_error=float("nan"), warnings=["CLUSTERED: yes"])
        statistics.header.frame_id = "plate"
        statistics.header.stamp.sec = 1234
        statistics.poses = [StablePose(index=k, pose_id=f"clamp/{k}", probability=1 / (k + 2),
                                       barrier=float("inf"), outline=[0.1, 0.2, 0.3])
                            for k in range(3)]
        yield [
            ("/pose_stats/part_mesh", part),
            ("/pose_stats/job_events", JobEvent(job_id="j", event=JobEvent.RUNNING, drops=7)),
            ("/pose_stats/pose_statistics", statistics),
            ("/pose_stats/answers", statistics),
            ("/pose_stats/pose_counts", PoseCounts(part_id="clamp", index=[0, 2], count=[5, 9],
                                                   drop_height=-1.0)),
            ("/pose_stats/drop_records", DropRecords(start_down=[0.5, 0.25], pose_index=[-1, 3],
                                                     stopped_at_trap=True)),
        ]


@pytest.fixture(params=["closed", "repaired", "rotated", "bounded"])
def bag(request, tmp_path, messages):
    """A bag with all of them, and their bytes."""
    from rclpy.serialization import serialize_message

    types = {topic: message_type(f"ros_pose_stats_msgs/msg/{kind}",
                                 lambda package: Path(sys.prefix) / "share" / package)
             for topic, kind in TOPICS.items()}
    rotated, bounded = (request.param == one for one in ("rotated", "bounded"))
    log = RunLog(tmp_path, types, max_bag_bytes=1 if rotated or bounded else 1 << 29,
                 max_log_bytes=1_000_000 if bounded else 0)
    if bounded:
        topic, mesh = messages[0]
        large = type(mesh)(vertices=np.zeros(120_000))
        log.write(topic, serialize_message(large), durable=False)
    recorded = []
    for topic, message in messages:
        data = serialize_message(message)
        log.write(topic, data, durable=True)
        recorded.append((topic, bytes(CdrLength(types[topic]).trimmed(data))))
    if request.param == "repaired":
        let_die(log)
        assert len(repair_bags(tmp_path)) == 1
    else:
        log.close()
    assert log.own_files.deleted == bounded
    return log.directory, types, recorded


def test_rosbags_reads_the_directory(bag, messages):
    highlevel = pytest.importorskip("rosbags.highlevel")
    directory, types, recorded = bag
    with highlevel.AnyReader([directory]) as reader:
        assert {one.topic: one.msgtype for one in reader.connections} == {
            topic: kind.name for topic, kind in types.items()}
        for one in reader.connections:
            assert one.digest == types[one.topic].type_hash
            assert reader.typestore.hash_rihs01(one.msgtype) == one.digest
            assert one.msgcount == 1
            [qos] = one.ext.offered_qos_profiles
            assert qos.reliability.name == "RELIABLE" and qos.history.name == "KEEP_LAST"
            latched = one.topic in ("/pose_stats/part_mesh", "/pose_stats/pose_statistics")
            assert qos.durability.name == ("TRANSIENT_LOCAL" if latched else "VOLATILE")
        found = list(reader.messages())
        assert [(one.topic, data) for one, _, data in found] == recorded
        times = [time for _, time, _ in found]
        assert times == sorted(times)
        assert reader.message_count == len(recorded)
        assert (reader.start_time, reader.end_time) == (times[0], times[-1] + 1)
        read = {one.topic: reader.deserialize(data, one.msgtype) for one, _, data in found}
    statistics = dict(messages)["/pose_stats/answers"]
    assert read["/pose_stats/answers"].drops == 2**40
    assert np.isnan(read["/pose_stats/answers"].expected_error)
    assert read["/pose_stats/answers"].poses[1].probability == statistics.poses[1].probability
    assert np.array_equal(read["/pose_stats/part_mesh"].vertices, np.arange(12.0) / 7)


def test_rosbags_reads_each_file_by_itself(bag):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    directory, _, recorded = bag
    found = []
    for file in bag_files(directory):
        with rosbag2.Reader(file) as reader:
            found += [(one.topic, data) for one, _, data in reader.messages()]
    assert found == recorded


def test_mcap_ros2_support_decodes_the_files(bag, messages):
    reader = pytest.importorskip("mcap_ros2.reader")
    found = [message for file in bag_files(bag[0])
             for message in reader.read_ros2_messages(str(file))]
    assert [message.channel.topic for message in found] == [topic for topic, _ in messages]
    for message, (_, recorded) in zip(found, messages, strict=True):
        assert same(message.ros_msg, recorded)


def test_mcap_finds_summary_and_metadata(bag):
    from mcap.reader import NonSeekingReader, make_reader

    for file in bag_files(bag[0]):
        with file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            header, summary = reader.get_header(), reader.get_summary()
            records = list(reader.iter_metadata())
        assert header.profile == "ros2" and header.library.startswith("ros_pose_stats ")
        assert summary.statistics.message_count == sum(
            summary.statistics.channel_message_counts.values()) > 0
        assert summary.statistics.metadata_count == len(records) == 2
        assert {one.encoding for one in summary.schemas.values()} == {"ros2msg"}
        assert {one.message_encoding for one in summary.channels.values()} == {"cdr"}
        assert {record.name for record in records} == {"rosbag2"}
        described = yaml.safe_load(records[-1].metadata["serialized_metadata"])
        assert described["version"] == 9
        assert described["message_count"] == summary.statistics.message_count
        with file.open("rb") as stream:
            by_scan = list(NonSeekingReader(stream).iter_metadata())
        assert by_scan == records


def test_the_description_is_complete(bag):
    directory, types, recorded = bag
    whole = yaml.safe_load((directory / "metadata.yaml").read_text())
    about = whole.pop("rosbag2_bagfile_information")
    assert whole == {}
    assert set(about) == {
        "version", "storage_identifier", "duration", "starting_time", "message_count",
        "topics_with_message_count", "compression_format", "compression_mode",
        "relative_file_paths", "files", "custom_data", "ros_distro"}
    assert (about["version"], about["storage_identifier"], about["ros_distro"]) == (
        9, "mcap", "jazzy")
    assert about["compression_format"] == about["compression_mode"] == ""
    assert about["message_count"] == len(recorded)
    assert about["relative_file_paths"] == [file.name for file in bag_files(directory)]
    assert [file["path"] for file in about["files"]] == about["relative_file_paths"]
    assert sum(file["message_count"] for file in about["files"]) == len(recorded)
    for topic in about["topics_with_message_count"]:
        assert topic["message_count"] == 1
        kind = types[topic["topic_metadata"]["name"]]
        assert topic["topic_metadata"]["type"] == kind.name
        assert topic["topic_metadata"]["type_description_hash"] == kind.type_hash
        assert topic["topic_metadata"]["serialization_format"] == "cdr"
        [qos] = topic["topic_metadata"]["offered_qos_profiles"]
        assert set(qos) == {
            "history", "depth", "reliability", "durability", "deadline", "lifespan",
            "liveliness", "liveliness_lease_duration", "avoid_ros_namespace_conventions"}
        assert (qos["history"], qos["liveliness"]) == ("keep_last", "automatic")
    assert len(about["topics_with_message_count"]) == len(types)
    start = about["starting_time"]["nanoseconds_since_epoch"]
    assert start == min(file["starting_time"]["nanoseconds_since_epoch"]
                        for file in about["files"])
    assert about["duration"]["nanoseconds"] > 0
