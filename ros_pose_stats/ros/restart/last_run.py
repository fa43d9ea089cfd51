"""What the bags of earlier runs leave to a node that starts: parts, results, unfinished jobs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ...errors import RequestError
from ...recording.reader.raw_reader import RawMessage, raw_messages
from ...records import DropScene
from ...records.statistics import FORGOTTEN
from ..messages.mesh_views import NotPlainCdrError, part_and_digest_of
from ..messages.part_messages import request_of_part_bytes
from ..messages.statistics_messages import is_farewell
from .current_meshes import CurrentMeshes, RecordedMesh
from .earlier_runs import JOB_EVENT
from .places import place_from, place_of
from .recorded_messages import is_of_today, read_recorded

PART_MESH = "ros_pose_stats_msgs/msg/PartMesh"
POSE_STATISTICS = "ros_pose_stats_msgs/msg/PoseStatistics"

PART_RESTORED = 6
"""Kind of `JobEvent` whose message is the `Place` of a part's mesh in the bag of another run."""

MOST_REVISION = 2**63
"""Results are numbered from 1; the next ones must fit into the message too."""

MOST_INDEX = 2**31 - 1
"""Of a pose, as markers can carry it."""


def scene_of(event: JobEvent) -> DropScene:
    """The scene of a job.

    Raises RequestError if there is no such scene.
    """
    height = event.drop_height if event.drop_height > 0.0 else None
    return DropScene(event.restitution, height, event.cluster_tolerance, event.round_sides)


@dataclass
class LastRun:
    """What bags leave to the next run."""

    # where the present mesh of each part lies, the least recently used part first
    parts: dict[str, RecordedMesh] = field(default_factory=dict)
    # jobs that were accepted and not heard of again
    unfinished: dict[str, JobEvent] = field(default_factory=dict)
    # the last result of each of the parts; nothing is going to refine it any more
    results: dict[str, PoseStatistics] = field(default_factory=dict)
    # bags not all of which could be read, and the first reason
    problems: dict[Path, str] = field(default_factory=dict)
    _meshes: CurrentMeshes = field(default_factory=CurrentMeshes)
    _latched: dict[str, tuple[Path, RawMessage]] = field(default_factory=dict)

    def take(self, run: str, bag: Path, message: RawMessage) -> None:
        """Take in the next message; of a mesh only where it is."""
        kind, data = message.type_name, message.data
        if kind == PART_MESH:
            request = request_of_part_bytes(data)
            self._meshes.note_mesh(request.part_id, RecordedMesh(
                place_of(run, message), request.restitution, request.drop_height))
        elif kind == POSE_STATISTICS and message.topic.endswith("/pose_statistics"):
            part_id, digest = _part_and_digest(message)
            if _says_forgotten(message):
                self._forget(part_id)
                return
            self._meshes.note_result(part_id, digest)
            self._latched[part_id] = bag, message
        elif kind == POSE_STATISTICS:
            self._meshes.note_use(_part_and_digest(message)[0])
        elif kind == JOB_EVENT:
            self._take_event(read_recorded(message, JobEvent))

    def conclude(self, most_parts: int) -> None:
        """Find the parts and their results, once everything was taken in."""
        present = self._meshes.present()
        self.parts = dict(list(present.items())[max(0, len(present) - most_parts):])
        for part_id in self.parts.keys() & self._latched.keys():
            bag, message = self._latched[part_id]
            try:
                self.results[part_id] = _result(message)
            except Exception as error:  # the bindings raise what they like
                self.note(bag, error)
        self._latched.clear()

    def note(self, bag: Path, error: Exception) -> None:
        """Something in a bag cannot be read."""
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        self.problems.setdefault(bag, reason)

    def _forget(self, part_id: str) -> None:
        self._meshes.forget(part_id)
        self._latched.pop(part_id, None)

    def _take_event(self, event: JobEvent) -> None:
        if event.event == JobEvent.PART_FORGOTTEN:
            self._forget(event.part_id)
        elif event.event == PART_RESTORED:
            self._meshes.note_restored(event.part_id, RecordedMesh(
                place_from(event.message), event.restitution, event.drop_height,
                event.part_digest))
        elif event.event in (JobEvent.QUEUED, JobEvent.RUNNING):
            scene_of(event)
            self.unfinished[event.job_id] = event
            if not event.refinement:
                self._meshes.note_use(event.part_id)
        elif event.event in (JobEvent.DONE, JobEvent.CANCELLED, JobEvent.FAILED):
            self.unfinished.pop(event.job_id, None)


def _says_forgotten(recorded: RawMessage) -> bool:
    """Whether a recorded result is the last word about its part; looked at once it may be."""
    return FORGOTTEN.encode() in recorded.data and is_farewell(
        read_recorded(recorded, PoseStatistics))


def _part_and_digest(recorded: RawMessage) -> tuple[str, str]:
    if is_of_today(recorded):
        with suppress(NotPlainCdrError):  # another encapsulation
            return part_and_digest_of(recorded.data)
    message = read_recorded(recorded, PoseStatistics)
    return message.part_id, message.part_digest


def _result(recorded: RawMessage) -> PoseStatistics:
    """A recorded result that can be gone on with."""
    message = read_recorded(recorded, PoseStatistics)
    if not message.revision < MOST_REVISION:
        raise RequestError("a revision below 2^63", f"{message.revision}", "estimate it again")
    if not all(pose.index < MOST_INDEX for pose in message.poses):
        raise RequestError(f"pose indices below {MOST_INDEX}", "a larger one",
                           "estimate it again")
    message.final = True
    if not is_of_today(recorded):
        message.version = ""  # it lacks what results say today: only its number is gone on with
    return message


def last_run(bags: Mapping[str, Path], most_parts: int) -> LastRun:
    """Read runs in order; what cannot be read is left out and named.

    `bags`: by what the runs are called inside, oldest first; `most_parts`: how many of the parts
    are wanted, the most recently used ones.
    """
    found = LastRun()
    for run, bag in bags.items():
        try:
            for message in raw_messages(bag):
                try:
                    found.take(run, bag, message)
                except Exception as error:  # of the bindings, about other versions and damage
                    found.note(bag, error)
        except Exception as error:  # of the disk, or of a file that is no bag
            found.note(bag, error)
    found.conclude(most_parts)
    return found
