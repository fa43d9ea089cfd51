"""Names of runs, of their files, and of directories that are only on their way in or out."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Final

from ..files import HALF, LOCK

METADATA: Final = "metadata.yaml"

_TIME: Final = "pose_stats_%Y%m%dT%H%M%S_%f"
_TIMED: Final = len("pose_stats_YYYYmmddTHHMMSS_ffffff")
_RUN = re.compile(r"pose_stats_\d{8}T\d{6}_\d{6}_\d+")
_PASSING = re.compile(rf"\.{_RUN.pattern}\.(new|old)")


def new_run_name(log_directory: Path) -> str:
    """`pose_stats_<YYYYmmddTHHMMSS>_<microseconds>_<pid>`; the time is UTC.

    Names in order are runs in order: where the clock was set back, the name is a microsecond
    later than that of the newest run.
    """
    time = datetime.now(timezone.utc)
    with suppress(OSError, ValueError):  # an unreadable folder, or a day that is none
        newest = max((run.name for run in runs(log_directory)), default="")
        if newest >= _timed(time):
            time = datetime.strptime(newest[:_TIMED], _TIME).replace(
                tzinfo=timezone.utc) + timedelta(microseconds=1)
    return f"{_timed(time)}_{os.getpid()}"


def _timed(time: datetime) -> str:
    """The part of a name that has the time."""
    return time.strftime(_TIME)


def runs(log_directory: Path) -> list[Path]:
    """All runs' directories, oldest first; none where the log directory is missing."""
    return _matching(log_directory, _RUN)


def passing_directories(log_directory: Path) -> list[Path]:
    """Directories of runs that are being made or removed, or were when their process died."""
    return _matching(log_directory, _PASSING)


def being_made(directory: Path) -> Path:
    """Where a run's directory is prepared before it takes its name."""
    return directory.with_name(f".{directory.name}.new")


def being_removed(directory: Path) -> Path:
    """Where a run's directory goes before its files are deleted."""
    return directory.with_name(f".{directory.name}.old")


def bag_file(directory: Path, number: int) -> Path:
    """Path of a run's file; they are numbered from 0."""
    return directory / f"{directory.name}_{number}.mcap"


def bag_files(directory: Path) -> list[Path]:
    """A run's own files in the order of their numbers."""
    numbered = [(int(match[1]), directory / match[0])
                for match in map(_own_files(directory.name).fullmatch, _names(directory)) if match]
    return [path for _, path in sorted(numbered)]


def foreign_names(directory: Path, run: str) -> list[str]:
    """Names in a directory that the run of this name does not make."""
    own = _own_files(run)
    return [name for name in _names(directory) if not (
        own.fullmatch(name.removesuffix(HALF)) or name.removesuffix(HALF) in (METADATA, LOCK))]


def _own_files(run: str) -> re.Pattern[str]:
    return re.compile(re.escape(run) + r"_(\d+)\.mcap")


def _matching(folder: Path, pattern: re.Pattern[str]) -> list[Path]:
    return [folder / name for name in _names(folder)
            if pattern.fullmatch(name) and (folder / name).is_dir()]


def _names(folder: Path) -> list[str]:
    try:
        return sorted(entry.name for entry in os.scandir(folder))
    except (FileNotFoundError, NotADirectoryError):
        return []
