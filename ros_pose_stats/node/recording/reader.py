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

"""Bags read back, whoever recorded them and however they ended."""

import os
import re
import struct
import tempfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, cast

import zstandard
from lz4.frame import LZ4FrameDecompressor
from mcap import data_stream, exceptions, opcode, records

from ...base.files import open_file
from .writer.mcap_layout import CHECK, CHECK_START, MAGIC, MESSAGE, RECORD

UNREADABLE = (struct.error, exceptions.McapError, UnicodeDecodeError)
"""What reading a record out of the wrong bytes raises."""

_READERS: dict[int, Callable[[data_stream.ReadDataStream], records.McapRecord]] = {
    opcode.Opcode.SCHEMA: records.Schema.read,
    opcode.Opcode.CHANNEL: records.Channel.read,
    opcode.Opcode.CHUNK: records.Chunk.read,
}
_NO_SCHEMA = records.Schema(0, b"", "", "")
_BLOCK = 1 << 20
_STEP = 1_000_000
_FIRST_PRIVATE = 0x80
_PACKED = ".zstd"

MOST_RECORD = 512 * 2**20
"""Bytes of a record, or of an unpacked chunk, which memory has to hold. Recorders fill
chunks of megabytes, or of one message where that is larger.
"""

# Bytes of what looks like records behind damage that are tried in vain, and for each
# byte of the file. What recorders leave holds a few such; each may claim all the rest.
_LEAST_TRIED = 2**28
_TIMES_TRIED = 4

# What a file may unpack to: so many bytes, and so many more for each of its own. Equal
# results with times of their own pack to a two-hundredth. A record takes time however
# short it is, so it counts as a few kilobytes more.
_FREE = 2**30
_RATIO = 1000
_RECORD_COST = 4096


@dataclass(frozen=True)
class Frame:
    """A whole record."""

    opcode: int
    start: int  # in the file, at the checksum record in front of it, if any
    end: int
    head: bytes  # the checksum record, if any, opcode and length
    body: bytes

    def record(self) -> records.McapRecord | None:
        """The record itself; None for kinds not needed; raises one of UNREADABLE."""
        if self.opcode == opcode.Opcode.MESSAGE:
            channel, number, log_time, publish_time = MESSAGE.unpack_from(self.body)
            return records.Message(
                channel, log_time, self.body[MESSAGE.size :], publish_time, number
            )
        if self.opcode not in _READERS:
            return None
        body = data_stream.ReadDataStream(BytesIO(self.body))
        return _READERS[self.opcode](body)


def read_frames(
    file: BinaryIO, on_damage: Callable[[int, int], None]
) -> Iterator[Frame]:
    """All whole records of a seekable file in order, up to the footer.

    Damage is passed over where a checksum record behind it shows where to go on.
    """
    size = file.seek(0, os.SEEK_END)
    bytes_to_try = _LEAST_TRIED + _TIMES_TRIED * size
    file.seek(0)
    position = len(MAGIC) if file.read(len(MAGIC)) == MAGIC else 0
    while position < size:
        frame = _read_frame(file, position, size) if position else None
        if frame is None:
            next_position, bytes_tried = _find_checked(
                file, position + 1, size, bytes_to_try
            )
            bytes_to_try -= bytes_tried
            on_damage(position, next_position)
            position = next_position
        elif frame.opcode == opcode.Opcode.FOOTER:
            return
        else:
            yield frame
            position = frame.end
    on_damage(size, size)


def _read_frame(file: BinaryIO, start: int, size: int) -> Frame | None:
    """The record at a place; None where there is no whole and sound one."""
    file.seek(start)
    check = b""
    head = file.read(RECORD.size)
    if head == CHECK_START:
        check = head + file.read(CHECK.size - RECORD.size)
        head = file.read(RECORD.size)
    if len(head) < RECORD.size:
        return None
    code, length = RECORD.unpack(head)
    is_private = code >= _FIRST_PRIVATE
    # Zeros are no record.
    if not (opcode.Opcode.HEADER <= code <= opcode.Opcode.DATA_END or is_private):
        return None
    if code == opcode.Opcode.MESSAGE and length < MESSAGE.size:
        return None
    if length > min(size - file.tell(), MOST_RECORD):
        return None
    body = file.read(length)
    total = zlib.crc32(body, zlib.crc32(head))
    if len(body) < length or check not in (
        b"",
        CHECK_START + total.to_bytes(4, "little"),
    ):
        return None
    return Frame(code, start, file.tell(), check + head, body)


def _find_checked(
    file: BinaryIO, start: int, size: int, bytes_to_try: int
) -> tuple[int, int]:
    """Where the next record with a sound checksum begins, and bytes tried in vain.

    The size of the file where there is none, or too many bytes have been tried.
    """
    bytes_tried = 0
    while start < size:
        file.seek(start)
        block = file.read(_BLOCK)
        offset = block.find(CHECK_START)
        while offset >= 0:
            if _read_frame(file, start + offset, size) is not None:
                return start + offset, bytes_tried
            bytes_tried += file.tell() - start - offset
            if bytes_tried > bytes_to_try:
                return size, bytes_tried
            offset = block.find(CHECK_START, offset + 1)
        start += max(1, len(block) - len(CHECK_START) + 1)
    return size, bytes_tried


@dataclass(frozen=True)
class RawMessage:
    """A recorded message."""

    topic: str  # such as `/pose_stats/answers`
    type_name: str  # such as `ros_pose_stats_msgs/msg/PoseStatistics`
    data: bytes  # CDR with its header of 4 bytes
    log_time: int  # when it was recorded [ns since 1970]
    definition: str  # definition of the type, as the bag has it


OnDamage = Callable[[int, int, int, str], None]
"""Called with begin and end of bytes that were passed over, equal where only summary
and footer are missing, the size of the unpacked file, and the reason in one clause.
"""


def read_messages(
    bag: Path,
    on_damage: OnDamage,
    on_read: Callable[[float], None],
) -> Iterator[RawMessage]:
    """All whole messages of a bag, file by file, in the order of their records.

    `bag`: a directory or a single file, chunked, finished, or compressed as a whole, or
    not; `on_read`: called after every megabyte with the fraction of its file that has
    been read.
    """
    for path in files_of_bag(bag):
        allowance = Allowance(path)
        with _open_unpacked(path, allowance) as file:
            yield from _read_file(file, allowance, on_damage, on_read)


class Allowance:
    """What may still be unpacked of a file, by its size on the disk."""

    def __init__(self, path: Path) -> None:
        self.is_packed = path.suffix == _PACKED
        self.bytes = _FREE + _RATIO * path.stat().st_size

    def covers(self, length: int) -> bool:
        """Whether one more record, which is counted in, is not too much."""
        self.bytes -= length + _RECORD_COST
        return self.bytes >= 0


def _read_file(
    file: BinaryIO,
    allowance: Allowance,
    on_damage: OnDamage,
    on_read: Callable[[float], None],
) -> Iterator[RawMessage]:
    """The whole messages of one file, each with its topic and type."""

    def report_damage(start: int, end: int) -> None:
        on_damage(start, end, size, "no whole record" if end > start else "no footer")

    schemas: dict[int, records.Schema] = {}
    channels: dict[int, tuple[str, str, str]] = {}
    size = os.fstat(file.fileno()).st_size
    next_report = 0
    for frame in read_frames(file, report_damage):
        if frame.end > next_report:
            on_read(min(1.0, frame.end / size))
            next_report = frame.end + _STEP
        if allowance.is_packed and not allowance.covers(len(frame.body)):
            report_damage(frame.start, size)
            return
        try:
            for item in records_in(frame, allowance):
                if isinstance(item, records.Schema):
                    schemas[item.id] = item
                elif isinstance(item, records.Channel):
                    schema = schemas.get(item.schema_id, _NO_SCHEMA)
                    definition = schema.data.decode(errors="replace")
                    channels[item.id] = item.topic, schema.name, definition
                elif isinstance(item, records.Message):
                    if item.channel_id not in channels:
                        reason = f"no channel {item.channel_id}"
                        on_damage(frame.start, frame.end, size, reason)
                        continue
                    topic, type_name, definition = channels[item.channel_id]
                    yield RawMessage(
                        topic, type_name, item.data, item.log_time, definition
                    )
        except UNREADABLE as error:
            on_damage(frame.start, frame.end, size, str(error))


def records_in(
    frame: Frame, allowance: Allowance
) -> Iterator[records.McapRecord | None]:
    """The record of a frame, or those of a chunk one by one; raises UNREADABLE."""
    record = frame.record()
    if not isinstance(record, records.Chunk):
        yield record
        return
    content = _unpack_chunk(record, allowance)
    position = 0
    while position < len(content):
        head = content[position : position + RECORD.size].ljust(RECORD.size, b"\0")
        code, length = RECORD.unpack(head)
        start = position + RECORD.size
        # Zeros are no record.
        if code < opcode.Opcode.HEADER or start + length > len(content):
            raise exceptions.McapError(f"no whole record at byte {position} of a chunk")
        position = start + length
        if not allowance.covers(0):
            raise exceptions.McapError("a chunk of more records than its file warrants")
        yield Frame(code, start, position, b"", content[start:position]).record()


def files_of_bag(bag: Path, *endings: str) -> list[Path]:
    """The MCAP files of a bag directory by number, or those of other endings.

    A file is its own bag.
    """
    if not bag.is_dir():
        return [bag]
    suffixes = endings or (".mcap", ".mcap.zstd")
    return sorted(
        (path for path in bag.iterdir() if path.name.endswith(suffixes)),
        key=lambda path: [
            (int(part), "") if part.isdecimal() else (0, part)
            for part in re.split(r"(\d+)", path.name)
        ],
    )


def _open_unpacked(path: Path, allowance: Allowance) -> BinaryIO:
    """A bag's file, seekable; one that was compressed as a whole is unpacked."""
    if path.suffix != _PACKED:
        return open_file(path)
    # The caller closes it.
    unpacked = cast(BinaryIO, tempfile.TemporaryFile())  # noqa: SIM115
    try:
        with (
            open_file(path) as file,
            zstandard.ZstdDecompressor().stream_reader(
                file, read_across_frames=True
            ) as reader,
        ):
            while block := reader.read(_BLOCK):
                unpacked.write(block[: allowance.bytes - unpacked.tell()])
                if unpacked.tell() >= allowance.bytes:
                    break
    except zstandard.ZstdError:
        # What came out before is as good as a file that was cut.
        if not unpacked.tell():
            unpacked.close()
            return open_file(path)
    except OSError:
        unpacked.close()
        raise
    unpacked.seek(0)
    return unpacked


def _unpack_chunk(chunk: records.Chunk, allowance: Allowance) -> bytes:
    """The content of a chunk; McapError where it cannot be unpacked."""
    size = chunk.uncompressed_size
    if size > min(MOST_RECORD, allowance.bytes):
        raise exceptions.McapError(f"a chunk that unpacks to {size} bytes")
    allowance.bytes -= size
    # One byte more shows that there is more than the chunk says.
    try:
        if chunk.compression == "zstd":
            reader = zstandard.ZstdDecompressor().stream_reader(chunk.data)
            content = reader.read(size + 1)
        elif chunk.compression == "lz4":
            content = LZ4FrameDecompressor().decompress(chunk.data, size + 1)
        else:
            content = chunk.data
    except Exception as error:  # each compression has errors of its own
        raise exceptions.McapError(f"unreadable chunk: {error}") from error
    if len(content) != size:
        raise exceptions.McapError("unreadable chunk: its size is another")
    if chunk.uncompressed_crc not in (0, zlib.crc32(content)):
        raise exceptions.McapError("unreadable chunk: its checksum is another")
    return content
