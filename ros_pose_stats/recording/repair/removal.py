"""Deleting runs, and what is left of runs that were being made or deleted."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path
from typing import Final

from ..directory_lock import DirectoryLock
from ..finished import is_finished
from ..run_names import LOCK, being_removed, foreign_names, passing_directories, runs

_YOUNG: Final = 60.0
"""Seconds for which a directory without its name is left to whoever is busy with it."""


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
