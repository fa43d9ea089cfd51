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

"""What the node has recorded, finished or not, as the mcap tools and `rosbags` read
it.
"""

import struct
from contextlib import suppress
from functools import lru_cache

from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs import msg

from tests.matching import same

KINDS = {
    "part_mesh": msg.PartMesh,
    "pose_statistics": msg.PoseStatistics,
    "answers": msg.PoseStatistics,
    "job_events": msg.JobEvent,
    "pose_counts": msg.PoseCounts,
    "drop_records": msg.DropRecords,
}
"""Types by topic."""


def on_topic(name):
    """Full name of one of the bag's topics."""
    return f"/pose_stats/{name}"


def bags_of(log_directory):
    """All bags of a folder, oldest first; a kill may leave a run without a file, which
    is none.
    """
    return sorted(filter(files_of, log_directory.glob("pose_stats_*")))


def files_of(bag):
    """Files of a bag in the order in which they were begun."""
    return sorted(
        bag.glob("*.mcap"), key=lambda path: int(path.stem.rpartition("_")[2])
    )


def raw(bag):
    """Topic and bytes of all whole messages of a bag, also of one that has no end."""
    messages = []
    for path in files_of(bag):
        topics = {}
        with path.open("rb") as file, suppress(McapError, struct.error):
            for record in StreamReader(file).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message):
                    messages.append((topics[record.channel_id], record.data))
    return messages


def message_of(topic, data):
    """The message that recorded bytes stand for."""
    return deserialize_message(data, KINDS[topic.rpartition("/")[2]])


@lru_cache(maxsize=100_000)
def values_of(topic, data):
    """The same as text; the bytes between the values of a serialised message are
    arbitrary.
    """
    return str(message_of(topic, data))


def raw_of(log_directory, topic):
    """Bytes of one topic's messages in all bags of a folder."""
    return [
        data
        for bag in bags_of(log_directory)
        for name, data in raw(bag)
        if name == topic
    ]


def recorded(log_directory, topic):
    """Messages of one topic in all bags of a folder, in the order of the runs."""
    name = on_topic(topic)
    return [message_of(name, data) for data in raw_of(log_directory, name)]


def ends(log_directory):
    """Events that end a job, by job."""
    endings = {}
    for event in recorded(log_directory, "job_events"):
        if event.status.state >= msg.JobStatus.DONE:
            endings.setdefault(event.status.job_id, []).append(event)
    return endings


def size_of(folder, pattern="*"):
    """Bytes of all files in a folder; what is deleted meanwhile counts nothing."""
    total = 0
    for path in folder.rglob(pattern):
        with suppress(FileNotFoundError):
            total += path.stat().st_size if path.is_file() else 0
    return total


def by_rosbags(bag):
    """Topic, bytes and decoded message of all messages, by `rosbags`."""
    from rosbags.highlevel import AnyReader

    with AnyReader([bag]) as reader:
        for connection in reader.connections:
            assert reader.typestore.hash_rihs01(connection.msgtype) == connection.digest
        return [
            (
                connection.topic,
                bytes(data),
                reader.deserialize(data, connection.msgtype),
            )
            for connection, _, data in reader.messages()
        ]


def by_mcap_ros2(bag):
    """The same by `mcap-ros2-support`, which needs whole files."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    messages = []
    for file in files_of(bag):
        with file.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            messages += [
                (channel.topic, bytes(message.data), decoded)
                for _, channel, message, decoded in reader.iter_decoded_messages()
            ]
    return messages


def assert_readable_by_others(bag):
    """Both tools read every message that the file holds, with the values that ROS
    reads.
    """
    expected = raw(bag)
    by_ros = [message_of(topic, data) for topic, data in expected]
    for read in (by_rosbags, by_mcap_ros2):
        messages = read(bag)
        assert [(topic, data) for topic, data, _ in messages] == expected
        decoded = [message for _, _, message in messages]
        assert all(map(same, decoded, by_ros))
