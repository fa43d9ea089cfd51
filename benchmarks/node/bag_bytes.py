"""What results and jobs cost in the bag."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ros_pose_stats_msgs import srv

from ros_pose_stats.recording.reader.raw_reader import RawMessage, raw_messages
from ros_pose_stats.recording.writer.mcap_layout import message_size

from ..bodies import Body
from ..results import Row, Section
from . import jobs
from .client import Client

PART_ID = "polyhedron"
DROPS = 1000

TIMED = (
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
    return Section("bag_bytes", "Bytes in the bag", TIMED.format(
        poses=len(answer.statistics.poses), drops=DROPS), tuple(rows))


class _Reader:
    """Messages that have come to the newest bag since it was last read."""

    def __init__(self, log_directory: Path) -> None:
        self._directory = log_directory
        self._read = 0
        self.new()

    def new(self) -> list[RawMessage]:
        """Those that are new."""
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
