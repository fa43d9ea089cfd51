"""Parts and results of the last run, out of its bag."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ...errors import PoseStatsError, RequestError
from ...recording.reader.raw_reader import RawMessage, raw_messages
from ..messages.mesh_views import NotPlainCdrError, part_and_digest_of
from ..messages.part_messages import request_of_part_bytes
from ..parts.part_requests import PartRequest
from .current_meshes import CurrentMeshes, Place
from .interrupted import scene_of

PART_MESH = "ros_pose_stats_msgs/msg/PartMesh"
POSE_STATISTICS = "ros_pose_stats_msgs/msg/PoseStatistics"
JOB_EVENT = "ros_pose_stats_msgs/msg/JobEvent"

MOST_REVISION = 2**63
"""Results are numbered from 1; the next ones must fit into the message too."""

MOST_INDEX = 2**31 - 1
"""Of a pose, as markers can carry it."""


@dataclass
class LastRun:
    """What bags leave to the next run.

    Attributes
    ----------
    parts : dict of str to PartRequest
        The present mesh of each part, in the order in which they became that.
    unfinished : dict of str to JobEvent
        Jobs that were accepted and not heard of again.
    results : dict of str to PoseStatistics
        The last result of each of the parts; nothing is going to refine it any more.
    meshes : CurrentMeshes
        What tells the present ones.
    problems : dict of Path to str
        Bags not all of which could be read, and the first reason.
    """

    parts: dict[str, PartRequest] = field(default_factory=dict)
    unfinished: dict[str, JobEvent] = field(default_factory=dict)
    results: dict[str, PoseStatistics] = field(default_factory=dict)
    meshes: CurrentMeshes = field(default_factory=CurrentMeshes)
    problems: dict[Path, str] = field(default_factory=dict)
    _latched: dict[str, tuple[Path, bytes]] = field(default_factory=dict)

    def take(self, bag: Path, place: Place, message: RawMessage) -> None:
        """Take in the next message."""
        kind, data = message.type_name, message.data
        if kind == PART_MESH:
            self.meshes.note_mesh(request_of_part_bytes(data), place)
        elif kind == POSE_STATISTICS and message.topic.endswith("/pose_statistics"):
            part_id, digest = _part_and_digest(data)
            self.meshes.note_result(part_id, digest)
            self._latched[part_id] = bag, data
        elif kind == JOB_EVENT:
            self._take_event(deserialize_message(data, JobEvent))

    def latched(self, part_id: str) -> PoseStatistics | None:
        """The last result of a part."""
        return self.results.get(part_id)

    def conclude(self, again: Iterator[tuple[Place, PartRequest]]) -> None:
        """Find the parts and their results, once everything was taken in."""
        self.parts = self.meshes.present(again)
        for part_id in self.parts.keys() & self._latched.keys():
            bag, data = self._latched[part_id]
            try:
                self.results[part_id] = _result(data)
            except Exception as error:  # the bindings raise what they like
                self.note(bag, error)

    def note(self, bag: Path, error: Exception) -> None:
        """Something in a bag cannot be read."""
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        self.problems.setdefault(bag, reason)

    def _take_event(self, event: JobEvent) -> None:
        if event.event == JobEvent.PART_FORGOTTEN:
            self.meshes.forget(event.part_id)
            self._latched.pop(event.part_id, None)
        elif event.event in (JobEvent.QUEUED, JobEvent.RUNNING):
            scene_of(event)
            self.unfinished[event.job_id] = event
        else:
            self.unfinished.pop(event.job_id, None)


def _part_and_digest(data: bytes) -> tuple[str, str]:
    try:
        return part_and_digest_of(data)
    except NotPlainCdrError:  # another encapsulation
        message = deserialize_message(data, PoseStatistics)
        return message.part_id, message.part_digest


def _result(data: bytes) -> PoseStatistics:
    """A recorded result that can be gone on with."""
    message = deserialize_message(data, PoseStatistics)
    if not message.revision < MOST_REVISION:
        raise RequestError("a revision below 2^63", f"{message.revision}", "estimate it again")
    if not all(pose.index < MOST_INDEX for pose in message.poses):
        raise RequestError(f"pose indices below {MOST_INDEX}", "a larger one",
                           "estimate it again")
    message.final = True
    return message


def last_run(bags: Sequence[Path]) -> LastRun:
    """Read bags in order; what cannot be read is left out and named."""
    found = LastRun()
    for place, bag, message in _messages(bags, found.note):
        try:
            found.take(bag, place, message)
        except Exception as error:  # of the bindings, about other versions and damage
            found.note(bag, error)
    found.conclude(_meshes(bags, found.note))
    return found


def _messages(bags: Sequence[Path], on_problem: Callable[[Path, Exception], object],
              ) -> Iterator[tuple[Place, Path, RawMessage]]:
    """All messages of bags, as far as the disk gives them."""
    for number, bag in enumerate(bags):
        try:
            for k, message in enumerate(raw_messages(bag)):
                yield Place(number, k), bag, message
        except Exception as error:
            on_problem(bag, error)


def _meshes(bags: Sequence[Path], on_problem: Callable[[Path, Exception], object],
            ) -> Iterator[tuple[Place, PartRequest]]:
    """All meshes that can be read, once more."""
    for place, bag, message in _messages(bags, on_problem):
        if message.type_name == PART_MESH:
            try:
                request = request_of_part_bytes(message.data)
            except PoseStatsError as error:
                on_problem(bag, error)
                continue
            yield place, request
