"""What rosbag2 wants to read about a bag beside its files (its metadata version 9)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from textwrap import indent

from .contents import Contents, all_topics
from .topics import Topic

Files = Mapping[str, Contents]
"""Contents of a bag's files by their names, in order."""


def metadata_yaml(files: Files) -> str:
    """Text of `metadata.yaml`."""
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
    files = list(files)
    totals: dict[str, int] = {}
    for contents in files:
        for name, count in contents.counts_of_topics().items():
            totals[name] = totals.get(name, 0) + count
    return [_topic(topic, totals[topic.name]) for topic in all_topics(files)]


def _topic(topic: Topic, messages: int) -> str:
    return f"""\
topic_metadata:
  name: {json.dumps(topic.name)}
  type: {json.dumps(topic.type_name)}
  serialization_format: cdr
  offered_qos_profiles:
{indent(topic.qos, "    ")}
  type_description_hash: {json.dumps(topic.type_hash)}
message_count: {messages}"""


def _file(name: str, contents: Contents) -> str:
    return f"""\
path: {json.dumps(name)}
starting_time:
  nanoseconds_since_epoch: {contents.start}
duration:
  nanoseconds: {contents.end - contents.start}
message_count: {contents.messages}"""
