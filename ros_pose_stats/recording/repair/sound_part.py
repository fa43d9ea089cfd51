"""What of a damaged file is kept, and what the file made of it holds."""

from __future__ import annotations

from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Header, Message, Metadata, MetadataIndex, Schema

from ..reader.decoding import UNREADABLE, decode
from ..reader.scan import Frame
from ..writer.contents import Contents
from ..writer.mcap_layout import LIBRARY, MAGIC, PROFILE, encoded


class SoundPart:
    """The records worth keeping, gathered one by one.

    Parameters
    ----------
    time : int
        Of the file [ns], where it has no message.

    Attributes
    ----------
    start : bytes
        What the mended file begins with: magic and header. The header is written anew, since
        it is the one record without a checksum.
    ranges : list of (int, int)
        Begin and end of the stretches to be copied behind it.
    size : int
        Bytes of the start and all stretches.
    contents : Contents
        Of the mended file.
    cut_bytes : int
        Bytes between and behind the stretches.
    """

    def __init__(self, time: int) -> None:
        self.start = MAGIC + encoded([Header(PROFILE, LIBRARY)])
        self.ranges: list[tuple[int, int]] = []
        self.size = len(self.start)
        self.contents = Contents(start=time, end=time)
        self.cut_bytes = 0

    def on_damage(self, begin: int, end: int) -> None:
        """Count what is no whole record."""
        self.cut_bytes += end - begin

    def keep(self, frame: Frame) -> None:
        """Take in a record.

        Raises
        ------
        OSError
            It is a message whose channel or type got lost. Leaving it out would be worse than
            leaving the file as it is.
        """
        if frame.opcode == Opcode.HEADER:
            return
        try:
            self._enter(frame)
        except UNREADABLE:
            self.on_damage(frame.start, frame.end)
            return
        if self.ranges and self.ranges[-1][1] == frame.start:
            self.ranges[-1] = (self.ranges[-1][0], frame.end)
        else:
            self.ranges.append((frame.start, frame.end))
        self.size += frame.end - frame.start

    def _enter(self, frame: Frame) -> None:
        """Note what a record adds to the contents.

        Raises
        ------
        One of UNREADABLE
            The file is better off without it.
        OSError
            As above.
        """
        record = decode(frame.opcode, frame.body)
        if isinstance(record, Schema):
            self.contents.schemas[record.id] = record
        elif isinstance(record, Channel):
            if record.schema_id not in self.contents.schemas:
                raise McapError(f"no schema {record.schema_id}")
            self.contents.channels[record.id] = record
        elif isinstance(record, Metadata):
            place = self.size + (frame.end - frame.start) - frame.length
            self.contents.metadata.append(MetadataIndex(place, frame.length, record.name))
        elif isinstance(record, Message):
            if record.channel_id not in self.contents.channels:
                raise OSError("the description of a topic in it is damaged")
            self.contents.count(record.channel_id, record.log_time)
