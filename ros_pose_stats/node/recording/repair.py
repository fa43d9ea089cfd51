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

"""Mending the bags of runs that ended without being able to finish them."""

import os
import re
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path

from mcap import reader

from ...base.errors import reason
from ...base.files import (
    DirectoryLock,
    NotAFileError,
    open_file,
    read_file,
    remove_empty,
    replace_file,
)
from .indexing import Rewrite, put_in_place, write_indexed
from .reader import UNREADABLE
from .runs import (
    METADATA,
    find_bag_files,
    find_halves,
    find_runs,
    is_run,
    remove_halves,
)
from .writer import mcap_layout

_MAGIC_LENGTH = len(mcap_layout.MAGIC)
_FOOTER_LENGTH = 20
_LEAST = 2 * _MAGIC_LENGTH + mcap_layout.RECORD.size + _FOOTER_LENGTH
_CHECK_SIZE = 4 + _MAGIC_LENGTH  # checksum of the summary, and what follows it
_YOUNG = 60.0  # seconds; a run without files is then that of a process that died
_MESSAGE_COUNT = re.compile(r"^  message_count: (\d+)$", re.MULTILINE)


WriteAnew = Callable[[Path], Rewrite]
"""As `write_indexed`; OSError where the file is to stay as it is."""

RoomFor = Callable[[int], AbstractContextManager[object]]
"""While it is entered, so many bytes are free for files; older runs may have gone."""


@dataclass(frozen=True)
class Repair:
    """What was done to one bag."""

    directory: Path  # the bag
    messages: int = 0  # messages in it now; 0 where it could not be mended
    cut_bytes: int = 0  # bytes of half or damaged records that were cut away
    problem: str = ""  # why it could not be mended; empty where it is


def repair_bags(
    log_directory: Path, write_anew: WriteAnew, room_for: RoomFor = nullcontext
) -> Iterator[Repair]:
    """Mend and index all bags of a log directory that no process has in hand.

    One repair for each that was not closed, or has a problem, oldest first, or one for
    a directory that cannot be read; nothing is raised, and what has other names than
    ours is left alone.
    """
    try:
        runs = find_runs(log_directory)
    except OSError as error:
        yield _problem(log_directory, error)
        return
    for run in runs:
        repair = _repair(run, write_anew, room_for)
        if repair is not None:
            yield repair


def index_bag(bag: Path) -> None:
    """Index a node's bag that nobody has in hand, where it can be written."""
    if is_run(bag):
        _repair(bag, write_indexed, nullcontext)


def _repair(run: Path, write_anew: WriteAnew, room_for: RoomFor) -> Repair | None:
    """Mend one bag; None where nothing is to be said, or somebody else has it."""
    try:
        files = find_bag_files(run)
        if not files:
            with suppress(OSError):  # it does no harm, and may be gone already
                is_young = time.time() - run.stat().st_ctime < _YOUNG
                lock = None if is_young else DirectoryLock.take(run)
                if lock is not None:
                    with lock:
                        remove_empty(run)
            return None
        if _is_finished(run) and not find_halves(run):
            return None
        # Of runs that nobody has in hand the oldest go for room, maybe this one.
        with room_for(max(path.stat().st_size for path in files)):
            lock = DirectoryLock.take(run) if run.is_dir() else None
            if lock is None:
                return None
            with lock:
                return _mend(run, write_anew)
    except OSError as error:
        return _problem(run, error)


def _problem(directory: Path, error: OSError) -> Repair:
    return Repair(directory, problem=f"cannot mend {directory}: {reason(error)}")


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
    """What the summary of a file says; None without a sound one that has an index."""
    with open_file(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size < _LEAST:
            return None
        file.seek(size - _FOOTER_LENGTH - _MAGIC_LENGTH)
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
        or (summary.statistics.message_count and not summary.chunk_indexes)
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


def _mend(run: Path, write_anew: WriteAnew) -> Repair | None:
    """Finish and describe the files of a locked run; may be killed and repeated.

    None where they had ended well, and lacked their index alone.
    """
    files: dict[str, mcap_layout.Contents] = {}
    cuts: list[int] = []
    for path in find_bag_files(run):
        contents = _finished_contents(path)
        if contents is None:
            rewrite = write_anew(path)
            put_in_place(path, rewrite)
            contents = rewrite.contents
            cuts += rewrite.cuts
        files[path.name] = contents
    if files:
        replace_file(run / METADATA, mcap_layout.metadata_yaml(files).encode())
    with suppress(OSError):
        remove_halves(run)
    messages = sum(contents.messages for contents in files.values())
    return Repair(run, messages, sum(cuts)) if cuts else None
