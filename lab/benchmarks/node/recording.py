"""Bytes of results and jobs in the bag, and the time that the disk under it takes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ros_pose_stats_msgs import srv

from ros_pose_stats.recording.reader.raw_reader import RawMessage, raw_messages
from ros_pose_stats.recording.writer.mcap_layout import message_size
from ros_pose_stats.recording.writer.run_log import RunLog
from ros_pose_stats.ros.recorder import ANSWERS, bag_types

from ..bodies import Body
from ..results import Row, Section
from ..timing import Contender, Pace, race
from . import jobs
from .client import Client
from .spread import spread

PART_ID = "polyhedron"
DROPS = 1000

BAG_TIMED = (
    "Bytes in the bag's file, read back while the node ran: a new part with {poses} poses, one "
    "answer of `estimate`, and a job of {drops} drops from its start to DONE, topic by topic. "
    "Not times.")


def bag_bytes(client: Client, body: Body, log_directory: Path) -> Section:
    """A row for each topic that a step writes to."""
    reader = _Reader(log_directory)
    jobs.make_known(client, PART_ID, body)
    rows = _rows("new part", reader.new())
    answer = jobs.accepted(client.call(srv.EstimatePoses, "estimate",
                                       srv.EstimatePoses.Request(part_id=PART_ID)))
    rows += _rows("estimate", reader.new())
    jobs.wait_for_end(client, jobs.start(client, jobs.start_request(PART_ID, DROPS)))
    client.spin_for(0.2)  # what is latched follows the end
    rows += _rows("job", reader.new())
    return Section("bag_bytes", "Bytes in the bag", BAG_TIMED.format(
        poses=len(answer.statistics.poses), drops=DROPS), tuple(rows))


class _Reader:
    """Messages that have come to the newest bag since it was last read."""

    def __init__(self, log_directory: Path) -> None:
        self._directory = log_directory
        self._read = 0
        self.new()

    def new(self) -> list[RawMessage]:
        """Messages since the last call."""
        bags = sorted(self._directory.iterdir()) if self._directory.is_dir() else []
        found = list(raw_messages(bags[-1])) if bags else []
        fresh, self._read = found[self._read:], len(found)
        return fresh


def _rows(step: str, messages: Sequence[RawMessage]) -> list[Row]:
    rows = []
    for topic in dict.fromkeys(message.topic for message in messages):
        sizes = [message_size(one.data) for one in messages if one.topic == topic]
        rows.append(Row(f"{step}, {topic}", {"messages": len(sizes), "bytes": sum(sizes)}))
    return rows


RECORD = bytes(range(256)) * 8
"""Bytes of about a result with a few poses."""
MOST_MILLISECONDS = 2.0

DISK_TIMED = (
    "Appending {} bytes to a file and waiting until they are on disk (`fdatasync`), measured with "
    "the system's calls alone in the file system of the log directory; in turns with it what the "
    "node does for a record. The bounds of the services are meant for disks on which the first "
    "row takes at most {:g} ms.")


def disk(folder: Path, pace: Pace) -> Section:
    """Rows for the bare system calls and for the bag's.

    Parameters
    ----------
    folder : Path
        Created in the file system of the log directory.
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
    return Section("disk", "The disk", DISK_TIMED.format(len(RECORD), MOST_MILLISECONDS), tuple(
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
