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

"""Closed files of a bag, written anew with chunks and an index by mcap's own writer.

A file that is being written has each message at once, and no index: those who read by
time, as `ros2 bag play` and `info -v`, need one. The messages stay as they are.
"""

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO

from mcap import records

from ...base.errors import BatchError
from ...base.files import HALF, open_file, sync_directory
from ...base.worker import ProcessDiedError, Worker
from .reader import UNREADABLE, Allowance, read_frames, records_in
from .writer.indexed_file import IndexedFile
from .writer.mcap_layout import Contents

SMALL = 4 * 2**20
"""Bytes of a file that is written anew without a process: starting one takes longer."""

LOWEST_PRIORITY = 19
MOST_SECONDS = 3600.0
"""For one file; where simulations take all cores, little is left for this."""

FREE_SHARE = 2
"""The disk must have so many times the file's size free, so that others go on."""


@dataclass(frozen=True)
class Rewrite:
    """What a file has once it is written anew."""

    half: Path  # where it is until it takes the file's place
    contents: Contents
    cuts: list[int]  # bytes of what was no whole record; 0 for an end that was missing


class Indexer:
    """Writes files anew until closed, large ones in a process of low priority."""

    def __init__(self, small: int = SMALL) -> None:
        self._small = small
        self._worker = Worker(partial(os.nice, LOWEST_PRIORITY))

    def write(self, path: Path) -> Rewrite:
        """The same as `write_indexed`; after `close` an OSError."""
        if path.stat().st_size <= self._small:
            return write_indexed(path)
        try:
            outcome = self._worker.call_within(MOST_SECONDS, _try_to_write, path)
        except (ProcessDiedError, BatchError) as error:
            raise OSError(f"the process that indexes bags {error}") from error
        if isinstance(outcome, OSError):
            raise outcome
        return outcome

    def close(self) -> None:
        """Abandon the file that is being written in the process."""
        self._worker.close()


def _try_to_write(path: Path) -> Rewrite | OSError:
    """An error as a value: whoever raises one in the process ends it."""
    try:
        return write_indexed(path)
    except OSError as error:
        return error


def write_indexed(path: Path) -> Rewrite:
    """Write the sound part of a file anew beside it, where `put_in_place` takes it.

    OSError without room, or where nothing says what a message is: then the file is
    better left as it is. Memory holds one chunk, or one message, at a time.
    """
    # Of a name that nobody else has: the process of a node that was killed may still
    # begin to write the same file, while the next start puts it in place.
    half = path.with_name(f"{path.name}.{secrets.token_hex(4)}{HALF}")
    try:
        with open_file(path) as source, half.open("xb") as target:
            size = os.fstat(source.fileno()).st_size
            if shutil.disk_usage(half.parent).free < FREE_SHARE * size:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            rewrite = Rewrite(half, *_copy(source, target, path))
            target.flush()
            os.fsync(target.fileno())
        shutil.copystat(path, half)
    except BaseException:
        with suppress(OSError):
            half.unlink()
        raise
    return rewrite


def put_in_place(path: Path, rewrite: Rewrite) -> int:
    """Have what was written anew take a file's place, durably; return its bytes."""
    rewrite.half.replace(path)
    sync_directory(path.parent)
    return path.stat().st_size


def _copy(source: BinaryIO, target: BinaryIO, path: Path) -> tuple[Contents, list[int]]:
    """Write schemas, channels and messages in their order, and end as rosbag2 does.

    What was written, and the bytes of each stretch that was left out.
    """
    cuts: list[int] = []
    copy = IndexedFile(target)
    for record in _sound_records(source, Allowance(path), cuts):
        if isinstance(record, records.Message):
            copy.append(record)
        # A summary has schemas and channels once more.
        elif isinstance(record, records.Schema | records.Channel):
            copy.describe(record)
    copy.finish(path.name)
    return copy.contents, cuts


def _sound_records(
    source: BinaryIO, allowance: Allowance, cuts: list[int]
) -> Iterator[records.McapRecord | None]:
    """Records in chunks and outside; `cuts` takes the bytes of each unsound stretch."""
    for frame in read_frames(source, lambda start, end: cuts.append(end - start)):
        try:
            yield from records_in(frame, allowance)
        except UNREADABLE:
            cuts.append(frame.end - frame.start)
