"""Simulations that the last run did not end."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

from ros_pose_stats_msgs.msg import JobEvent

from ...errors import RequestError
from ...records import DropScene, Part
from ..jobs import Job, JobRequest, State

INTERRUPTED = "the node ended before the simulation did"


def scene_of(event: JobEvent) -> DropScene:
    """The scene of a job.

    Raises
    ------
    RequestError
        If there is no such scene.
    """
    height = event.drop_height if event.drop_height > 0.0 else None
    return DropScene(event.restitution, height, event.cluster_tolerance)


def interrupted_job(event: JobEvent, settings: Any) -> Job:
    """A job of the last run, as cancelled."""
    part: Future[Part] = Future()
    part.set_exception(RequestError("a part of this run", "one of the last",
                                    "start the simulation again"))
    request = JobRequest(event.part_id, b"", scene_of(event), event.drops, event.seed,
                         event.target_error, event.max_seconds, event.refinement)
    job = Job(event.job_id, request, part, event.seed, settings, State.CANCELLED,
              drops_done=event.drops_done, message=INTERRUPTED)
    job.finished.set()
    return job
