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

"""What became of each drop simulation, by its events, and drops recorded one by one."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.records.scene import SCENE_FIELDS

# As in JobStatus; this room needs no ROS.
QUEUED, RUNNING, DONE, CANCELLED, FAILED = range(1, 6)
STATES = {
    QUEUED: "queued",
    RUNNING: "running",
    DONE: "done",
    CANCELLED: "cancelled",
    FAILED: "failed",
}
TERMINAL = ("done", "cancelled", "failed")
_OF_EVENT = (
    "part_digest",
    "refinement",
    "seed",
    *SCENE_FIELDS,
    "target_error",
    "max_seconds",
    "message",
)
"""Fields of a job that its events have, as far as their version had them."""


@dataclass
class Job:
    """A drop simulation that was asked for."""

    job_id: str
    part_id: str = ""
    part_digest: str = ""
    # `done`, `cancelled` or `failed`; `queued` or `running` where no end was recorded
    state: str = "queued"
    refinement: bool = False  # whether the node started it by itself
    drops: int = 0  # as requested, or the most
    drops_done: int = 0  # at the last event
    seed: int = 0  # of the random starts
    restitution: float = math.nan
    drop_height: float = math.nan  # metres
    cluster_tolerance: float = math.nan  # a share of the centre of mass's height
    round_sides: int = 0  # 0: round surfaces as the file has them
    target_error: float = math.nan  # a fraction
    max_seconds: float = math.nan
    message: str = ""  # the last that a client was told
    # nanoseconds since 1970; 0 where no such event was recorded
    queued: int = 0
    started: int = 0
    ended: int = 0
    # of the last event that counts: whether it is an end, its time, and its kind
    latest: tuple[bool, int, int] = field(default=(False, 0, 0), repr=False)

    @property
    def unfinished(self) -> bool:
        """Whether no end of it was recorded."""
        return self.state not in TERMINAL

    def add(self, event: Any, time: int) -> None:
        """Take in an event; events may come in any order and more than once."""
        kind = int(event.status.state)
        state = STATES[kind]
        if kind == QUEUED:
            self.queued = time
        elif kind == RUNNING:
            self.started = time
        else:
            self.ended = time
        # An end outranks everything: a clock that is put back does not revive a job.
        rank = (state in TERMINAL, time, kind)
        if rank < self.latest:
            return
        self.latest = rank
        self.state = state
        self.part_id = event.status.part_id
        self.drops = event.status.drops_total
        self.drops_done = event.status.drops_done
        for name in _OF_EVENT:
            if hasattr(event, name):
                setattr(self, name, getattr(event, name))


class JobCollector:
    """Gathers jobs, and when parts were forgotten."""

    def __init__(self) -> None:
        self.jobs: dict[str, Job] = {}
        self.forgotten: dict[tuple[str, str], set[int]] = {}

    def add(self, event: Any, time: int) -> None:
        """Take in a JobEvent."""
        status = event.status
        digest = str(getattr(event, "part_digest", ""))
        if getattr(event, "part_forgotten", False):
            self.note_forgotten(str(status.part_id), digest, time)
        elif status.state in STATES and status.job_id:
            self.jobs.setdefault(status.job_id, Job(status.job_id)).add(event, time)

    def note_forgotten(self, part_id: str, part_digest: str, time: int) -> None:
        """Take in that a part was forgotten."""
        self.forgotten.setdefault((part_id, part_digest), set()).add(time)


@dataclass
class DropLog:
    """Drops of one part that were recorded one by one."""

    drops: int = 0
    unsettled: int = 0
    impacts: int = 0  # of all these drops together
    seconds: float = 0.0  # from release to the end, of all these drops together


class DropCollector:
    """Gathers drop records by the digest of their part."""

    def __init__(self) -> None:
        self.logs: dict[str, DropLog] = {}
        self._pieces: set[tuple[str, int, int]] = set()

    def add(self, records: Any) -> None:
        """Take in a DropRecords, unless another bag had the same drops of the job."""
        poses = np.asarray(getattr(records, "pose_index", ()), dtype=np.int64)
        piece = (
            str(getattr(records, "job_id", "")),
            int(getattr(records, "first_drop", 0)),
            poses.size,
        )
        if piece in self._pieces:
            return
        self._pieces.add(piece)
        log = self.logs.setdefault(str(getattr(records, "part_digest", "")), DropLog())
        log.drops += poses.size
        log.unsettled += int(np.count_nonzero(poses < 0))
        log.impacts += int(np.sum(getattr(records, "impacts", ()), dtype=np.int64))
        log.seconds += float(np.sum(getattr(records, "seconds", ()), dtype=np.float64))
