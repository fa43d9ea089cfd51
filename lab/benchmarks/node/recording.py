"""Bytes of results and jobs in the bag, and the time that the disk under it takes."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from ros_pose_stats_msgs import srv

from ros_pose_stats.node.recorder import ANSWERS, TYPES, message_type
from ros_pose_stats.node.recording.reader import RawMessage, raw_messages
from ros_pose_stats.node.recording.run_log import RunLog
from ros_pose_stats.node.recording.writer.mcap_layout import message_size
from ros_pose_stats.node.state import Change, State

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
    "Not times."
)


def bag_bytes(client: Client, body: Body, log_directory: Path) -> Section:
    """A row for each topic that a step writes to."""
    reader = _Reader(log_directory)
    jobs.make_known(client, PART_ID, body)
    rows = _rows("new part", reader.new())
    answer = jobs.accepted(
        client.call(
            srv.EstimatePoses, "estimate", srv.EstimatePoses.Request(part_id=PART_ID)
        )
    )
    rows += _rows("estimate", reader.new())
    jobs.wait_for_end(client, jobs.start(client, jobs.start_request(PART_ID, DROPS)))
    client.spin_for(0.2)  # what is latched follows the end
    rows += _rows("job", reader.new())
    return Section(
        "bag_bytes",
        "Bytes in the bag",
        BAG_TIMED.format(poses=len(answer.statistics.poses), drops=DROPS),
        tuple(rows),
    )


class _Reader:
    """Messages that have come to the newest bag since it was last read."""

    def __init__(self, log_directory: Path) -> None:
        self._directory = log_directory
        self._read = 0
        self.new()

    def new(self) -> list[RawMessage]:
        """Messages since the last call."""
        bags = sorted(self._directory.glob("pose_stats_*"))
        found = list(raw_messages(bags[-1])) if bags else []
        fresh = found[self._read :]
        self._read = len(found)
        return fresh


def _rows(step: str, messages: Sequence[RawMessage]) -> list[Row]:
    rows = []
    for topic in dict.fromkeys(message.topic for message in messages):
        sizes = [message_size(one.data) for one in messages if one.topic == topic]
        rows.append(
            Row(f"{step}, {topic}", {"messages": len(sizes), "bytes": sum(sizes)})
        )
    return rows


SIZES = {"2 kB": bytes(range(256)) * 8, "2 MB": bytes(range(256)) * 8192}
"""Bytes of about a result with a few poses, and of a mesh of some 50 000 triangles."""

MOST_MILLISECONDS = 2.0

DISK_TIMED = (
    "Appending 2 kB to a file and waiting until they are on disk (`fdatasync`), measured with the "
    "system's calls alone in the file system of the log directory; in turns with it the same of "
    "2 MB, a record in the bag, with and without a wait for the disk, and a commit of the state: "
    "2 kB as the row of a result, 2 MB as a mesh, which lies in a file beside it, and as a row. "
    "The bounds of the services are meant for disks on which the first row takes at most {:g} ms."
)


def disk(folder: Path, pace: Pace) -> Section:
    """Rows for the bare system calls, the bag's and the state's.

    `folder`: created in the file system of the log directory.
    """
    folder.mkdir()
    numbers = itertools.count(1)
    with _appender(folder / "appended") as append:
        log = RunLog(
            folder / "bags",
            {topic: message_type(kind) for topic, kind in TYPES.items()},
            max_bag_bytes=2**29,
        )
        state = State(folder / "state.sqlite3")

        def record(data: bytes, *, wait: bool) -> None:
            log.write(ANSWERS, data)
            if wait:
                log.sync()

        def commit_row(data: bytes) -> None:
            part_id = f"part of {len(data)} bytes"
            change = Change("results", part_id, (part_id, data, b"", next(numbers)))
            assert state.commit(state.put(change))

        def commit_mesh(data: bytes) -> None:
            part_id = f"part of {len(data)} bytes"
            number = next(numbers)
            assert state.commit(
                state.put_mesh(part_id, number.to_bytes(8, "big") + data)
            )

        calls = {
            f"{name} {size}": partial(call, data)
            for size, data in SIZES.items()
            for name, call in (
                ("append and fdatasync", append),
                ("record in the bag, on disk", partial(record, wait=True)),
                (
                    "record in the bag, handed to the system",
                    partial(record, wait=False),
                ),
                ("row of the state, committed", commit_row),
                ("mesh of the state, committed", commit_mesh),
            )
        }
        for call in calls.values():
            call()
        timings = race(
            [
                Contender(name, lambda _, call=call: call())
                for name, call in calls.items()
            ],
            pace,
        )
        log.close()
        state.close()
    bare = next(iter(calls))
    return Section(
        "disk",
        "The disk",
        DISK_TIMED.format(MOST_MILLISECONDS),
        tuple(
            Row(
                name,
                {
                    **spread(timings.seconds[name]),
                    "times the first": timings.ratio(name, bare),
                },
            )
            for name in calls
        ),
    )


@contextmanager
def _appender(file: Path) -> Iterator[Callable[[bytes], None]]:
    number = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def append(data: bytes) -> None:
        os.write(number, data)
        os.fdatasync(number)

    try:
        yield append
    finally:
        os.close(number)
