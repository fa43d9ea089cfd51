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

"""The bytes of a bag's file: opening, messages, end, and its `metadata.yaml`.

Records stand by themselves, in no chunk, so that each is complete once it is on disk.
Every record but the header is preceded by a record of our own with the checksum of what
follows; MCAP leaves opcodes from 0x80 on to applications, and readers skip those they
do not know. Files that are closed are written anew with chunks: see `indexing.py`.
"""

import json
import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from textwrap import indent

from mcap import data_stream, opcode, records

from ....base.version import VERSION
from .message_types import MessageType

MAGIC = b"\x89MCAP0\r\n"
PROFILE = "ros2"
LIBRARY = f"ros_pose_stats {VERSION}"

CHECK_OPCODE = 0xC5
CHECK = struct.Struct("<BQI")
CHECK_START = struct.pack("<BQ", CHECK_OPCODE, 4)
"""How a checksum record begins; looked for behind damage."""

RECORD = struct.Struct("<BQ")  # opcode of a record and length of what follows

MESSAGE = struct.Struct("<HIQQ")
"""Channel, number within the channel, log time and publish time [ns]; then the data."""

_WHOLE_HEAD = CHECK.size + RECORD.size + MESSAGE.size

LATCHED = frozenset(("/pose_stats/part_mesh", "/pose_stats/pose_statistics"))
"""Topics whose late subscribers get the last messages, also of a bag that is played."""

_FOREVER = "\n    sec: 9223372036\n    nsec: 854775807"


@dataclass
class Contents:
    """Schemas, channels and counts of one file that is written or scanned."""

    schemas: dict[int, records.Schema] = field(default_factory=dict)  # by their ids
    channels: dict[int, records.Channel] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)  # messages a channel id
    # log time of the first and the last message [ns]; 0 without messages
    start: int = 0
    end: int = 0

    @property
    def messages(self) -> int:
        """How many messages there are."""
        return sum(self.counts.values())

    @property
    def descriptions(self) -> list[records.Schema | records.Channel]:
        """Schemas, then channels."""
        return [*self.schemas.values(), *self.channels.values()]

    def count(self, channel: int, log_time: int) -> None:
        """Take in one message."""
        if not self.counts:
            self.start = self.end = log_time
        self.start = min(self.start, log_time)
        self.end = max(self.end, log_time)
        self.counts[channel] += 1


Files = Mapping[str, Contents]  # contents of a bag's files by their names, in order


def metadata_yaml(files: Files) -> str:
    """Text of `metadata.yaml`."""
    return "rosbag2_bagfile_information:\n" + indent(bag_information(files), "  ")


def bag_information(files: Files) -> str:
    """What rosbag2 (its version 9) keeps of a bag, in YAML."""
    nonempty_contents = [
        contents for contents in files.values() if contents.messages
    ] or list(files.values())
    start = min(contents.start for contents in nonempty_contents)
    end = max(contents.end for contents in nonempty_contents)
    lines = [
        "version: 9",
        "storage_identifier: mcap",
        f"duration:\n  nanoseconds: {end - start}",
        f"starting_time:\n  nanoseconds_since_epoch: {start}",
        f"message_count: {sum(contents.messages for contents in nonempty_contents)}",
        _yaml_list("topics_with_message_count", _topics(files.values())),
        'compression_format: ""',
        'compression_mode: ""',
        _yaml_list("relative_file_paths", map(json.dumps, files)),
        _yaml_list(
            "files",
            (
                f"path: {json.dumps(name)}\n"
                f"starting_time:\n  nanoseconds_since_epoch: {contents.start}\n"
                f"duration:\n  nanoseconds: {contents.end - contents.start}\n"
                f"message_count: {contents.messages}"
                for name, contents in files.items()
            ),
        ),
        "custom_data: ~",
        "ros_distro: jazzy",
    ]
    return "\n".join(lines) + "\n"


def _yaml_list(key: str, items: Iterable[str]) -> str:
    """A YAML list of blocks under a key."""
    text = "".join(f"\n  - {indent(item, '    ').lstrip()}" for item in items)
    return f"{key}:{text or ' []'}"


def _topics(files: Iterable[Contents]) -> list[str]:
    """The topics of several files, each once, in order of appearance."""
    descriptions: dict[str, str] = {}
    totals = Counter[str]()
    for contents in files:
        for number, channel in contents.channels.items():
            descriptions[channel.topic] = f"""\
topic_metadata:
  name: {json.dumps(channel.topic)}
  type: {json.dumps(contents.schemas[channel.schema_id].name)}
  serialization_format: cdr
  offered_qos_profiles:
{indent(channel.metadata.get("offered_qos_profiles", "[]"), "    ")}
  type_description_hash: {json.dumps(channel.metadata.get("topic_type_hash", ""))}"""
            totals[channel.topic] += contents.counts[number]
    return [
        f"{text}\nmessage_count: {totals[topic]}"
        for topic, text in descriptions.items()
    ]


def _qos_text(latched: bool) -> str:
    """A list with one profile, values as words, as rosbag2's version 9 has it."""
    return f"""\
- history: keep_last
  depth: 100
  reliability: reliable
  durability: {"transient_local" if latched else "volatile"}
  deadline:{_FOREVER}
  lifespan:{_FOREVER}
  liveliness: automatic
  liveliness_lease_duration:{_FOREVER}
  avoid_ros_namespace_conventions: false"""


def message_size(data: memoryview) -> int:
    """Bytes that a message takes in a file."""
    return _WHOLE_HEAD + len(data)


def message_head(channel: int, number: int, log_time: int, data: memoryview) -> bytes:
    """What stands before the data of a message, checksum included."""
    head = RECORD.pack(opcode.Opcode.MESSAGE, MESSAGE.size + len(data)) + MESSAGE.pack(
        channel, number & 0xFFFFFFFF, log_time, log_time
    )
    return CHECK.pack(CHECK_OPCODE, 4, zlib.crc32(data, zlib.crc32(head))) + head


def describe_topics(types: Mapping[str, MessageType], node: str = "") -> Contents:
    """What a file with these topics has before its messages.

    The metadata of each channel name the node.
    """
    contents = Contents()
    numbers: dict[str, int] = {}
    for channel, (topic, kind) in enumerate(types.items(), 1):
        schema = numbers.setdefault(kind.name, len(numbers) + 1)
        contents.schemas[schema] = records.Schema(
            schema, kind.definition.encode(), "ros2msg", kind.name
        )
        contents.channels[channel] = records.Channel(
            channel,
            topic,
            "cdr",
            {
                "offered_qos_profiles": _qos_text(topic in LATCHED),
                "topic_type_hash": kind.type_hash,
                "node": node,
            },
            schema,
        )
    return contents


def opening(contents: Contents) -> bytes:
    """The beginning of a file: a header, schemas and channels."""
    start = MAGIC + _encode([records.Header(PROFILE, LIBRARY)])
    for description in contents.descriptions:
        record = _encode([description])
        start += CHECK.pack(CHECK_OPCODE, 4, zlib.crc32(record)) + record
    return start


def _encode(records_in_order: Iterable[records.McapRecord]) -> bytes:
    """Records one after the other."""
    builder = data_stream.RecordBuilder()
    for record in records_in_order:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


END = _encode([records.DataEnd(0), records.Footer(0, 0, 0)]) + MAGIC
"""What makes a file complete that has no summary yet."""
