"""Mending the bags of runs that ended without being able to finish them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..directory_lock import DirectoryLock
from ..finished import is_finished
from ..run_names import bag_files, runs
from .mending import mend
from .removal import sweep


@dataclass(frozen=True)
class Repair:
    """What was done to one bag.

    Attributes
    ----------
    directory : Path
        The bag.
    kept : int
        Messages in it now; 0 where it could not be mended.
    cut_bytes : int
        Bytes of half or damaged records that were cut away.
    problem : str
        Why it could not be mended; empty where it is.
    """

    directory: Path
    kept: int = 0
    cut_bytes: int = 0
    problem: str = ""


def repair_bags(log_directory: Path) -> list[Repair]:
    """Mend all unfinished bags of a log directory that no process has in hand.

    A missing log directory holds none. Directories and files with other names than ours are
    left alone.

    Returns
    -------
    list of Repair
        One for each bag that was not finished, oldest first; nothing is raised. One for the
        log directory itself, if it cannot be read.
    """
    try:
        sweep(log_directory)
        found = runs(log_directory)
    except OSError as error:
        return [Repair(log_directory, problem=_problem(log_directory, error))]
    tried = map(_repair, found)
    return [repair for repair in tried if repair is not None]


def _repair(run: Path) -> Repair | None:
    """Mend one bag; None where there is nothing to do, or somebody else has it."""
    try:
        if is_finished(run) or not bag_files(run):
            return None
        lock = DirectoryLock.take(run)
        if lock is None:
            return None
        with lock:
            if is_finished(run):
                return None
            done = mend(run)
    except OSError as error:
        return Repair(run, problem=_problem(run, error))
    return Repair(run, done.kept, done.cut_bytes)


def _problem(directory: Path, error: OSError) -> str:
    return f"cannot mend {directory}: {error.strerror or error}"
