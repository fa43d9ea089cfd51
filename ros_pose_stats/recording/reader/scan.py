"""Reading an MCAP file record by record, also one that was never finished or is damaged."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import BinaryIO, Final

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema

from ..writer.mcap_layout import CHECK, CHECK_START, MAGIC, MESSAGE, RECORD

OnDamage = Callable[[int, int], None]
"""Told begin and end of bytes that are no whole record; equal where just the footer is missing."""

UNREADABLE: Final = (struct.error, McapError, UnicodeDecodeError)
"""What reading a record out of the wrong bytes raises."""

_READERS: Final[dict[int, Callable[[ReadDataStream], McapRecord]]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.METADATA: Metadata.read,
}
_BLOCK: Final = 1 << 20
_FIRST_PRIVATE: Final = 0x80


@dataclass(frozen=True)
class Frame:
    """A whole record."""

    opcode: int  # what it is
    start: int  # its place in the file, including the checksum record in front of it, if any
    end: int
    body: bytes  # what follows opcode and length

    @property
    def length(self) -> int:
        """Bytes of the record without the checksum record."""
        return RECORD.size + len(self.body)

    def record(self) -> McapRecord | None:
        """The record itself, of a message the only copy; None for a kind that is not needed.

        Raises One of UNREADABLE: the bytes are no such record.
        """
        if self.opcode == Opcode.MESSAGE:
            channel, number, log_time, publish_time = MESSAGE.unpack_from(self.body)
            return Message(channel, log_time, self.body[MESSAGE.size:], publish_time, number)
        read = _READERS.get(self.opcode)
        return None if read is None else read(ReadDataStream(BytesIO(self.body)))


def frames(file: BinaryIO, on_damage: OnDamage, begin: int = 0) -> Iterator[Frame]:
    """All whole records of a file in order, up to the footer.

    Damage is passed over where a checksum record behind it shows where to go on; otherwise it
    is the end.

    `file`: seekable. It may grow meanwhile; what is there now is read; `on_damage`: told what is
    passed over; `begin`: where to look for the first one; a checksum record shows it.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    position = len(MAGIC) if file.read(len(MAGIC)) == MAGIC else 0
    if begin > position:
        position = _next_checked(file, begin, size)
    while position < size:
        frame = _frame(file, position, size) if position else None
        if frame is None:
            onward = _next_checked(file, position + 1, size)
            on_damage(position, onward)
            position = onward
            continue
        if frame.opcode == Opcode.FOOTER:
            return
        yield frame
        position = frame.end
    on_damage(size, size)


def _frame(file: BinaryIO, start: int, size: int) -> Frame | None:
    """The record at a place; None where there is no whole and sound one."""
    file.seek(start)
    head = file.read(RECORD.size)
    check = None
    if head == CHECK_START:
        stored = file.read(CHECK.size - RECORD.size)
        check = int.from_bytes(stored, "little")
        head = file.read(RECORD.size)
    if len(head) < RECORD.size:
        return None
    opcode, length = RECORD.unpack(head)
    if not _possible(opcode, length) or length > size - file.tell():
        return None
    body = file.read(length)
    if len(body) < length:
        return None
    if check is not None and check != zlib.crc32(body, zlib.crc32(head)):
        return None
    return Frame(opcode, start, file.tell(), body)


def _possible(opcode: int, length: int) -> bool:
    """Whether a record can begin like this; zeros cannot."""
    if opcode == Opcode.MESSAGE:
        return length >= MESSAGE.size
    return Opcode.HEADER <= opcode <= Opcode.DATA_END or opcode >= _FIRST_PRIVATE


def _next_checked(file: BinaryIO, start: int, size: int) -> int:
    """Where the next record with a sound checksum begins; the size where there is none."""
    while start < size:
        file.seek(start)
        block = file.read(_BLOCK)
        found = block.find(CHECK_START)
        if found < 0:
            start += max(1, len(block) - len(CHECK_START) + 1)
        elif _frame(file, start + found, size) is not None:
            return start + found
        else:
            start += found + 1
    return size
