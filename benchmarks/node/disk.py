"""What the disk under the log directory takes, and what the bag adds."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ros_pose_stats.recording.writer.run_log import RunLog
from ros_pose_stats.ros.recorder import ANSWERS, bag_types

from ..results import Row, Section
from ..timing import Contender, Pace, race
from .spread import spread

RECORD = bytes(range(256)) * 8
"""About a result with a few poses."""
MOST_MILLISECONDS = 2.0

TIMED = (
    "Appending {} bytes to a file and waiting until they are on disk (`fdatasync`), measured with "
    "the system's calls alone in the file system of the log directory; in turns with it what the "
    "node does for a record. The bounds of the services are meant for disks on which the first "
    "row takes at most {:g} ms.")


def disk(folder: Path, pace: Pace) -> Section:
    """Rows for the bare system calls and for the bag's.

    Parameters
    ----------
    folder : Path
        To be made in the log directory's file system.
    pace : Pace
    """
    types = bag_types()
    folder.mkdir()
    with _appender(folder / "appended") as append:
        log = RunLog(folder / "bags", types, max_bag_bytes=2**29)
        calls = {
            "append and fdatasync": lambda _: append(),
            "record in the bag, on disk": lambda _: log.write(ANSWERS, RECORD, durable=True),
            "record in the bag, handed to the system":
                lambda _: log.write(ANSWERS, RECORD, durable=False),
        }
        for call in calls.values():
            call(None)
        timings = race([Contender(name, call) for name, call in calls.items()], pace)
        log.close()
    bare = next(iter(calls))
    return Section("disk", "The disk", TIMED.format(len(RECORD), MOST_MILLISECONDS), tuple(
        Row(name, {**spread(timings.seconds[name]), "times the first": timings.ratio(name, bare)})
        for name in calls))


@contextmanager
def _appender(file: Path) -> Iterator[Callable[[], None]]:
    number = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def append() -> None:
        os.write(number, RECORD)
        os.fdatasync(number)

    try:
        yield append
    finally:
        os.close(number)
