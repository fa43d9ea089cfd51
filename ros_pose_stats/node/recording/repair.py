"""Mending the bags of runs that ended without being able to finish them."""

import os
import re
import shutil
import time
import zlib
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from mcap import exceptions, opcode, reader, records

from ...base.files import (
    HALF,
    DirectoryLock,
    NotAFileError,
    open_file,
    read_file,
    remove_empty,
    replace_file,
    sync_directory,
)
from .reader import UNREADABLE, Frame, read_frames
from .runs import METADATA, find_bag_files, find_runs
from .writer import mcap_layout

_MAGIC_LENGTH = len(mcap_layout.MAGIC)
_LEAST = 2 * _MAGIC_LENGTH + mcap_layout.RECORD.size + mcap_layout.FOOTER_LENGTH
_CHECK_SIZE = 4 + _MAGIC_LENGTH  # checksum of the summary, and what follows it
_YOUNG = 60.0  # seconds; a run without files is then that of a process that died
_MESSAGE_COUNT = re.compile(r"^  message_count: (\d+)$", re.MULTILINE)


@dataclass(frozen=True)
class Repair:
    """What was done to one bag."""

    directory: Path  # the bag
    messages: int = 0  # messages in it now; 0 where it could not be mended
    cut_bytes: int = 0  # bytes of half or damaged records that were cut away
    problem: str = ""  # why it could not be mended; empty where it is


def repair_bags(log_directory: Path) -> list[Repair]:
    """Mend all unfinished bags of a log directory that no process has in hand.

    One repair for each, oldest first, or one for a directory that cannot be read;
    nothing is raised, and what has other names than ours is left alone.
    """
    try:
        tried = map(_repair, find_runs(log_directory))
        return [repair for repair in tried if repair is not None]
    except OSError as error:
        return [_problem(log_directory, error)]


def _repair(run: Path) -> Repair | None:
    """Mend one bag; None where there is nothing to do, or somebody else has it."""
    try:
        if not find_bag_files(run):
            with suppress(OSError):  # it does no harm, and may be gone already
                is_young = time.time() - run.stat().st_ctime < _YOUNG
                lock = None if is_young else DirectoryLock.take(run)
                if lock is not None:
                    with lock:
                        remove_empty(run)
            return None
        lock = None if _is_finished(run) else DirectoryLock.take(run)
        if lock is None:
            return None
        with lock:
            return None if _is_finished(run) else mend(run)
    except OSError as error:
        return _problem(run, error)


def _problem(directory: Path, error: OSError) -> Repair:
    return Repair(
        directory, problem=f"cannot mend {directory}: {error.strerror or error}"
    )


def _is_finished(run: Path) -> bool:
    """Whether all files are finished, and `metadata.yaml` has them and their counts."""
    messages = 0
    files = find_bag_files(run)
    for path in files:
        contents = _finished_contents(path)
        if contents is None:
            return False
        messages += contents.messages
    try:
        text = read_file(run / METADATA).decode("utf-8")
    except (FileNotFoundError, NotAFileError, UnicodeDecodeError):
        return False
    count = _MESSAGE_COUNT.search(text)
    return (
        count is not None
        and int(count[1]) == messages
        and all(path.name in text for path in files)
    )


def _finished_contents(path: Path) -> mcap_layout.Contents | None:
    """What the summary of a file says; None if it does not end with a sound one."""
    with open_file(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size < _LEAST:
            return None
        file.seek(size - mcap_layout.FOOTER_LENGTH - _MAGIC_LENGTH)
        summary_start = int.from_bytes(file.read(8), "little")
        if not 0 < summary_start < size:
            return None
        file.seek(0)
        try:
            summary = reader.SeekingReader(file).get_summary()
        except UNREADABLE:
            return None
        file.seek(summary_start)
        end = file.read()
    check = int.from_bytes(end[-_CHECK_SIZE:-_MAGIC_LENGTH], "little")
    if check not in (0, zlib.crc32(end[:-_CHECK_SIZE])):
        return None
    if (
        summary is None
        or summary.statistics is None
        or any(
            channel.schema_id not in summary.schemas
            for channel in summary.channels.values()
        )
    ):
        return None
    statistics = summary.statistics
    return mcap_layout.Contents(
        summary.schemas,
        summary.channels,
        Counter(statistics.channel_message_counts),
        statistics.message_start_time,
        statistics.message_end_time,
    )


def mend(directory: Path) -> Repair:
    """Finish and describe the files of a locked run; may be killed and repeated."""
    files: dict[str, mcap_layout.Contents] = {}
    cut_bytes = 0
    for path in find_bag_files(directory):
        contents = _finished_contents(path)
        if contents is None:
            contents, cut = _mend_file(path)
            cut_bytes += cut
        files[path.name] = contents
    if files:
        replace_file(directory / METADATA, mcap_layout.metadata_yaml(files).encode())
    for name in (*files, METADATA):
        with suppress(OSError):
            (directory / (name + HALF)).unlink()
    return Repair(
        directory, sum(contents.messages for contents in files.values()), cut_bytes
    )


def _mend_file(path: Path) -> tuple[mcap_layout.Contents, int]:
    """Replace a file by its sound part, under a header of today, closed; bytes cut."""
    half = path.with_name(path.name + HALF)
    cut_bytes: list[int] = []
    try:
        half.unlink(missing_ok=True)  # it may be a pipe
        with open_file(path) as source, half.open("wb") as target:
            creation_time = os.fstat(source.fileno()).st_mtime_ns
            contents = mcap_layout.Contents(start=creation_time, end=creation_time)
            target.write(mcap_layout.magic_and_header())
            for frame in read_frames(
                source, lambda begin, end: cut_bytes.append(end - begin)
            ):
                if frame.opcode == opcode.Opcode.DATA_END:
                    break
                if frame.opcode in (opcode.Opcode.HEADER, opcode.Opcode.METADATA):
                    continue  # the second from a bag of an older version
                try:
                    _enter_record(frame, contents)
                except UNREADABLE:
                    cut_bytes.append(frame.end - frame.start)
                else:
                    target.write(frame.head)
                    target.write(frame.body)
            target.write(mcap_layout.closing(contents, target.tell()))
            target.flush()
            os.fsync(target.fileno())
        shutil.copymode(path, half)
        half.replace(path)
        sync_directory(path.parent)
    except OSError:
        with suppress(OSError):
            half.unlink()
        raise
    return contents, sum(cut_bytes)


def _enter_record(frame: Frame, contents: mcap_layout.Contents) -> None:
    """Note what a record adds to the contents; raises one of UNREADABLE to skip it.

    OSError: without the channel or type of a message the file is better left as it is.
    """
    record = frame.record()
    if isinstance(record, records.Message):
        if record.channel_id not in contents.channels:
            raise OSError("the description of a topic in it is damaged")
        contents.count(record.channel_id, record.log_time)
    elif isinstance(record, records.Schema):
        contents.schemas[record.id] = record
    elif isinstance(record, records.Channel):
        if record.schema_id not in contents.schemas:
            raise exceptions.McapError(f"no schema {record.schema_id}")
        contents.channels[record.id] = record
