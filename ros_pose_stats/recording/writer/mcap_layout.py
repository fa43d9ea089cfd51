"""The bytes of a bag's file: its beginning, its messages, and what closes it.

Records stand by themselves, in no chunk, so that each is complete once it is on disk. Every
record but the header is preceded by a record of our own with the checksum of what follows;
MCAP leaves opcodes from 0x80 on to applications, and readers skip those they do not know.
"""

import struct
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    SummaryOffset,
)

from ...version import VERSION
from .contents import Contents, metadata_record
from .message_types import MessageType

MAGIC: Final = b"\x89MCAP0\r\n"
PROFILE: Final = "ros2"
LIBRARY: Final = f"ros_pose_stats {VERSION}"

CHECK_OPCODE: Final = 0xC5
CHECK: Final = struct.Struct("<BQI")
CHECK_START: Final = struct.pack("<BQ", CHECK_OPCODE, 4)
"""How a checksum record begins; looked for behind damage."""

RECORD: Final = struct.Struct("<BQ")
"""Opcode of a record and length of what follows."""

MESSAGE: Final = struct.Struct("<HIQQ")
"""Channel, number within the channel, log time and publish time [ns]; then the data."""

FOOTER_LENGTH: Final = 20

_METADATA_NAME: Final = "rosbag2"
_WHOLE_HEAD: Final = CHECK.size + RECORD.size + MESSAGE.size


def magic_and_header() -> bytes:
    """What every file begins with."""
    return MAGIC + _encoded([Header(PROFILE, LIBRARY)])


def message_size(data: memoryview) -> int:
    """Bytes that a message takes in a file."""
    return _WHOLE_HEAD + len(data)


def message_head(channel: int, number: int, log_time: int, data: memoryview) -> bytes:
    """What stands before the data of a message, checksum included."""
    head = RECORD.pack(Opcode.MESSAGE, MESSAGE.size + len(data)) + MESSAGE.pack(
        channel, number & 0xFFFFFFFF, log_time, log_time)
    return CHECK.pack(CHECK_OPCODE, 4, zlib.crc32(data, zlib.crc32(head))) + head


def opening(name: str, types: Mapping[str, MessageType], now: int,
            node: str = "") -> tuple[bytes, Contents]:
    """The beginning of a file, and its contents so far.

    `now`: time [ns] that stands in for that of a first message; `node`: name of the node that
    records, kept with every topic.
    """
    contents = Contents(start=now, end=now)
    contents.add_topics(types, node)
    start = magic_and_header()
    metadata, index = _metadata(name, contents, len(start))
    contents.metadata.append(index)
    start += metadata + _checked([*contents.schemas.values(), *contents.channels.values()])
    return start, contents


def closing(name: str, contents: Contents, offset: int) -> bytes:
    """What makes a file complete: final metadata, end of data, summary and footer.

    `contents`: of the file; left as it is; `offset`: where in the file this goes.
    """
    metadata, index = _metadata(name, contents, offset)
    contents = replace(contents, metadata=[*contents.metadata, index])
    data_end = metadata + _encoded([DataEnd(0)])
    start = offset + len(data_end)
    groups: list[tuple[Opcode, Iterable[McapRecord]]] = [
        (Opcode.SCHEMA, contents.schemas.values()),
        (Opcode.CHANNEL, contents.channels.values()),
        (Opcode.STATISTICS, [contents.statistics()]),
        (Opcode.METADATA_INDEX, contents.metadata),
    ]
    summary = b""
    offsets: list[McapRecord] = []
    for opcode, records in groups:
        group = _encoded(records)
        if group:
            offsets.append(SummaryOffset(opcode, start + len(summary), len(group)))
        summary += group
    offsets_start = start + len(summary)
    summary += _encoded(offsets)
    footer = _encoded([Footer(start, offsets_start, 0)])[:-4]
    check = zlib.crc32(footer, zlib.crc32(summary))
    return data_end + summary + footer + struct.pack("<I", check) + MAGIC


def _encoded(records: Iterable[McapRecord]) -> bytes:
    """Records one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def _checked(records: Iterable[McapRecord]) -> bytes:
    """Records, each behind its checksum."""
    parts = map(_encoded, ([record] for record in records))
    return b"".join(CHECK.pack(CHECK_OPCODE, 4, zlib.crc32(part)) + part for part in parts)


def _metadata(name: str, contents: Contents, offset: int) -> tuple[bytes, MetadataIndex]:
    """The metadata record of a file, to be written at an offset, and its entry in the index."""
    text = metadata_record({name: contents})
    record = _checked([Metadata(_METADATA_NAME, {"serialized_metadata": text})])
    length = len(record) - CHECK.size
    return record, MetadataIndex(offset + CHECK.size, length, _METADATA_NAME)
