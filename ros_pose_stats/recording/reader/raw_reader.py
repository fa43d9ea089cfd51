"""Messages of a bag as they were recorded, whoever recorded it and however it ended."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final, cast

import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import breakup_chunk

from ...files import open_file
from .scan import UNREADABLE, Frame, frames

_PACKED: Final = ".zstd"
_STEP: Final = 1_000_000


@dataclass(frozen=True)
class RawMessage:
    """A recorded message."""

    topic: str  # such as `/pose_stats/answers` and `ros_pose_stats_msgs/msg/PoseStatistics`
    type_name: str
    data: bytes  # CDR with its header of 4 bytes
    log_time: int  # when it was recorded [ns since 1970]
    definition: str  # definition of the type, as the bag has it


@dataclass(frozen=True)
class Damage:
    """A place where a file is not as it should be."""

    path: Path  # the file
    start: int  # bytes that were passed over; equal where only summary and footer are missing
    end: int
    reason: str  # one clause


def raw_messages(bag: Path, on_damage: Callable[[Damage], None] | None = None,
                 on_read: Callable[[float], None] | None = None) -> Iterator[RawMessage]:
    """All whole messages of a bag, file by file, in the order in which they were recorded.

    `bag`: a bag directory or a single `.mcap` file, chunked or not, finished or not; files that
    `ros2 bag record` has compressed as a whole (`.mcap.zstd`) too; `on_damage`: told of every
    place that had to be passed over; `on_read`: told after every megabyte which fraction of its
    file has been read. Raises OSError: there is no such file, or it cannot be read.
    """
    for path in files_of_bag(bag):
        with _opened(path) as file:
            yield from _messages(path, file, on_damage or (lambda damage: None),
                                 on_read or (lambda share: None))


def messages_after(path: Path, offset: int) -> Iterator[RawMessage]:
    """The whole messages of a file of the node from a place on.

    Raises OSError: there is no such file, or it cannot be read.
    """
    with open_file(path) as file:
        yield from _messages(path, file, lambda damage: None, lambda share: None, offset)


def _messages(path: Path, file: BinaryIO, on_damage: Callable[[Damage], None],
              on_read: Callable[[float], None], offset: int = 0) -> Iterator[RawMessage]:
    """The whole messages of one file, each with its topic and type.

    `offset`: of the node's own files, which describe their topics before the first message, those
    before it are passed over.
    """
    def damaged(start: int, end: int, reason: str = "") -> None:
        reason = reason or ("no whole record" if end > start else "no footer")
        on_damage(Damage(path, start, end, reason))

    schemas: dict[int, Schema] = {}
    channels: dict[int, tuple[str, str, str]] = {}

    def describe(record: McapRecord | None) -> None:
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            schema = schemas.get(record.schema_id)
            channels[record.id] = (
                record.topic, schema.name if schema else "",
                schema.data.decode(errors="replace") if schema else "")

    size = os.fstat(file.fileno()).st_size
    next_told = 0
    for frame in _frames_after(file, damaged, offset):
        if frame.end > next_told:
            on_read(min(1.0, frame.end / size))
            next_told = frame.end + _STEP
        try:
            record = frame.record()
            records = [record] if not isinstance(record, Chunk) else _unpacked(record)
        except UNREADABLE as error:
            damaged(frame.start, frame.end, str(error))
            continue
        for one in records:
            if not isinstance(one, Message):
                describe(one)
            elif one.channel_id in channels:
                topic, type_name, definition = channels[one.channel_id]
                yield RawMessage(topic, type_name, one.data, one.log_time, definition)
            else:
                damaged(frame.start, frame.end, f"no channel {one.channel_id}")


def _frames_after(file: BinaryIO, damaged: Callable[[int, int], None],
                  offset: int) -> Iterator[Frame]:
    """What describes the messages, and then all from a place on."""
    head = 0
    for frame in frames(file, damaged) if offset else ():
        if frame.opcode == Opcode.MESSAGE or frame.start >= offset:
            break
        head = frame.end
        yield frame
    yield from frames(file, damaged, max(head, offset))


def files_of_bag(bag: Path) -> list[Path]:
    """The MCAP files of a bag directory in the order of their numbers; a file is its own bag.

    Raises OSError: there is no such bag.
    """
    if not bag.is_dir():
        return [bag]
    return sorted((path for path in bag.iterdir() if path.name.endswith((".mcap", ".mcap.zstd"))),
                  key=lambda path: [(int(part), "") if part.isdigit() else (0, part)
                                    for part in re.split(r"(\d+)", path.name)])


def _opened(path: Path) -> BinaryIO:
    """A bag's file, seekable; one that was compressed as a whole is unpacked for that."""
    if path.suffix != _PACKED:
        return open_file(path)
    unpacked = cast(BinaryIO, tempfile.TemporaryFile())  # noqa: SIM115  closed by the caller
    try:
        with open_file(path) as file, zstandard.ZstdDecompressor().stream_reader(
                file, read_across_frames=True) as reader:
            shutil.copyfileobj(cast(Any, reader), unpacked)
    except zstandard.ZstdError:
        pass  # what came out before is as good as a file that was cut
    except OSError:
        unpacked.close()
        raise
    unpacked.seek(0)
    return unpacked


def _unpacked(chunk: Chunk) -> list[McapRecord]:
    """The records of a chunk; McapError where it is damaged or compressed in an unknown way."""
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except Exception as error:  # each compression has errors of its own
        raise McapError(f"unreadable chunk: {error}") from error
