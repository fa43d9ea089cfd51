"""Keeping a log directory below its bound by deleting the oldest finished runs."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path
from typing import Final

from ..run_names import runs
from .removal import delete_run

RESCAN: Final = 10.0
"""Seconds after which the log directory is looked at again, for what other nodes have done."""


class SpaceBound:
    """The bound of a log directory, as one run sees it.

    Parameters
    ----------
    log_directory : Path
        Where the runs are.
    limit : int
        Bytes of all runs together; 0 for no bound.

    Attributes
    ----------
    deleted : list of Path
        Runs that were deleted.
    exceeded : bool
        Whether there was too much at the last look, and nothing that may be deleted: this run,
        runs of living nodes, unfinished runs, and runs with files of somebody else in them.
    """

    def __init__(self, log_directory: Path, limit: int) -> None:
        self.deleted: list[Path] = []
        self.exceeded = False
        self._log_directory = log_directory
        self._limit = limit
        self._others = 0
        self._next_scan = 0.0

    def left(self, own_bytes: int) -> int | None:
        """Bytes by which the directory may still grow; None without a bound."""
        if not self._limit:
            return None
        return max(0, self._limit - self._others - own_bytes)

    def enforce(self, own: Path, own_bytes: int) -> None:
        """Delete what must go before this run grows to so many bytes.

        Parameters
        ----------
        own : Path
            This run; never deleted.
        own_bytes : int
            Its size to be.
        """
        if not self._limit:
            return
        now = time.monotonic()
        fits = self._others + own_bytes <= self._limit
        if now < self._next_scan and (fits or self.exceeded):
            return
        self._next_scan = now + RESCAN
        sizes = {run: _size(run) for run in runs(self._log_directory) if run != own}
        self._others = sum(sizes.values())
        for run, size in sizes.items():
            if self._others + own_bytes <= self._limit:
                break
            if delete_run(run):
                self._others -= size
                self.deleted.append(run)
        self.exceeded = self._others + own_bytes > self._limit


def _size(run: Path) -> int:
    """Bytes of the files of a run; 0 for one that has just been deleted."""
    size = 0
    with suppress(OSError), os.scandir(run) as entries:
        for entry in entries:
            with suppress(OSError):
                size += entry.stat(follow_symlinks=False).st_size
    return size
