"""Parts and results of the last run, out of its bag."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ..errors import RequestError
from ..recording.raw_reader import raw_messages
from ..records import DropScene, Part
from .current_meshes import CurrentMeshes
from .jobs import Job, JobRequest, State
from .mesh_views import NotPlainCdrError, part_and_digest_of
from .part_messages import request_of_part_bytes
from .part_requests import PartRequest

PART_MESH = "ros_pose_stats_msgs/msg/PartMesh"
POSE_STATISTICS = "ros_pose_stats_msgs/msg/PoseStatistics"
JOB_EVENT = "ros_pose_stats_msgs/msg/JobEvent"

INTERRUPTED = "the node ended before the simulation did"


@dataclass
class LastRun:
    """What bags leave to the next run.

    Attributes
    ----------
    parts : dict of str to PartRequest
        The present mesh of each part, in the order in which they became that.
    unfinished : dict of str to JobEvent
        Jobs that were accepted and not heard of again.
    meshes : CurrentMeshes
        What tells the present ones.
    problems : dict of Path to str
        Bags that could not be read to their ends, and why.
    """

    parts: dict[str, PartRequest] = field(default_factory=dict)
    unfinished: dict[str, JobEvent] = field(default_factory=dict)
    meshes: CurrentMeshes = field(default_factory=CurrentMeshes)
    problems: dict[Path, str] = field(default_factory=dict)
    _latched: dict[str, bytes] = field(default_factory=dict)

    def take(self, topic: str, kind: str, data: bytes) -> None:
        """Take in the next message."""
        if kind == PART_MESH:
            self.meshes.note_mesh(request_of_part_bytes(data))
        elif kind == POSE_STATISTICS and topic.endswith("/pose_statistics"):
            part_id, digest = _part_and_digest(data)
            self.meshes.note_result(part_id, digest)
            self._latched[part_id] = data
        elif kind == JOB_EVENT:
            self._take_event(deserialize_message(data, JobEvent))

    def latched(self, part_id: str) -> PoseStatistics | None:
        """The last result of a part; nothing is going to refine it any more."""
        data = self._latched.get(part_id)
        if data is None:
            return None
        message = deserialize_message(data, PoseStatistics)
        message.final = True
        return message

    def _take_event(self, event: JobEvent) -> None:
        if event.event == JobEvent.PART_FORGOTTEN:
            self.meshes.forget(event.part_id)
            self._latched.pop(event.part_id, None)
        elif event.event in (JobEvent.QUEUED, JobEvent.RUNNING):
            self.unfinished[event.job_id] = event
        else:
            self.unfinished.pop(event.job_id, None)


def _part_and_digest(data: bytes) -> tuple[str, str]:
    try:
        return part_and_digest_of(data)
    except NotPlainCdrError:  # another encapsulation
        message = deserialize_message(data, PoseStatistics)
        return message.part_id, message.part_digest


def last_run(bags: Iterable[Path]) -> LastRun:
    """Read bags in order, as far as they can be read."""
    found = LastRun()
    bags = list(bags)
    for bag in bags:
        try:
            for message in raw_messages(bag):
                found.take(message.topic, message.type_name, message.data)
        except Exception as error:  # of the disk, or of the bindings about other versions
            found.problems[bag] = f"{type(error).__name__}: {error}"
    found.parts = found.meshes.present(_meshes(bag for bag in bags if bag not in found.problems))
    return found


def _meshes(bags: Iterable[Path]) -> Iterator[PartRequest]:
    """All meshes of bags that can be read, once more."""
    for bag in bags:
        for message in raw_messages(bag):
            if message.type_name == PART_MESH:
                yield request_of_part_bytes(message.data)


def interrupted_job(event: JobEvent, settings: Any) -> Job:
    """A job of the last run, as cancelled."""
    height = event.drop_height if event.drop_height > 0.0 else None
    scene = DropScene(event.restitution, height, event.cluster_tolerance)
    part: Future[Part] = Future()
    part.set_exception(RequestError("a part of this run", "one of the last",
                                    "start the simulation again"))
    request = JobRequest(event.part_id, b"", scene, event.drops, event.seed, event.target_error,
                         event.max_seconds, event.refinement)
    job = Job(event.job_id, request, part, event.seed, settings, State.CANCELLED,
              drops_done=event.drops_done, message=INTERRUPTED)
    job.finished.set()
    return job
