"""Whether files and bags are whole, told from their ends without reading them through."""

from __future__ import annotations

import os
import re
import struct
import zlib
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, MetadataIndex, Schema, Statistics

from .reader.decoding import UNREADABLE, decode
from .run_names import METADATA, bag_files
from .writer.bag_metadata import Files
from .writer.contents import Contents
from .writer.mcap_layout import FOOTER_LENGTH, MAGIC, RECORD

_FOOTER = struct.Struct("<BQQQI")
_MESSAGE_COUNT = re.compile(r"^  message_count: (\d+)$", re.MULTILINE)


def finished_contents(path: Path) -> Contents | None:
    """What the summary of a file says; None where the file does not end with a sound one.

    Raises
    ------
    OSError
        The file cannot be read.
    """
    with path.open("rb") as file:
        summary = _summary(file)
    if summary is None:
        return None
    contents = Contents()
    found_statistics = False
    try:
        for record in _records(summary):
            found_statistics |= _take_in(record, contents)
    except UNREADABLE:
        return None
    known = all(channel.schema_id in contents.schemas for channel in contents.channels.values())
    return contents if found_statistics and known else None


def finished_files(directory: Path) -> Files | None:
    """Contents of all files of a run; None where one is not finished, or where there is none."""
    files: dict[str, Contents] = {}
    for path in bag_files(directory):
        contents = finished_contents(path)
        if contents is None:
            return None
        files[path.name] = contents
    return files or None


def is_described(directory: Path, files: Files) -> bool:
    """Whether a run has a `metadata.yaml` that names these files and counts their messages."""
    try:
        text = (directory / METADATA).read_text(encoding="utf-8")
    except (FileNotFoundError, UnicodeDecodeError):
        return False
    count = _MESSAGE_COUNT.search(text)
    messages = sum(contents.messages for contents in files.values())
    return count is not None and int(count[1]) == messages and all(
        name in text for name in files)


def is_finished(directory: Path) -> bool:
    """Whether nothing is left to be done to a run.

    Raises
    ------
    OSError
        It cannot be read.
    """
    files = finished_files(directory)
    return files is not None and is_described(directory, files)


def _summary(file: BinaryIO) -> bytes | None:
    """The bytes of a file's summary, if its checksum holds."""
    size = file.seek(0, os.SEEK_END)
    end = size - len(MAGIC) - _FOOTER.size
    if end < len(MAGIC):
        return None
    file.seek(end)
    tail = file.read()
    opcode, length, start, _, check = _FOOTER.unpack(tail[:_FOOTER.size])
    if tail[_FOOTER.size:] != MAGIC or (opcode, length) != (Opcode.FOOTER, FOOTER_LENGTH):
        return None
    if not len(MAGIC) <= start <= end:
        return None
    file.seek(start)
    summary = file.read(end - start)
    if check not in (0, zlib.crc32(tail[:_FOOTER.size - 4], zlib.crc32(summary))):
        return None
    return summary


def _records(summary: bytes) -> list[McapRecord]:
    records = []
    position = 0
    while position < len(summary):
        opcode, length = RECORD.unpack_from(summary, position)
        position += RECORD.size
        record = decode(opcode, summary[position:position + length])
        if record is not None:
            records.append(record)
        position += length
    return records


def _take_in(record: McapRecord, contents: Contents) -> bool:
    """Enter a record of the summary; return whether it was the statistics."""
    if isinstance(record, Schema):
        contents.schemas[record.id] = record
    elif isinstance(record, Channel):
        contents.channels[record.id] = record
    elif isinstance(record, MetadataIndex):
        contents.metadata.append(record)
    elif isinstance(record, Statistics):
        contents.counts = record.channel_message_counts
        contents.start, contents.end = record.message_start_time, record.message_end_time
        return True
    return False
