"""Keeping a log directory below its bound, and clearing away what is left of runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from ...files import LOCK, DirectoryLock, is_locked
from ..finished import is_finished
from ..run_names import being_removed, foreign_names, passing_directories, runs

_YOUNG: Final = 60.0
"""Seconds for which a directory without its name is left to whoever is busy with it."""

RESCAN: Final = 10.0
"""Seconds after which the log directory is looked at again, for what other nodes have done."""

SOON: Final = 0.1
"""Seconds after which it is looked at again where a run must go that is still in use."""


class SpaceBound:
    """The bound of a log directory, as one run sees it.

    `limit`: bytes of all runs together; 0 for no bound; `margin`: a run is asked for while the
    directory may still grow by so many bytes. Attributes `deleted`: runs that were deleted;
    `exceeded`: whether there was too much at the last look, and nothing that may be deleted: the
    file that this run is writing, runs of living nodes, unfinished runs, and runs with files of
    somebody else in them; `held`: bytes of the runs that other nodes had in hand at the last look;
    `waits`: whether a run must go that was still in use at the last look; `in_use`: whether a run
    holds what this one does not have yet; it is asked before the run must go, and then sees to it
    that this does not last.
    """

    def __init__(self, log_directory: Path, limit: int, margin: int = 0) -> None:
        self.deleted: list[Path] = []
        self.exceeded = False
        self.held = 0
        self.waits = False
        self._log_directory = log_directory
        self._limit = limit
        self._margin = margin
        self.in_use: Callable[[Path], bool] = lambda run: False
        self._others = 0
        self._next_scan = 0.0

    def left(self, own_bytes: int) -> int | None:
        """Bytes by which the directory may still grow; None without a bound."""
        if not self._limit:
            return None
        return max(0, self._limit - self._others - own_bytes)

    def look_again(self) -> None:
        """Look at the directory the next time, whenever that is."""
        self._next_scan = 0.0

    def enforce(self, own: Path, own_bytes: int, drop_oldest: Callable[[], int]) -> None:
        """Delete what must go before this run grows to so many bytes.

        `own`: this run; never deleted as a whole; `drop_oldest`: deletes the oldest of its closed
        files, once no other run may go, and returns how many bytes that were; 0 where there is
        none. A run that is about to be free is waited for as long as the bound is exceeded by no
        more than the margin.
        """
        if not self._limit:
            return
        now = time.monotonic()
        if now >= self._next_scan or not (self._fits(own_bytes) or self.exceeded):
            self._delete_runs(own, own_bytes)
            self._next_scan = now + (SOON if self.waits else RESCAN)
        patience = self._margin if self.waits else 0
        while not self._fits(own_bytes - patience):
            dropped = drop_oldest()
            if not dropped:
                break
            own_bytes -= dropped
        self.exceeded = not self._fits(own_bytes)

    def _fits(self, own_bytes: int) -> bool:
        return self._others + own_bytes <= self._limit

    def _delete_runs(self, own: Path, own_bytes: int) -> None:
        """Look at the directory again, and delete the oldest runs until it fits.

        Those that are in use are waited for; the next ones are asked for in good time.
        """
        sizes = {run: _size(run) for run in runs(self._log_directory) if run != own}
        self._others = sum(sizes.values())
        self.waits = False
        excess = self._others + own_bytes - self._limit
        for run, size in sizes.items():
            if excess + self._margin <= 0:
                break
            if self.in_use(run):
                self.waits = self.waits or excess > 0
                excess -= size
            elif excess <= 0:
                excess -= size
            elif delete_run(run):
                self._others -= size
                excess -= size
                self.deleted.append(run)
        self.held = sum(size for run, size in sizes.items() if is_locked(run))


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
