# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Messages to the bag; a bag that cannot be written never stops the node.

Bag and state have the messages with their definitions, so that a later version reads
them.
"""

import os
import shutil
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_share_directory,
)
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import msg

from ..core.mesh.bodies import separation
from .recording import reader, repair, run_log
from .recording.decoding import Decoders
from .recording.writer import message_types
from .refusals import Health
from .settings import Settings
from .state import MESSAGES, State

PACKAGE = "ros_pose_stats_msgs"
PART_MESH = "/pose_stats/part_mesh"
POSE_STATISTICS = "/pose_stats/pose_statistics"
ANSWERS = "/pose_stats/answers"
JOB_EVENTS = "/pose_stats/job_events"
POSE_COUNTS = "/pose_stats/pose_counts"
DROP_RECORDS = "/pose_stats/drop_records"

TYPES = {
    PART_MESH: "PartMesh",
    POSE_STATISTICS: "PoseStatistics",
    ANSWERS: "PoseStatistics",
    JOB_EVENTS: "JobEvent",
    POSE_COUNTS: "PoseCounts",
    DROP_RECORDS: "DropRecords",
}

_decoders = Decoders()


def share_directory(package: str) -> Path:
    """Share folder of an interface package, of ROS or of a virtual environment."""
    try:
        return Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError, OSError):
        return Path(sys.prefix) / "share" / package


@cache
def message_type(kind: str) -> message_types.MessageType:
    """One of the package's messages as it is installed."""
    return message_types.message_type(f"{PACKAGE}/msg/{kind}", share_directory)


def definitions() -> dict[str, str]:
    """Definitions of the messages in the state, by type, as they are installed."""
    return {
        kind: message_type(kind).definition
        for kinds in MESSAGES.values()
        for kind in kinds.values()
    }


def convert_to_installed(kind: str, definition: str, data: bytes) -> bytes | None:
    """A message of another definition, by the names of its fields; None if broken."""
    if definition == message_type(kind).definition:
        return data
    decoded = _decoders.decode(
        reader.RawMessage("", f"{PACKAGE}/msg/{kind}", data, 0, definition)
    )
    if decoded is None:
        return None
    message = _fill_message(getattr(msg, kind)(), decoded)
    if kind == TYPES[PART_MESH] and not hasattr(decoded, "body"):
        message.body = separation.ALL  # all were one rigid part then
    return bytes(serialize_message(message))


def _fill_message(message: Any, decoded: Any) -> Any:
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(decoded, name, None)
        default = getattr(message, name)
        if value is None:
            continue
        if hasattr(default, "get_fields_and_field_types"):
            _fill_message(default, value)
        elif "/" in kind:
            package, _, type_name = (
                kind.removeprefix("sequence<").rstrip(">").partition("/")
            )
            make = getattr(import_module(f"{package}.msg"), type_name)
            setattr(message, name, [_fill_message(make(), item) for item in value])
        else:
            setattr(message, name, value)
    return message


class Recorder:
    """The run's bag: a log of what came, was answered, latched, counted and dropped.

    What the state is to have goes there first, so a kill in between costs a line of the
    log.
    """

    def __init__(
        self, settings: Settings, node: str, state: State, warn: Callable[[str], object]
    ) -> None:
        self._state = state
        self._warn = warn
        types = {topic: message_type(kind) for topic, kind in TYPES.items()}
        self.log = run_log.RunLog(
            settings.directory(),
            types,
            max_bag_bytes=settings.max_bag_bytes,
            max_log_bytes=settings.max_log_bytes,
            node=node,
            warn=warn,
        )
        self._directory = self.log.directory
        self.lost = 0  # messages that were not recorded
        self._lock = threading.Lock()
        self.problem = self.last_problem = _find_problem(settings.directory())
        if self.problem:
            warn(f"NOT_RECORDED: {self.problem}")
        self._last_repair = "none"

    def record(self, topic: str, data: bytes) -> bool:
        """Write a serialised message; false if it could not be: see `problem`."""
        written = self._attempt(partial(self.log.write, topic, data))
        if written:
            self._note("")
        return written

    @property
    def bag(self) -> Path:
        """The bag that records go to, another one once it was deleted or moved."""
        with suppress(OSError):  # the next record says what is wrong
            self.log.leave_lost_bag()
        return self.log.directory

    def sync(self) -> None:
        """Have what was recorded survive a power cut."""
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
        bag = self.log.directory
        with self._lock:
            changed = bool(problem) != bool(self.problem)
            is_new = not problem and bag != self._directory
            if is_new:
                self._directory = bag
            self.problem = problem
            self.last_problem = problem or self.last_problem
            self.lost += bool(problem)
        if changed:
            self._warn(
                f"NOT_RECORDED: {problem}" if problem else "recording works again"
            )
        if is_new:
            self._warn(f"the bag was deleted; recording goes on in {bag}")

    def mend_bags(self) -> None:
        """Mend and index what earlier runs left in the folder; say what was lost."""
        log = self.log
        for mended in repair.repair_bags(
            log.directory.parent, log.indexer.write, log.room_for
        ):
            if log.is_closed:
                return  # what is left is for the next start
            self._last_repair = mended.problem or (
                f"{mended.directory.name} mended: {mended.messages} messages whole, "
                f"{mended.cut_bytes} bytes of half a record cut off"
            )
            self._warn(self._last_repair)

    def health(self, counts_lost: int) -> Health:
        """What diagnostics say about the bag."""
        problem = self.problem or self._state.problem
        bounds = [] if self.log.bytes_left is None else [self.log.bytes_left]
        problem_with_disk = ""
        try:
            home = next(path for path in self.log.directory.parents if path.is_dir())
            bounds.append(shutil.disk_usage(home).free)
        except OSError as error:
            problem_with_disk = f"unknown: {error}"
        text = "recording"
        if problem:
            text = f"NOT_RECORDED: {problem}"
        elif self.log.space.is_exceeded:
            text = (
                "log_directory is larger than max_log_bytes, and nothing that is left "
                "in it may be deleted"
            )
        elif self._state.set_aside:
            text = (
                f"the state file could not be read; it is now {self._state.set_aside}"
            )
        return Health(
            text != "recording",
            text,
            {
                "bag": str(self.log.directory),
                "bytes written": self.log.bytes_written,
                "bytes left": problem_with_disk or min(bounds),
                "messages not recorded": self.lost,
                "deleted for max_log_bytes": self.log.space.deletions,
                "last deleted": self.log.space.last_deleted or "none",
                "counts lost": counts_lost,
                "last repair": self._last_repair,
                "state file": str(self._state.file),
                "state file set aside": self._state.set_aside or "none",
            },
        )


def _find_problem(directory: Path) -> str:
    """Why nothing can be recorded there as it seems; empty where it can."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return f"cannot make {directory}: {error.strerror or error}"
    return "" if os.access(directory, os.W_OK) else f"cannot write to {directory}"
