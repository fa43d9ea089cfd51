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

"""What rosbag2 of Jazzy asks of a file that it plays by time, from its C++ sources.

Every condition names the function that has it: of `mcap_storage.cpp` in
rosbag2_storage_mcap, of `yaml.hpp` and `qos.cpp` in rosbag2_storage, or of mcap.
"""

import yaml
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Metadata
from mcap.stream_reader import StreamReader

TEXTS = ("storage_identifier", "compression_format", "compression_mode", "ros_distro")
POLICIES = {
    "history": {"keep_last", "keep_all", "system_default", "unknown"},
    "reliability": {"reliable", "best_effort", "system_default", "unknown"},
    "durability": {"volatile", "transient_local", "system_default", "unknown"},
    "liveliness": {"automatic", "manual_by_topic", "system_default", "unknown"},
}
DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")


def assert_played_by_time(file):
    """`ros2 bag info -v` and `play` read a file in the order of its log times."""
    content = file.read_bytes()
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        header = reader.get_header()
        summary = reader.get_summary()
        times = [message.log_time for _, _, message in reader.iter_messages()]
    assert header.profile == "ros2"
    assert times == sorted(times)
    # `readSummary`: without statistics all of the file would be searched
    statistics = summary.statistics
    assert statistics.message_count == len(times)
    assert sum(statistics.channel_message_counts.values()) == len(times)
    assert statistics.message_start_time == min(times, default=0)
    assert statistics.message_end_time == max(times, default=0)
    # `message_indexes_present`, which `set_read_order` asks: "Failed to set read order"
    for chunk in summary.chunk_indexes:
        assert chunk.message_index_length > 0
        assert chunk.compression == "zstd"
        # `IndexedMessageReader` reads the index of each channel at its offset
        for offset in chunk.message_index_offsets.values():
            assert content[offset] == Opcode.MESSAGE_INDEX
    assert summary.chunk_indexes or not times
    # `read_metadata`: the record of this name, then topics as the summary has them
    assert_metadata_is_read(content, summary)
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
        assert_profiles_are_read(
            yaml.safe_load(channel.metadata["offered_qos_profiles"])
        )
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")


def assert_metadata_is_read(content, summary):
    """`convert<BagMetadata>::decode` finds each field, in the type that it reads."""
    (index,) = [entry for entry in summary.metadata_indexes if entry.name == "rosbag2"]
    end = index.offset + index.length
    record = next(record_of(content[index.offset : end]))
    assert isinstance(record, Metadata) and record.name == "rosbag2"
    information = yaml.safe_load(record.metadata["serialized_metadata"])
    assert information["version"] == 9
    assert all(isinstance(information[name], str) for name in TEXTS)
    assert information["custom_data"] in (None, {})
    assert isinstance(information["relative_file_paths"], list)
    assert information["message_count"] == summary.statistics.message_count
    for entry in (information, *information["files"]):
        assert entry["duration"]["nanoseconds"] >= 0
        assert entry["starting_time"]["nanoseconds_since_epoch"] >= 0
        assert entry["message_count"] >= 0
    assert all(isinstance(entry["path"], str) for entry in information["files"])
    for topic in information["topics_with_message_count"]:
        assert topic["message_count"] >= 0
        metadata = topic["topic_metadata"]
        for name in ("name", "type", "serialization_format", "type_description_hash"):
            assert isinstance(metadata[name], str)
        assert_profiles_are_read(metadata["offered_qos_profiles"])


def record_of(data):
    """The records in some bytes."""
    from io import BytesIO

    return StreamReader(BytesIO(data), skip_magic=True).records


def assert_profiles_are_read(profiles):
    """`convert<QoS>::decode`, which tells words (version 9) from numbers."""
    for profile in profiles:
        for name, words in POLICIES.items():
            assert profile[name] in words
        for name in DURATIONS:
            assert 0 <= profile[name]["sec"] < 2**63
            assert 0 <= profile[name]["nsec"] < 10**9
        assert isinstance(profile["depth"], int)
        assert isinstance(profile["avoid_ros_namespace_conventions"], bool)
