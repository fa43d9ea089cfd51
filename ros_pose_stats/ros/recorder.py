"""Messages to the bag; a bag that cannot be written never stops the node."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
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

    `node`: fully qualified name of the node; `say`: told once when recording fails and once when
    it works again. Attributes `on_gap`: called, in a thread of its own, where something that still
    counts may be missing in the bag: after recording has failed, when the bag was deleted and a
    new one begun, and before the oldest files or runs are deleted for max_log_bytes. It records
    again what it recorded while `mark` was below what is `trusted_from` now; `before_record`: puts
    on record what has to be there before anything else; whether it is; `counts_lost`: messages of
    cameras that a flood overran; `closing`: whether the node ends, and nothing is to be recorded
    again any more.
    """

    def __init__(self, settings: Settings, node: str, say: Callable[[str], object]) -> None:
        self.log = RunLog(settings.directory(), bag_types(),
                          max_bag_bytes=settings.max_bag_bytes,
                          max_log_bytes=settings.max_log_bytes, node=node)
        self.log.own_files.released = 0
        self._say = say
        self.on_gap: Callable[[], object] = lambda: None
        self.before_record: Callable[[], bool] = lambda: True
        self.counts_lost = 0
        self.closing = False
        self._again = ThreadPoolExecutor(1, "record again")
        self._asked = False
        self._asking = threading.Lock()
        self._gaps = 0
        self._noticed = self._distrusted = 0
        self._crowded = 0
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

        Returns false if it could not be written; `problem` says why.
        """
        if not self.before_record():
            return False
        written = self._attempt(partial(self.log.write, topic, data, durable=durable))
        if written:
            self._note("")
            kept_from = self.log.own_files.kept_from
            if kept_from > self._noticed:
                self._noticed = kept_from
                self.have_recorded_again()
        return written

    @property
    def mark(self) -> int:
        """A number that only rises; what is recorded from now on has this one or more."""
        return self.log.mark + self._gaps

    @property
    def trusted_from(self) -> int:
        """What was recorded at a lower mark is not in the bag, or not for long."""
        return max(self._distrusted, self.log.own_files.kept_from + self._gaps)

    def has_room_for(self, size: int) -> bool:
        """Whether so many bytes may be recorded again and again, whenever their files go."""
        room = self.log.room_to_keep
        self._crowded = size if room is not None and size > room else 0
        return not self._crowded

    def count_lost(self, count: int) -> int:
        """Count what cameras sent and a flood overran; how much that is by now."""
        with self._lock:
            self.counts_lost += count
            return self.counts_lost

    def sync(self) -> bool:
        """Make everything written so far durable; whether it is."""
        return self._attempt(self.log.sync)

    def close(self) -> None:
        """Finish the bag."""
        with self._asking:
            self.closing = True
        self._again.shutdown()
        self._attempt(self.log.close)

    def _attempt(self, act: Callable[[], object]) -> bool:
        try:
            act()
        except OSError as error:
            self._note(str(error))
            return False
        return True

    def _note(self, problem: str) -> None:
        mark = self.log.mark  # before the lock, under which the log must not be asked
        with self._lock:
            changed = bool(problem) != bool(self.problem)
            new_bag = self.log.times_lost != self._bags_lost
            self._bags_lost = self.log.times_lost
            self.problem = problem
            self.last_problem = problem or self.last_problem
            self.lost += bool(problem)
            gap = not problem and (changed or new_bag)
            if gap:
                self._gaps += 1
                self._distrusted = mark + self._gaps
        if changed:
            self._say(f"NOT_RECORDED: {problem}" if problem else "recording works again")
        if new_bag and not problem:
            self._say(f"the bag was deleted; recording goes on in {self.log.directory}")
        if gap:
            self.have_recorded_again()

    def have_recorded_again(self) -> None:
        """Call `on_gap` elsewhere: whoever records may hold what that waits for."""
        with self._asking:
            if not (self._asked or self.closing):
                self._asked = True
                self._again.submit(self._fill_gap)

    def _fill_gap(self) -> None:
        """Have it recorded again, and only then let the files go that hold it so far."""
        self._asked = False
        kept_from, lost = self.log.own_files.kept_from, self.lost
        try:
            self.on_gap()
        except Exception as error:  # nobody looks at what is submitted
            self._say(f"internal failure: what counts is not recorded again: {error!r}")
        if self.sync() and self.lost == lost and not self.closing:
            self._attempt(partial(self.log.release_files, kept_from))

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
            text = "log_directory is larger than max_log_bytes, " + (
                "until what counts in its oldest files has been recorded again" if self.log.waits
                else "and nothing that is left in it may be deleted")
        elif not self.problem and self._crowded:
            text = (f"the known parts ({self._crowded} bytes) are too large for max_log_bytes: "
                    "they are not recorded again when the files that hold them go")
        return Health(text != "recording", text, {
            "bag": str(self.log.directory), "bytes written": self.log.bytes_written,
            "bytes left": self._left(), "messages not recorded": self.lost,
            "runs deleted for max_log_bytes": len(self._deleted),
            "last run deleted": self._deleted[-1] if self._deleted else "none",
            "files deleted for max_log_bytes": self.log.own_files.deleted,
            "last file deleted": self.log.own_files.last_deleted or "none",
            "counts lost": self.counts_lost,
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
