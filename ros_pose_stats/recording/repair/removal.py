"""Keeping a log directory below its bound, and clearing away what is left of runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from ...files import LOCK, DirectoryLock
from ..finished import is_finished
from ..run_names import being_removed, foreign_names, passing_directories, runs

_YOUNG: Final = 60.0
"""Seconds for which a directory without its name is left to whoever is busy with it."""

RESCAN: Final = 10.0
"""Seconds after which the log directory is looked at again, for what other nodes have done."""


class SpaceBound:
    """The bound of a log directory, as one run sees it.

    `limit`: bytes of all runs together; 0 for no bound. Attributes `deleted`: how many runs and
    files were deleted, and `last_deleted` the last one's name; `exceeded`: whether there was too
    much at the last look, and nothing that may be deleted: the file that this run is writing, runs
    of living nodes, unfinished runs, and runs with files of somebody else in them.
    """

    def __init__(self, log_directory: Path, limit: int) -> None:
        self.deleted, self.last_deleted = 0, ""
        self.exceeded = False
        self._log_directory = log_directory
        self._limit = limit
        self._others = 0
        self._next_scan = 0.0

    def left(self, own_bytes: int) -> int | None:
        """Bytes by which the directory may still grow; None without a bound."""
        return max(0, self._limit - self._others - own_bytes) if self._limit else None

    def enforce(self, own: Path, own_bytes: int,
                drop_oldest: Callable[[], tuple[str, int] | None]) -> None:
        """Delete what must go before this run grows to so many bytes: oldest runs, then files.

        `own`: this run; never deleted as a whole; `drop_oldest`: deletes the oldest of its closed
        files, and returns its name and bytes; None where there is none.
        """
        if not self._limit:
            return
        now = time.monotonic()
        if now >= self._next_scan or not (self._fits(own_bytes) or self.exceeded):
            self._delete_runs(own, own_bytes)
            self._next_scan = now + RESCAN
        while not self._fits(own_bytes) and (dropped := drop_oldest()) is not None:
            self._count(dropped[0])
            own_bytes -= dropped[1]
        self.exceeded = not self._fits(own_bytes)

    def _count(self, name: str) -> None:
        self.deleted, self.last_deleted = self.deleted + 1, name

    def _fits(self, own_bytes: int) -> bool:
        return self._others + own_bytes <= self._limit

    def _delete_runs(self, own: Path, own_bytes: int) -> None:
        """Look at the directory again, and delete the oldest runs until it fits."""
        sizes = {run: _size(run) for run in runs(self._log_directory) if run != own}
        self._others = sum(sizes.values())
        for run, size in sizes.items():
            if self._fits(own_bytes):
                break
            if delete_run(run):
                self._others -= size
                self._count(run.name)


def _size(run: Path) -> int:
    """Bytes of the files of a run; 0 for one that has just been deleted."""
    size = 0
    with suppress(OSError), os.scandir(run) as entries:
        for entry in entries:
            with suppress(OSError):
                size += entry.stat(follow_symlinks=False).st_size
    return size


def delete_run(run: Path) -> bool:
    """Delete a finished run that nobody has in hand; return whether it is gone.

    It loses its name first, so that nobody meets half of a run. A run that holds files of
    somebody else stays.
    """
    with suppress(OSError):
        if foreign_names(run, run.name) or not is_finished(run):
            return False
        lock = DirectoryLock.take(run)
        if lock is None:
            return False
        with lock:
            removed = being_removed(run)
            run.rename(removed)
            _empty(removed)
            return True
    return not run.exists()


def remove_empty(directory: Path) -> None:
    """Delete a directory that holds nothing but a lock, which the caller has, if that."""
    with suppress(OSError):
        if _is_empty(directory):
            _empty(directory)


def sweep(log_directory: Path) -> None:
    """Delete what processes left behind that died while they made or deleted a run."""
    for run in runs(log_directory):
        with suppress(OSError):
            if _is_empty(run):
                lock = DirectoryLock.take(run)
                if lock is not None:
                    with lock:
                        remove_empty(run)
    for directory in passing_directories(log_directory):
        with suppress(OSError):
            if time.time() - directory.stat().st_ctime < _YOUNG:
                continue
            if foreign_names(directory, directory.stem.removeprefix(".")):
                continue
            lock = DirectoryLock.take(directory)
            if lock is not None:
                with lock:
                    _empty(directory)


def _is_empty(directory: Path) -> bool:
    return [entry.name for entry in directory.iterdir() if entry.name != LOCK] == []


def _empty(directory: Path) -> None:
    """Delete a directory that has lost its name, as far as that goes; the lock file last."""
    with suppress(OSError):
        for entry in sorted(directory.iterdir(), key=lambda entry: entry.name == LOCK):
            entry.unlink()
        directory.rmdir()
