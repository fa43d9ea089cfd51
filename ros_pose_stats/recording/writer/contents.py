"""What the files of a bag hold, and what rosbag2 wants to read about them in `metadata.yaml`."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from textwrap import indent
from typing import Final

from mcap.records import Channel, McapRecord, MetadataIndex, Schema, Statistics

from .message_types import MessageType

LATCHED: Final = frozenset(("/pose_stats/part_mesh", "/pose_stats/pose_statistics"))
"""Topics whose late subscribers get the last messages, in the cell and when a bag is played."""

DEPTH: Final = 100

NODE_KEY: Final = "node"
"""In the metadata of a channel: the name of the node that recorded."""

_FOREVER = "\n    sec: 9223372036\n    nsec: 854775807"


@dataclass
class Contents:
    """Schemas, channels and counts of one file: kept while writing, filled while scanning."""

    schemas: dict[int, Schema] = field(default_factory=dict)  # by their ids
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)  # messages a channel id
    # log time of the first and the last message [ns]; without messages both the time of the file's
    # making, where it is known
    start: int = 0
    end: int = 0
    metadata: list[MetadataIndex] = field(default_factory=list)  # where the metadata records are

    @property
    def messages(self) -> int:
        """How many messages there are."""
        return sum(self.counts.values())

    def add_topics(self, types: Mapping[str, MessageType], node: str) -> None:
        """Number the topics of a run, in the order given, and their types."""
        numbers: dict[str, int] = {}
        for topic, kind in types.items():
            schema = numbers.setdefault(kind.name, len(numbers) + 1)
            self.schemas[schema] = Schema(schema, kind.definition.encode(), "ros2msg", kind.name)
            channel = len(self.channels) + 1
            self.channels[channel] = Channel(
                channel, topic, "cdr",
                {"offered_qos_profiles": _qos(topic in LATCHED),
                 "topic_type_hash": kind.type_hash, NODE_KEY: node}, schema)

    def describe(self, record: McapRecord | None) -> None:
        """Take in a record if it describes a type or a topic."""
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record

    def count(self, channel: int, log_time: int) -> None:
        """Take in one message."""
        self.start = min(self.start, log_time) if self.counts else log_time
        self.end = max(self.end, log_time) if self.counts else log_time
        self.counts[channel] = self.counts.get(channel, 0) + 1

    def statistics(self) -> Statistics:
        """The record that sums it up."""
        return Statistics(
            attachment_count=0, channel_count=len(self.channels),
            channel_message_counts=self.counts, chunk_count=0, message_count=self.messages,
            message_end_time=self.end, message_start_time=self.start,
            metadata_count=len(self.metadata), schema_count=len(self.schemas))


Files = Mapping[str, Contents]
"""Contents of a bag's files by their names, in order."""


def metadata_yaml(files: Files) -> str:
    """Text of `metadata.yaml` (rosbag2's version 9)."""
    return "rosbag2_bagfile_information:\n" + indent(metadata_record(files), "  ")


def metadata_record(files: Files) -> str:
    """The same without the outermost key, as it also stands in every file of the bag."""
    held = [contents for contents in files.values() if contents.messages] or list(files.values())
    start = min(contents.start for contents in held)
    lines = [
        "version: 9",
        "storage_identifier: mcap",
        f"duration:\n  nanoseconds: {max(contents.end for contents in held) - start}",
        f"starting_time:\n  nanoseconds_since_epoch: {start}",
        f"message_count: {sum(contents.messages for contents in held)}",
        _list("topics_with_message_count", _topics(files.values())),
        'compression_format: ""',
        'compression_mode: ""',
        _list("relative_file_paths", map(json.dumps, files)),
        _list("files", (_file(name, contents) for name, contents in files.items())),
        "custom_data: ~",
        "ros_distro: jazzy",
    ]
    return "\n".join(lines) + "\n"


def _list(key: str, items: Iterable[str]) -> str:
    """A YAML list of blocks under a key."""
    text = "".join(f"\n  - {indent(item, '    ').lstrip()}" for item in items)
    return f"{key}:{text or ' []'}"


def _topics(files: Iterable[Contents]) -> list[str]:
    """The topics of several files, each once, in order of appearance."""
    described: dict[str, str] = {}
    totals: dict[str, int] = {}
    for contents in files:
        for number, channel in contents.channels.items():
            described[channel.topic] = _topic(channel, contents.schemas[channel.schema_id].name)
            totals[channel.topic] = totals.get(channel.topic, 0) + contents.counts.get(number, 0)
    return [f"{text}\nmessage_count: {totals[topic]}" for topic, text in described.items()]


def _topic(channel: Channel, type_name: str) -> str:
    return f"""\
topic_metadata:
  name: {json.dumps(channel.topic)}
  type: {json.dumps(type_name)}
  serialization_format: cdr
  offered_qos_profiles:
{indent(channel.metadata.get("offered_qos_profiles", "[]"), "    ")}
  type_description_hash: {json.dumps(channel.metadata.get("topic_type_hash", ""))}"""


def _file(name: str, contents: Contents) -> str:
    return f"""\
path: {json.dumps(name)}
starting_time:
  nanoseconds_since_epoch: {contents.start}
duration:
  nanoseconds: {contents.end - contents.start}
message_count: {contents.messages}"""


def _qos(latched: bool) -> str:
    """A list with one profile, values as words, as rosbag2 writes it since version 9."""
    return f"""\
- history: keep_last
  depth: {DEPTH}
  reliability: reliable
  durability: {"transient_local" if latched else "volatile"}
  deadline:{_FOREVER}
  lifespan:{_FOREVER}
  liveliness: automatic
  liveliness_lease_duration:{_FOREVER}
  avoid_ros_namespace_conventions: false"""
