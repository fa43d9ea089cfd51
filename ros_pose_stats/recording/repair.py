"""Mending the bags of runs that ended without being able to finish them."""

import errno
import os
import re
import shutil
import time
import zlib
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Channel, Message, Metadata, MetadataIndex

from .. import files as disk
from .reader import UNREADABLE, Frame, frames
from .runs import METADATA, bag_files, remove_empty, runs
from .writer import mcap_layout as layout

_BLOCK = 1 << 20
_LEAST = 2 * len(layout.MAGIC) + layout.RECORD.size + layout.FOOTER_LENGTH
_CHECK_SIZE = 4 + len(layout.MAGIC)
"""Of the checksum of the summary, and what follows it."""

_YOUNG = 60.0
"""Seconds for which a run without files is left to whoever is about to make the first."""

_MESSAGE_COUNT = re.compile(r"^  message_count: (\d+)$", re.MULTILINE)


@dataclass(frozen=True)
class Repair:
    """What was done to one bag."""

    directory: Path  # the bag
    kept: int = 0  # messages in it now; 0 where it could not be mended
    cut_bytes: int = 0  # bytes of half or damaged records that were cut away
    problem: str = ""  # why it could not be mended; empty where it is


def repair_bags(log_directory: Path) -> list[Repair]:
    """Mend all unfinished bags of a log directory that no process has in hand.

    A missing log directory holds none. Directories and files with other names than ours are
    left alone.

    Returns one for each bag that was not finished, oldest first; nothing is raised. One for the
    log directory itself, if it cannot be read.
    """
    try:
        tried = map(_repair, runs(log_directory))
        return [repair for repair in tried if repair is not None]
    except OSError as error:
        return [_problem(log_directory, error)]


def _repair(run: Path) -> Repair | None:
    """Mend one bag; None where there is nothing to do, or somebody else has it."""
    try:
        if not bag_files(run):
            _remove_if_left(run)
            return None
        lock = None if _is_finished(run) else disk.DirectoryLock.take(run)
        if lock is None:
            return None
        with lock:
            return None if _is_finished(run) else mend(run)
    except OSError as error:
        return _problem(run, error)


def _remove_if_left(run: Path) -> None:
    """Delete the directory of a process that died before it had made a file."""
    with suppress(OSError):  # it does no harm, and may be gone already
        young = time.time() - run.stat().st_ctime < _YOUNG
        lock = None if young else disk.DirectoryLock.take(run)
        if lock is not None:
            with lock:
                remove_empty(run)


def _problem(directory: Path, error: OSError) -> Repair:
    return Repair(directory, problem=f"cannot mend {directory}: {error.strerror or error}")


def _is_finished(run: Path) -> bool:
    """Whether all files are finished, and `metadata.yaml` names them and counts their messages."""
    messages, files = 0, bag_files(run)
    for path in files:
        contents = _finished_contents(path)
        if contents is None:
            return False
        messages += contents.messages
    try:
        text = disk.read_file(run / METADATA).decode("utf-8")
    except (FileNotFoundError, disk.NotAFileError, UnicodeDecodeError):
        return False
    count = _MESSAGE_COUNT.search(text)
    return count is not None and int(count[1]) == messages and all(
        path.name in text for path in files)


def _finished_contents(path: Path) -> layout.Contents | None:
    """What the summary of a file says; None where the file does not end with a sound one.

    Raises OSError: the file cannot be read.
    """
    with disk.open_file(path) as file:
        if os.fstat(file.fileno()).st_size < _LEAST:
            return None
        try:
            summary = SeekingReader(file).get_summary()
        except UNREADABLE:
            return None
        file.seek(-layout.FOOTER_LENGTH - len(layout.MAGIC), os.SEEK_END)
        file.seek(int.from_bytes(file.read(8), "little"))
        end = file.read()
    check = int.from_bytes(end[-_CHECK_SIZE:-len(layout.MAGIC)], "little")
    if check not in (0, zlib.crc32(end[:-_CHECK_SIZE])):
        return None
    if summary is None or summary.statistics is None or any(
            channel.schema_id not in summary.schemas for channel in summary.channels.values()):
        return None
    told = summary.statistics
    return layout.Contents(summary.schemas, summary.channels, told.channel_message_counts,
                    told.message_start_time, told.message_end_time, summary.metadata_indexes)


def mend(directory: Path) -> Repair:
    """Finish all files of a run and describe them anew. The caller has its lock.

    Every step leaves either the old file or the new one, so that this may be killed and
    repeated.

    Raises OSError: it cannot be done now; nothing is lost.
    """
    files: dict[str, layout.Contents] = {}
    cut_bytes = 0
    for path in bag_files(directory):
        contents = _finished_contents(path)
        if contents is None:
            contents, cut = _mend_file(path)
            cut_bytes += cut
        files[path.name] = contents
    if files:
        disk.replace_file(directory / METADATA, layout.metadata_yaml(files).encode())
    for name in (*files, METADATA):
        with suppress(OSError):
            (directory / (name + disk.HALF)).unlink()
    return Repair(directory, sum(contents.messages for contents in files.values()), cut_bytes)


def _mend_file(path: Path) -> tuple[layout.Contents, int]:
    """Write the sound part of a file, closed, in its place; return it and the bytes cut."""
    half = path.with_name(path.name + disk.HALF)
    try:
        half.unlink(missing_ok=True)  # it may be a pipe
        with disk.open_file(path) as old, half.open("wb") as new:
            sound = _SoundPart(os.fstat(old.fileno()).st_mtime_ns)
            for frame in frames(old, sound.on_damage):
                if frame.opcode == Opcode.DATA_END:
                    break
                sound.keep(frame)
            new.write(sound.start)
            for begin, end in sound.ranges:
                _copy(old, new, begin, end)
            new.write(layout.closing(path.name, sound.contents, sound.size))
            new.flush()
            os.fsync(new.fileno())
        shutil.copymode(path, half)
        half.replace(path)
        disk.sync_directory(path.parent)
    except OSError:
        with suppress(OSError):
            half.unlink()
        raise
    return sound.contents, sound.cut_bytes


def _copy(old: BinaryIO, new: BinaryIO, begin: int, end: int) -> None:
    old.seek(begin)
    while begin < end:
        block = old.read(min(_BLOCK, end - begin))
        if not block:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        begin += new.write(block)


class _SoundPart:
    """The records of a damaged file that are worth keeping, gathered by and by.

    `time`: of the file [ns], where it has no message. Attributes `start`: what the mended file
    begins with; its header is written anew, since it is the one record without a checksum;
    `ranges`: begin and end of the stretches to be copied behind it; `size`: bytes of the start and
    all stretches; `contents`: of the mended file; `cut_bytes`: bytes between and behind the
    stretches.
    """

    def __init__(self, time: int) -> None:
        self.start = layout.magic_and_header()
        self.ranges: list[tuple[int, int]] = []
        self.size = len(self.start)
        self.contents = layout.Contents(start=time, end=time)
        self.cut_bytes = 0

    def on_damage(self, begin: int, end: int) -> None:
        """Count what is no whole record."""
        self.cut_bytes += end - begin

    def keep(self, frame: Frame) -> None:
        """Take in a record.

        Raises OSError: it is a message whose channel or type got lost. Leaving it out would be
        worse than leaving the file as it is.
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
        """Note what a record adds to the contents; one of UNREADABLE if it is better left out."""
        record = frame.record()
        if isinstance(record, Metadata):
            place = self.size + (frame.end - frame.start) - frame.length
            self.contents.metadata.append(MetadataIndex(place, frame.length, record.name))
        elif isinstance(record, Message):
            if record.channel_id not in self.contents.channels:
                raise OSError("the description of a topic in it is damaged")
            self.contents.count(record.channel_id, record.log_time)
        elif isinstance(record, Channel) and record.schema_id not in self.contents.schemas:
            raise McapError(f"no schema {record.schema_id}")
        else:
            self.contents.describe(record)
