"""Whether files and bags are whole, told from their ends without reading them through."""

from __future__ import annotations

import os
import re
import struct
import zlib
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import MetadataIndex, Statistics
from mcap.stream_reader import StreamReader

from ..files import NotAFileError, open_file, read_file
from .reader.scan import UNREADABLE
from .run_names import METADATA, bag_files
from .writer.contents import Contents, Files
from .writer.mcap_layout import FOOTER_LENGTH, MAGIC

_FOOTER = struct.Struct("<BQQQI")
_MESSAGE_COUNT = re.compile(r"^  message_count: (\d+)$", re.MULTILINE)


def finished_contents(path: Path) -> Contents | None:
    """What the summary of a file says; None where the file does not end with a sound one.

    Raises OSError: the file cannot be read.
    """
    with open_file(path) as file:
        summary = _summary(file)
    if summary is None:
        return None
    contents = Contents()
    found_statistics = False
    try:
        for record in StreamReader(BytesIO(summary), skip_magic=True).records:
            if isinstance(record, MetadataIndex):
                contents.metadata.append(record)
            elif isinstance(record, Statistics):
                found_statistics = True
                contents.counts = record.channel_message_counts
                contents.start, contents.end = record.message_start_time, record.message_end_time
            else:
                contents.describe(record)
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
        text = read_file(directory / METADATA).decode("utf-8")
    except (FileNotFoundError, NotAFileError, UnicodeDecodeError):
        return False
    count = _MESSAGE_COUNT.search(text)
    messages = sum(contents.messages for contents in files.values())
    return count is not None and int(count[1]) == messages and all(
        name in text for name in files)


def is_finished(directory: Path) -> bool:
    """Whether nothing is left to be done to a run.

    Raises OSError: it cannot be read.
    """
    files = finished_files(directory)
    return files is not None and is_described(directory, files)


def _summary(file: BinaryIO) -> bytes | None:
    """The bytes from a file's summary to its end, if the checksum holds."""
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
    return summary + tail
