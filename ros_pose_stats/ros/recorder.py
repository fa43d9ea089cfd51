"""Messages to the bag; a bag that cannot be written never stops the node."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

from ..recording.repair.repair import Repair, repair_bags
from ..recording.writer.message_types import MessageType, message_type
from ..recording.writer.run_log import RunLog
from .diagnostics import Health
from .settings import Settings

PACKAGE = "ros_pose_stats_msgs"
PART_MESH = "/pose_stats/part_mesh"
POSE_STATISTICS = "/pose_stats/pose_statistics"
ANSWERS = "/pose_stats/answers"
JOB_EVENTS = "/pose_stats/job_events"
POSE_COUNTS = "/pose_stats/pose_counts"
DROP_RECORDS = "/pose_stats/drop_records"

TYPES = {PART_MESH: "PartMesh", POSE_STATISTICS: "PoseStatistics", ANSWERS: "PoseStatistics",
         JOB_EVENTS: "JobEvent", POSE_COUNTS: "PoseCounts", DROP_RECORDS: "DropRecords"}


def share_directory(package: str) -> Path:
    """Share folder of an interface package, in a ROS installation or in a virtual environment."""
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        return Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError, OSError):
        return Path(sys.prefix) / "share" / package


def bag_types() -> dict[str, MessageType]:
    """The bag's topics and their types."""
    return {topic: message_type(f"{PACKAGE}/msg/{name}", share_directory)
            for topic, name in TYPES.items()}


def _repair_line(repair: Repair) -> str:
    if repair.problem:
        return repair.problem
    return (f"{repair.directory.name} mended: {repair.kept} messages kept, "
            f"{repair.cut_bytes} bytes of half a record cut off")


class Recorder:
    """The run's bag.

    Parameters
    ----------
    settings : Settings
    node : str
        Fully qualified name of the node.
    say : callable
        Told once when recording fails and once when it works again.

    Attributes
    ----------
    on_gap : callable
        Called when something may be missing in the bag that goes on: after recording has
        failed, or when the bag was deleted and a new one begun.
    before_record : callable
        Puts on record what has to be there before anything else; whether it is.
    """

    def __init__(self, settings: Settings, node: str, say: Callable[[str], object]) -> None:
        self.log = RunLog(settings.directory(), bag_types(),
                          max_bag_bytes=settings.max_bag_bytes,
                          max_log_bytes=settings.max_log_bytes, node=node)
        self._say = say
        self.on_gap: Callable[[], object] = lambda: None
        self.before_record: Callable[[], bool] = lambda: True
        self._bags_lost = 0
        self._lock = threading.Lock()
        self.problem = self.last_problem = _unwritable(settings.directory())
        if self.problem:
            say(f"NOT_RECORDED: {self.problem}")
        self.lost = 0
        self._deleted: list[str] = []
        self._last_repair = "none"

    def record(self, topic: str, data: bytes, *, durable: bool = False) -> bool:
        """Write a serialised message; durable ones are on disk when this returns.

        Returns
        -------
        bool
            False if it could not be written; `problem` says why.
        """
        if not self.before_record():
            return False
        written = self._attempt(partial(self.log.write, topic, data, durable=durable))
        if written:
            self._note("")
        return written

    def sync(self) -> None:
        """Make everything written so far durable."""
        self._attempt(self.log.sync)

    def close(self) -> None:
        """Finish the bag."""
        self._attempt(self.log.close)

    def _attempt(self, act: Callable[[], object]) -> bool:
        try:
            act()
        except OSError as error:
            self._note(str(error))
            return False
        return True

    def _note(self, problem: str) -> None:
        with self._lock:
            changed = bool(problem) != bool(self.problem)
            new_bag = self.log.times_lost != self._bags_lost
            self._bags_lost = self.log.times_lost
            self.problem = problem
            self.last_problem = problem or self.last_problem
            self.lost += bool(problem)
        if changed:
            self._say(f"NOT_RECORDED: {problem}" if problem else "recording works again")
        if new_bag and not problem:
            self._say(f"the bag was deleted; recording goes on in {self.log.directory}")
        if not problem and (changed or new_bag):
            self.on_gap()

    def mend_bags(self) -> None:
        """Mend what earlier runs left unfinished in the folder, and say so."""
        for repair in repair_bags(self.log.directory.parent):
            self._last_repair = _repair_line(repair)
            self._say(self._last_repair)

    def health(self) -> Health:
        """What diagnostics say about the bag."""
        self._deleted += [run.name for run in self.log.deleted_runs]
        text = f"NOT_RECORDED: {self.problem}" if self.problem else "recording"
        if not self.problem and self.log.over_bound:
            text = "this run alone is larger than max_log_bytes; nothing of it is deleted"
        return Health(text != "recording", text, {
            "bag": str(self.log.directory), "bytes written": self.log.bytes_written,
            "bytes left": self._left(), "messages not recorded": self.lost,
            "runs deleted for max_log_bytes": len(self._deleted),
            "last run deleted": self._deleted[-1] if self._deleted else "none",
            "last repair": self._last_repair})

    def _left(self) -> int | str:
        """What the bound on all bags and the disk leave room for."""
        bounds = [] if self.log.bytes_left is None else [self.log.bytes_left]
        try:
            home = next(path for path in self.log.directory.parents if path.is_dir())
            bounds.append(shutil.disk_usage(home).free)
        except OSError as error:
            return f"unknown: {error}"
        return min(bounds)


def _unwritable(directory: Path) -> str:
    """Why nothing can be recorded there as it seems; empty where it can."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return f"cannot make {directory}: {error.strerror or error}"
    return "" if os.access(directory, os.W_OK) else f"cannot write to {directory}"
