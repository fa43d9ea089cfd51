"""A node that starts goes on with what the last run left, or puts on record that it does not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import NamedTuple

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ...errors import PoseStatsError, RequestError
from ...records import Part
from ..diagnostics import Refusals
from ..jobs import Job, JobRequest, Jobs, State
from ..jobs.job_reports import job_event
from ..messages.part_messages import request_of_part_bytes
from ..messages.times import now, time_message
from ..parts.mesh_queue import MeshQueue
from ..parts.part_builder import NotBuiltError
from ..parts.part_requests import named, plain
from ..parts.part_store import KnownPart, PartStore
from ..parts.result_store import ResultStore
from ..recorder import JOB_EVENTS, POSE_STATISTICS
from ..settings import Settings
from .current_meshes import RecordedMesh
from .last_run import PART_RESTORED, LastRun, scene_of
from .places import place_text, read_at

INTERRUPTED = "the node ended before the simulation did"


def end_unfinished_jobs(run: LastRun, settings: Settings, jobs: Jobs,
                        say: Callable[[str], object]) -> list[tuple[str, bytes]]:
    """End simulations that the last run did not end as cancelled, and say so.

    Returns what is to be recorded of that.
    """
    interrupted = [_interrupted_job(event, settings) for event in run.unfinished.values()]
    for job in interrupted:
        say(f"{plain(job.job_id)}: CANCELLED: {job.message}")
    jobs.add_ended(interrupted)
    return [(JOB_EVENTS, serialize_message(job_event(job, JobEvent.CANCELLED, job.message)))
            for job in interrupted]


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


class RestoredPart(NamedTuple):
    """A part of the last run on its way into this one."""

    part_id: str
    mesh: RecordedMesh  # where its mesh lies
    # what was latched for it, under the present names of plate and frame
    last: PoseStatistics | None
    holds: bool  # whether that still is a result of this mesh in the present scene
    changed: bool  # whether something of it is not as it was recorded

    def records(self) -> Iterator[tuple[str, bytes]]:
        """What this run's bag has to say of it; the mesh itself stays where it is."""
        event = JobEvent(event=PART_RESTORED, part_id=self.part_id, part_digest=self.mesh.digest,
                         restitution=self.mesh.restitution, drop_height=self.mesh.drop_height,
                         message=place_text(self.mesh.place))
        event.header.stamp = time_message(now())
        yield JOB_EVENTS, serialize_message(event)
        if self.holds:
            yield POSE_STATISTICS, serialize_message(self.last)


def parts_to_restore(run: LastRun, results: ResultStore) -> list[RestoredPart]:
    """The parts of the last run, with what still holds of their results."""
    found = []
    for part_id, mesh in run.parts.items():
        recorded = run.results.get(part_id)
        last = None if recorded is None else results.relabel(recorded)
        holds = (last is not None and last.part_digest == mesh.digest
                 and results.holds(last, (mesh.restitution, mesh.drop_height)))
        found.append(RestoredPart(part_id, mesh, last, holds,
                                  not holds or last is not recorded))
    return found


def restore_parts(coming: Sequence[RestoredPart], log_directory: Path, results: ResultStore,
                  mesh_queue: MeshQueue, refusals: Refusals) -> list[Future[KnownPart]]:
    """Begin to make the parts of the last run known; each mesh is read when its turn comes."""
    futures = []
    for part in coming:
        mesh = part.mesh
        results.parts.meshes.count_as_recorded((part.part_id, mesh.digest), (
            mesh.restitution, mesh.drop_height), mesh.place.run)
        futures.append(mesh_queue.put_later(
            partial(_restore_part, part, log_directory, results), large=True))  # it may be
        refusals.watch_mesh(partial(_source, part.part_id), futures[-1])
    return futures


def records_to_come(parts: Sequence[RestoredPart],
                    store: PartStore) -> Iterator[tuple[str, bytes]]:
    """What the bag has to say again of parts of the last run that are still on their way."""
    for part in parts:
        if (part.part_id, part.mesh.digest) in store.meshes.coming and (
                store.current(part.part_id) is None):
            yield from part.records()


def _restore_part(part: RestoredPart, log_directory: Path, results: ResultStore) -> KnownPart:
    """Make a part known, unless a newer mesh of its name has come meanwhile.

    One that cannot be made known is not tried again by later runs.
    """
    try:
        request = request_of_part_bytes(read_at(log_directory, part.mesh.place))
        return results.take_part(request, part.last, recorded=part.holds, newest=False)
    except NotBuiltError:  # since the node ends, say: the next run tries it again
        raise
    except PoseStatsError:
        if results.parts.current(part.part_id) is None:
            results.parts.record_forgotten(part.part_id, part.mesh.digest, now())
        raise
    finally:
        results.parts.meshes.coming.discard((part.part_id, part.mesh.digest))


def _source(part_id: str) -> str:
    return f"restored part{named(part_id)}"
