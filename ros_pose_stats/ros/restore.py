"""Parts and results of the last run, out of its bag."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ..errors import RequestError
from ..recording.raw_reader import raw_messages
from ..records import DropScene, Part
from .jobs import Job, JobRequest, State
from .mesh_views import NotPlainCdrError, part_id_of
from .part_messages import request_of_part_bytes
from .part_requests import PartRequest

PART_MESH = "ros_pose_stats_msgs/msg/PartMesh"
POSE_STATISTICS = "ros_pose_stats_msgs/msg/PoseStatistics"
JOB_EVENT = "ros_pose_stats_msgs/msg/JobEvent"

INTERRUPTED = "the node ended before the simulation did"


@dataclass
class LastRun:
    """What a bag leaves to the next run.

    Attributes
    ----------
    parts : dict of str to PartRequest
        The last mesh of each part, in the order in which they came.
    unfinished : dict of str to JobEvent
        Jobs that were accepted and not heard of again.
    """

    parts: dict[str, PartRequest] = field(default_factory=dict)
    _latched: dict[str, bytes] = field(default_factory=dict)
    unfinished: dict[str, JobEvent] = field(default_factory=dict)

    def take(self, topic: str, kind: str, data: bytes) -> None:
        """Take in the next message."""
        if kind == PART_MESH:
            request = request_of_part_bytes(data)
            self.parts.pop(request.part_id, None)
            self.parts[request.part_id] = request
        elif kind == POSE_STATISTICS and topic.endswith("/pose_statistics"):
            self._latched[_part_id(data)] = data
        elif kind == JOB_EVENT:
            self._take_event(deserialize_message(data, JobEvent))

    def latched(self, part_id: str) -> PoseStatistics | None:
        """The last result of a part."""
        data = self._latched.get(part_id)
        return None if data is None else deserialize_message(data, PoseStatistics)

    def _take_event(self, event: JobEvent) -> None:
        if event.event == JobEvent.PART_FORGOTTEN:
            self.parts.pop(event.part_id, None)
            self._latched.pop(event.part_id, None)
        elif event.event in (JobEvent.QUEUED, JobEvent.RUNNING):
            self.unfinished[event.job_id] = event
        else:
            self.unfinished.pop(event.job_id, None)


def _part_id(data: bytes) -> str:
    try:
        return part_id_of(data)
    except NotPlainCdrError:  # another encapsulation
        return str(deserialize_message(data, PoseStatistics).part_id)


def last_run(bags: Iterable[Path]) -> LastRun:
    """Read bags in order.

    Raises
    ------
    OSError
        If one cannot be read.
    """
    found = LastRun()
    for bag in bags:
        for message in raw_messages(bag):
            found.take(message.topic, message.type_name, message.data)
    return found


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
