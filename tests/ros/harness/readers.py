"""Bags of the node, read by this package and by other people's tools."""

from __future__ import annotations

from functools import lru_cache

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs import msg

from ros_pose_stats.recording.reader.raw_reader import raw_messages
from ros_pose_stats.recording.run_names import bag_files, runs
from ros_pose_stats.ros.recorder import bag_types
from tests.matching import same

TYPES = bag_types()


def on_topic(name):
    """Full name of one of the bag's topics."""
    return f"/pose_stats/{name}"


def message_of(topic, data):
    """The message that recorded bytes stand for."""
    return deserialize_message(data, getattr(msg, TYPES[topic].name.rpartition("/")[2]))


@lru_cache(maxsize=100_000)
def values_of(topic, data):
    """The same as text; the bytes between the values of a serialised message are arbitrary."""
    return str(message_of(topic, data))


def raw(bag):
    """Topic and bytes of all messages of a bag, as this package reads them."""
    return [(one.topic, bytes(one.data)) for one in raw_messages(bag)]


def raw_of(log_directory, topic):
    """Bytes of one topic's messages in all bags of a folder."""
    return [data for bag in runs(log_directory) for name, data in raw(bag) if name == topic]


def by_rosbags(bag):
    """Topic, bytes and decoded message of all messages, by `rosbags`."""
    from rosbags.highlevel import AnyReader

    with AnyReader([bag]) as reader:
        for one in reader.connections:
            assert one.digest == TYPES[one.topic].type_hash
            assert reader.typestore.hash_rihs01(one.msgtype) == one.digest
        return [(one.topic, bytes(data), reader.deserialize(data, one.msgtype))
                for one, _, data in reader.messages()]


def by_mcap_ros2(bag):
    """The same by `mcap-ros2-support`."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    found = []
    for file in bag_files(bag):
        with file.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            found += [(channel.topic, bytes(message.data), decoded) for
                      _, channel, message, decoded in reader.iter_decoded_messages()]
    return found


def assert_readable_by_others(bag):
    """Both tools find the messages that this package finds, with the same values."""
    expected = raw(bag)
    for read in (by_rosbags, by_mcap_ros2):
        found = read(bag)
        assert [(topic, data) for topic, data, _ in found] == expected
        for topic, data, decoded in found:
            assert same(decoded, message_of(topic, data))
