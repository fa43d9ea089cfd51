# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Bags as the node writes them, as `ros2 bag record` does, and as other tools do."""

from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as RosWriter
from rosbags.rosbag2 import StoragePlugin, Writer as RosbagWriter
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from std_msgs.msg import String

from .messages import (
    PACKAGE,
    SECOND,
    START,
    definition,
    run_of_a_node,
    serialised,
    type_name,
)


def everything(messages, namespace="/pose_stats"):
    """Pairs of full topic and message, with foreign messages in between."""
    for topic, message in run_of_a_node() if messages is None else messages:
        yield f"{namespace}/{topic}", message
        yield "/chatter", String(data="foreign")


def write_mcap(file, messages=None, namespace="/pose_stats", closed=True, **options):
    """An MCAP file, unchunked like the node's unless said otherwise.

    `closed` False leaves out index and footer, as a killed node does.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    schemas = {}
    channels = {}
    with file.open("wb") as stream:
        writer = Writer(
            stream,
            **{"use_chunking": False, "compression": CompressionType.NONE, **options},
        )
        writer.start("ros2", "test")
        for position, (topic, message) in enumerate(everything(messages, namespace)):
            name = type_name(message)
            if name not in schemas:
                schemas[name] = writer.register_schema(
                    name, "ros2msg", definition(name).encode()
                )
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "cdr", schemas[name])
            time = START + position * SECOND // 10
            writer.add_message(channels[topic], time, serialised(message), time)
        if closed:
            writer.finish()
    return file


def write_run(
    folder, messages=None, name="pose_stats_20260202T024000_000000_42", **options
):
    """A run directory of the node."""
    write_mcap(folder / name / f"{name}_0.mcap", messages, **options)
    (folder / name / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    return folder / name


def write_recorded(
    folder,
    messages=None,
    namespace="/cell1/pose_stats",
    storage=StoragePlugin.MCAP,
    mode=CompressionMode.STORAGE,
    later=0.003,
):
    """A bag in rosbag2's layout by a third party, whose recorder hears of everything
    later.
    """
    writer = RosbagWriter(folder, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        topics = {}
        for position, (topic, message) in enumerate(everything(messages, namespace)):
            name = type_name(message)
            if topic not in topics:
                topics[topic] = writer.add_connection(
                    topic, name, msgdef=definition(name), rihs01="RIHS01_" + "0" * 64
                )
            time = START + position * SECOND // 10 + round(later * SECOND)
            writer.write(topics[topic], time, serialised(message))
    return folder


def write_sqlite(folder):
    return write_recorded(
        folder, storage=StoragePlugin.SQLITE3, mode=CompressionMode.NONE
    )


def write_plain(file, messages):
    """A bag of another tool: triples of type, its definition and fields as plain
    values.
    """
    with file.open("wb") as stream, RosWriter(stream) as writer:
        for name, text, fields in messages:
            schema = writer.register_msgdef(f"{PACKAGE}/{name}", text)
            writer.write_message(f"/pose_stats/{name}", schema, fields, 5, 5)
    return file


def chunked(compression):
    return lambda folder: write_run(
        folder, use_chunking=True, chunk_size=4000, compression=compression
    )


RECORDERS = {
    "plain_mcap": write_run,
    "never_closed": lambda folder: write_run(folder, closed=False),
    "chunked_plain": chunked(CompressionType.NONE),
    "chunked_zstd": chunked(CompressionType.ZSTD),
    "chunked_lz4": chunked(CompressionType.LZ4),
    "third_party": lambda folder: write_recorded(folder / "bag"),
    "third_party_packed": lambda folder: write_recorded(
        folder / "bag", mode=CompressionMode.FILE
    ),
    "third_party_sqlite": lambda folder: write_sqlite(folder / "bag"),
    "own_namespace": lambda folder: write_run(
        folder, namespace="/cell2/feeder/pose_stats"
    ),
}
