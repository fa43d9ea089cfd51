"""Records of an MCAP file out of their bytes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from io import BytesIO
from typing import Final

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    McapRecord,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from ..writer.mcap_layout import MESSAGE

UNREADABLE: Final = (struct.error, McapError, UnicodeDecodeError)
"""What reading a record out of the wrong bytes raises."""

_READERS: Final[dict[int, Callable[[ReadDataStream], McapRecord]]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.STATISTICS: Statistics.read,
    Opcode.METADATA: Metadata.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
}


def decode(opcode: int, body: bytes) -> McapRecord | None:
    """A record from what follows its opcode and length; None for a kind that is not needed.

    Raises
    ------
    One of UNREADABLE
        The bytes are no such record.
    """
    if opcode == Opcode.MESSAGE:
        return message(body)
    reader = _READERS.get(opcode)
    return None if reader is None else reader(ReadDataStream(BytesIO(body)))


def message(body: bytes) -> Message:
    """A message; its data is the only copy made."""
    channel, number, log_time, publish_time = MESSAGE.unpack_from(body)
    return Message(channel, log_time, body[MESSAGE.size:], publish_time, number)
