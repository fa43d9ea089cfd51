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

"""Runs in a log directory: their names, their files, and the oldest that make room."""

import os
import re
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime, timedelta, timezone
from pathlib import Path

from ...base.files import HALF, DirectoryLock, remove_empty

METADATA = "metadata.yaml"
RESCAN = 10.0
"""Seconds after which the log directory, which nodes share, is looked at again."""

_TIME = "pose_stats_%Y%m%dT%H%M%S_%f"
_TIMED = len("pose_stats_YYYYmmddTHHMMSS_ffffff")
_RUN = re.compile(r"pose_stats_\d{8}T\d{6}_\d{6}_\d+")


def new_run(log_directory: Path) -> Path:
    """`pose_stats_<YYYYmmddTHHMMSS>_<microseconds>_<pid>`, still to be made, in UTC.

    Names in order are runs in order: at least a microsecond after the newest run.
    """
    start = datetime.now(timezone.utc)
    # Of an unreadable folder, of a name that is no day, or is the last one.
    with suppress(OSError, ValueError, OverflowError):
        newest = max((run.name for run in find_runs(log_directory)), default="")
        if newest >= start.strftime(_TIME):
            start = datetime.strptime(newest[:_TIMED], _TIME).replace(
                tzinfo=timezone.utc
            ) + timedelta(microseconds=1)
    return log_directory / f"{start.strftime(_TIME)}_{os.getpid()}"


def find_runs(log_directory: Path) -> list[Path]:
    """All runs' directories, oldest first; no links, for those lead elsewhere."""
    paths = (log_directory / name for name in _list_names(log_directory))
    return [path for path in paths if is_run(path)]


def is_run(path: Path) -> bool:
    """Whether a path is, by its name, the directory of a node's run, and no link."""
    return (
        _RUN.fullmatch(path.name) is not None
        and path.is_dir()
        and not path.is_symlink()
    )


def bag_file(directory: Path, number: int) -> Path:
    """Path of a run's file; they are numbered from 0."""
    return directory / f"{directory.name}_{number}.mcap"


def find_bag_files(directory: Path) -> list[Path]:
    """A run's own files in the order of their numbers."""
    pattern = re.compile(re.escape(directory.name) + r"_(\d+)\.mcap")
    numbered = [
        (int(match[1]), directory / match[0])
        for match in map(pattern.fullmatch, _list_names(directory))
        if match
    ]
    return [path for _, path in sorted(numbered)]


def find_halves(run: Path) -> list[Path]:
    """What was begun to be written in a run, and has not taken its place."""
    prefixes = (METADATA, f"{run.name}_")
    return [half for prefix in prefixes for half in run.glob(f"{prefix}*{HALF}")]


def remove_halves(run: Path) -> None:
    """Remove what was begun to be written in a run that the caller has locked."""
    for half in find_halves(run):
        half.unlink(missing_ok=True)


def _list_names(folder: Path) -> list[str]:
    try:
        return sorted(entry.name for entry in os.scandir(folder))
    except (FileNotFoundError, NotADirectoryError):
        return []


def delete_run(run: Path) -> bool:
    """Delete a run's own files if nobody has it in hand; whether they are gone."""
    with suppress(OSError):
        lock = DirectoryLock.take(run)
        if lock is None:
            return False
        with lock:
            remove_halves(run)
            for file in (run / METADATA, *find_bag_files(run)):
                file.unlink(missing_ok=True)
            remove_empty(run)
    return not find_bag_files(run)


class SpaceBound:
    """The bound of a log directory in bytes, as one run sees it; 0 for none.

    `is_exceeded`: there is too much, and nothing that may be deleted: runs of living
    nodes stay.
    """

    def __init__(self, log_directory: Path, limit: int) -> None:
        self.deletions = 0  # of runs and files
        self.reserved = 0  # bytes that a file may take while it is written anew
        self.last_deleted = ""
        self.is_exceeded = False
        self._log_directory = log_directory
        self._limit = limit
        self._other_bytes = 0
        self._next_scan = 0.0

    def bytes_left(self, own_bytes: int) -> int | None:
        """Bytes by which the directory may still grow; None without a bound."""
        return (
            max(0, self._limit - self._other_bytes - own_bytes) if self._limit else None
        )

    def enforce(
        self,
        own_run: Path,
        own_bytes: int,
        drop_oldest: Callable[[], tuple[str, int] | None],
    ) -> None:
        """Delete what must go before this run grows so far.

        First the oldest runs, then this run's oldest files.
        """
        if not self._limit:
            return
        time_now = time.monotonic()
        if time_now >= self._next_scan or not (
            self._fits(own_bytes) or self.is_exceeded
        ):
            self._delete_runs(own_run, own_bytes)
            self._next_scan = time_now + RESCAN
        while not self._fits(own_bytes) and (dropped_file := drop_oldest()) is not None:
            self._count(dropped_file[0])
            own_bytes -= dropped_file[1]
        self.is_exceeded = not self._fits(own_bytes)

    def _count(self, name: str) -> None:
        self.deletions += 1
        self.last_deleted = name

    def _fits(self, own_bytes: int) -> bool:
        return self._other_bytes + own_bytes + self.reserved <= self._limit

    def _delete_runs(self, own_run: Path, own_bytes: int) -> None:
        """Look at the directory again, and delete the oldest runs until it fits."""
        sizes = {
            run: _size(run) for run in find_runs(self._log_directory) if run != own_run
        }
        self._other_bytes = sum(sizes.values())
        for run, size in sizes.items():
            if self._fits(own_bytes):
                break
            if size and delete_run(run):
                self._other_bytes -= size
                self._count(run.name)


def _size(run: Path) -> int:
    """Bytes of a run's files; 0 for one that has none, or has just been deleted."""
    size = 0
    with suppress(OSError):
        files = find_bag_files(run)
        for file in (*files, run / METADATA) if files else ():
            with suppress(OSError):
                size += file.stat(follow_symlinks=False).st_size
    return size
