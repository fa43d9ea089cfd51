"""A node that starts goes on with what the last run left, or puts on record that it does not."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent

from ...errors import RequestError
from ...records import Part
from ..diagnostics import Refusals
from ..jobs import Job, JobRequest, Jobs, State
from ..jobs.job_reports import job_event
from ..parts.mesh_queue import MeshQueue
from ..parts.part_builder import is_large
from ..parts.part_requests import plain
from ..parts.part_store import KnownPart
from ..parts.result_store import ResultStore
from ..recorder import JOB_EVENTS, Recorder
from ..settings import Settings
from .last_run import LastRun, scene_of

INTERRUPTED = "the node ended before the simulation did"


def end_unfinished_jobs(run: LastRun, settings: Settings, jobs: Jobs, recorder: Recorder,
                        say: Callable[[str], object]) -> None:
    """Put simulations that the last run did not end on record as cancelled, and say so."""
    interrupted = [_interrupted_job(event, settings) for event in run.unfinished.values()]
    for job in interrupted:
        event = job_event(job, JobEvent.CANCELLED, job.message)
        recorder.record(JOB_EVENTS, serialize_message(event), durable=True)
        say(f"{plain(job.job_id)}: CANCELLED: {job.message}")
    jobs.add_ended(interrupted)


def _interrupted_job(event: JobEvent, settings: Settings) -> Job:
    part: Future[Part] = Future()
    part.set_exception(RequestError("a part of this run", "one of the last",
                                    "start the simulation again"))
    request = JobRequest(event.part_id, b"", scene_of(event), event.drops, event.seed,
                         event.target_error, event.max_seconds, event.refinement)
    job = Job(event.job_id, request, part, event.seed, settings, State.CANCELLED,
              drops_done=event.drops_done, message=INTERRUPTED)
    job.finished.set()
    return job


def restore_parts(run: LastRun, results: ResultStore, mesh_queue: MeshQueue,
                  refusals: Refusals) -> list[Future[KnownPart]]:
    """Put the parts of the last run on record, and begin to make them known.

    Returns
    -------
    list of Future of KnownPart
        On their way, with their results.
    """
    coming = []
    for part_id, request in run.parts.items():
        last = results.take_over_part(request, run.results.get(part_id))
        coming.append(mesh_queue.put_later(partial(results.take_part, request, last),
                                           is_large(request)))
        refusals.watch_mesh(lambda: "restored part", coming[-1])
    return coming
