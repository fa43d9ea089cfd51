"""Test bags: as the node writes them, as `ros2 bag record` does, and in other ways."""

from __future__ import annotations

from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagWriter
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from std_msgs.msg import String

from ros_pose_stats.recording.writer.message_types import message_type
from ros_pose_stats.recording.writer.run_log import RunLog
from tests.recording.analysis.messages import (
    SECOND,
    SHARE,
    START,
    counts,
    definition,
    drop_records,
    event,
    mesh,
    result,
    serialised,
    type_name,
)

SIMULATED = (1120, 470, 250, 120, 40)
COUNTED = (230, 98, 52, 16, 4)


def run_of_a_node():
    """What one run has to say: pairs of topic and message."""
    simulation = result(4.0, method="simulation", count=SIMULATED, job_id="job_1", seed=7)
    return [
        ("part_mesh", mesh()),
        ("pose_statistics", result(0.0)),
        ("job_events", event(1.0, "QUEUED")),
        ("job_events", event(1.1, "RUNNING")),
        ("pose_statistics", result(2.0, method="simulation", job_id="job_1", final=False, seed=7,
                                   count=(60, 20, 12, 7, 1))),
        ("drop_records", drop_records(0, [0, 1, 1, 2, -1])),
        ("answers", result(3.0, (0.5, 0.3, 0.1, 0.08, 0.02), "meae",
                           warnings=["LOW_DROP: released low."])),
        ("pose_statistics", simulation),
        ("answers", simulation),
        ("job_events", event(4.1, "DONE", drops_done=2000)),
        ("job_events", event(5.0, "QUEUED", "job_2")),
        ("job_events", event(5.1, "RUNNING", "job_2", drops_done=0)),
        ("pose_counts", counts(6.0, COUNTED, unclassified=9)),
        ("pose_counts", counts(7.0, (46, 20, 10, 4, 0), unclassified=1)),
    ]


def told(messages, namespace="/pose_stats"):
    """Pairs of full topic and message, with foreign messages in between."""
    for short, message in messages:
        yield f"{namespace}/{short}", message
        yield "/chatter", String(data="foreign")


def write_mcap(file, messages, namespace="/pose_stats", closed=True, definitions=None, **options):
    """An MCAP file; unchunked like the node's unless said otherwise.

    `definitions` maps names of types to other texts; `closed` False leaves out index and footer.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    schemas, channels = {}, {}
    with file.open("wb") as stream:
        writer = Writer(stream, **{"use_chunking": False,
                                   "compression": CompressionType.NONE, **options})
        writer.start("ros2", "test")
        for place, (topic, message) in enumerate(told(messages, namespace)):
            name = type_name(message)
            if name not in schemas:
                text = (definitions or {}).get(name) or definition(name)
                schemas[name] = writer.register_schema(name, "ros2msg", text.encode())
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "cdr", schemas[name])
            time = START + place * SECOND // 10
            data = message if isinstance(message, bytes) else serialised(message)
            writer.add_message(channels[topic], time, data, time)
        if closed:
            writer.finish()
    return file


def write_run(folder, messages=None, name="pose_stats_20260202T024000_000000_42", **options):
    """A run directory of the node."""
    write_mcap(folder / name / f"{name}_0.mcap", run_of_a_node() if messages is None else messages,
               **options)
    (folder / name / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    return folder / name


def write_by_run_log(folder):
    """A run directory by the node's own recorder."""
    messages = list(told(run_of_a_node()))
    types = {topic: message_type(type_name(message), lambda package: SHARE / package)
             for topic, message in messages}
    log = RunLog(folder, types, max_bag_bytes=1 << 29)
    for topic, message in messages:
        log.write(topic, serialised(message), durable=False)
    log.close()
    return log.directory


def write_recorded(folder, messages=None, namespace="/cell1/pose_stats",
                   storage=StoragePlugin.MCAP, mode=CompressionMode.STORAGE, later=0.003):
    """A bag in rosbag2's layout by a third party, whose recorder hears of everything later."""
    writer = RosbagWriter(folder, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        topics = {}
        pairs = told(run_of_a_node() if messages is None else messages, namespace)
        for place, (topic, message) in enumerate(pairs):
            name = type_name(message)
            if topic not in topics:
                topics[topic] = writer.add_connection(
                    topic, name, msgdef=definition(name), rihs01="RIHS01_" + "0" * 64)
            time = START + place * SECOND // 10 + round(later * SECOND)
            writer.write(topics[topic], time, serialised(message))
    return folder

