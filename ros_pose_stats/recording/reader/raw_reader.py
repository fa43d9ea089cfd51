"""Messages of a bag as they were recorded, whoever recorded it and however it ended."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mcap.records import Channel, Chunk, McapRecord, Message, Schema

from ..directory_lock import is_locked
from ..run_names import runs
from ..writer.mcap_layout import NODE_KEY
from .bag_input import files_of_bag, opened, unpacked_chunk
from .decoding import UNREADABLE, decode
from .scan import frames


@dataclass(frozen=True)
class RawMessage:
    """A recorded message.

    Attributes
    ----------
    topic, type_name : str
        Such as `/pose_stats/answers` and `ros_pose_stats_msgs/msg/PoseStatistics`.
    data : bytes
        CDR with its header of 4 bytes.
    log_time : int
        When it was recorded [ns since 1970].
    definition : str
        Definition of the type, as the bag has it.
    node : str
        Name of the node that recorded it; empty in bags of other tools.
    """

    topic: str
    type_name: str
    data: bytes
    log_time: int
    definition: str
    node: str = ""


@dataclass(frozen=True)
class Damage:
    """A place where a file is not as it should be.

    Attributes
    ----------
    path : Path
        The file.
    start, end : int
        Bytes that were passed over; equal where only summary and footer are missing.
    reason : str
        One clause.
    """

    path: Path
    start: int
    end: int
    reason: str


def raw_messages(bag: Path, on_damage: Callable[[Damage], None] | None = None,
                 ) -> Iterator[RawMessage]:
    """All whole messages of a bag, file by file, in the order in which they were recorded.

    Parameters
    ----------
    bag : Path
        A bag directory or a single `.mcap` file, chunked or not, finished or not; files that
        `ros2 bag record` has compressed as a whole (`.mcap.zstd`) too.
    on_damage : callable, optional
        Told of every place that had to be passed over.

    Raises
    ------
    OSError
        There is no such file, or it cannot be read.
    """
    for path in files_of_bag(bag):
        with opened(path) as file:
            yield from _Messages(path, on_damage or (lambda damage: None)).read(file)


def finished_runs(log_directory: Path) -> list[Path]:
    """Runs that no living process holds, oldest first."""
    return [run for run in runs(log_directory) if not is_locked(run)]


def newest_run(log_directory: Path) -> Path | None:
    """The newest run that no living process holds and that has a message; None without one."""
    for run in reversed(finished_runs(log_directory)):
        try:
            if next(raw_messages(run), None) is not None:
                return run
        except OSError:
            continue
    return None


class _Messages:
    """Puts topics and types to the messages of one file."""

    def __init__(self, path: Path, on_damage: Callable[[Damage], None]) -> None:
        self._path = path
        self._on_damage = on_damage
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, tuple[str, str, str, str]] = {}

    def read(self, file: BinaryIO) -> Iterator[RawMessage]:
        """The whole messages of the file, opened by the caller."""
        for frame in frames(file, self._damaged):
            try:
                record = decode(frame.opcode, frame.body)
                records = [record] if not isinstance(record, Chunk) else unpacked_chunk(record)
            except UNREADABLE as error:
                self._damaged(frame.start, frame.end, str(error))
                continue
            for one in records:
                if isinstance(one, Message) and one.channel_id in self._channels:
                    topic, type_name, definition, node = self._channels[one.channel_id]
                    yield RawMessage(topic, type_name, one.data, one.log_time, definition, node)
                elif isinstance(one, Message):
                    self._damaged(frame.start, frame.end, f"no channel {one.channel_id}")
                else:
                    self._note(one)

    def _note(self, record: McapRecord | None) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            schema = self._schemas.get(record.schema_id)
            definition = schema.data.decode(errors="replace") if schema else ""
            self._channels[record.id] = (record.topic, schema.name if schema else "", definition,
                                         record.metadata.get(NODE_KEY, ""))

    def _damaged(self, start: int, end: int, reason: str = "") -> None:
        reason = reason or ("no whole record" if end > start else "no footer")
        self._on_damage(Damage(self._path, start, end, reason))
