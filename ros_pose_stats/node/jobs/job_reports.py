"""What happens to drop simulations is kept, goes on record, to late joiners and to goals."""

import math
import threading
import time
from contextlib import suppress

from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import DropRecords, JobEvent, PoseStatistics

from ...core.records import PoseStatistics as Statistics
from ...core.simulation.drops import DropChunk
from ..equipment import NOT_RECORDED, Equipment
from ..messages import part_messages, statistics_messages, times
from ..parts.known_part import KnownPart
from ..parts.registry import PartRegistry
from ..recorder import ANSWERS, DROP_RECORDS, JOB_EVENTS
from ..state import Change
from .run import Job, JobListener, State as JobState

KEPT = 1000  # finished jobs that can still be asked for
MOST_ANSWER_BYTES = (
    256 * 2**20
)  # of the results of ended jobs; older ones are in the bag only
SECONDS_BETWEEN = 1.0  # a running job is kept as far as it is this often
INTERRUPTED = "the node ended before the simulation did"


def job_event(job: Job, event: int | None = None) -> JobEvent:
    """The record of something that happens to a job; without an event of how it is now."""
    request = job.request
    scene = job.request.scene
    part = job.find_part()
    snapshot = job.snapshot  # of which the queue's thread may let go meanwhile
    height = scene.drop_height if snapshot is None else snapshot.drop_height
    report = JobEvent(
        event=int(job.state if event is None else event),
        job_id=job.job_id,
        part_id=job.part_id,
        message=job.message,
        refinement=request.refinement,
        max_seconds=request.max_seconds,
        drops=request.drops,
        drops_done=job.drops_done,
        seed=job.seed,
        target_error=request.target_error,
        restitution=float(scene.restitution),
        cluster_tolerance=float(scene.cluster_tolerance),
        round_sides=scene.round_sides,
        drop_height=math.nan if height is None else float(height),
        part_digest="" if part is None else part.digest,
    )
    report.header.stamp = times.time_message(times.now())
    return report


def acceptance(job_id: str) -> tuple[str, int, str]:
    """What orders jobs as they were accepted."""
    return job_id.rpartition("_")[0], len(job_id), job_id


def job_change(event: JobEvent, answer: bytes = b"") -> Change:
    """What the state keeps of a job: the last that happened to it, and what was done."""
    return Change(
        "jobs",
        event.job_id,
        (event.job_id, int(event.event), serialize_message(event), answer),
    )


class JobReports(JobListener):
    """Keeps and records what happens to jobs of drops; says the end of each in one line."""

    def __init__(self, equipment: Equipment, parts: PartRegistry) -> None:
        self._equipment = equipment
        self._parts = parts
        self._recorder = equipment.recorder
        self._state = equipment.state
        self._log = equipment.node.get_logger()
        self._interims: dict[str, tuple[Statistics, PoseStatistics]] = {}
        self._stored_at = 0.0
        self.ends: dict[
            str, JobEvent
        ] = {}  # of the newest jobs that have ended, oldest first
        self._answers: dict[
            str, int
        ] = {}  # bytes of their results, as far as these are kept
        self._lock = threading.Lock()

    def restore(self) -> None:
        """Know the jobs of earlier runs again; what had not ended is cancelled."""
        rows: list[tuple[JobEvent, bytes]] = []
        for _, _, event, answer in self._state.rows("jobs"):
            with suppress(
                Exception
            ):  # of the bindings; the checksum was right: it is an old one
                rows.append((deserialize_message(event, JobEvent), answer))
        cancelled = []
        for event, answer in sorted(rows, key=lambda row: acceptance(row[0].job_id)):
            if event.event < JobEvent.DONE:
                event.event = JobEvent.CANCELLED
                event.message = INTERRUPTED
                self._state.put(job_change(event, answer))
                cancelled.append(event)
            self._note_end(event, len(answer))
        self._state.commit()
        for event in cancelled:
            self._recorder.record(JOB_EVENTS, serialize_message(event))
            self._log.warning(f"{event.job_id}: CANCELLED: {INTERRUPTED}")

    def queued(self, job: Job) -> bool:
        """Keep the acceptance, on the disk before anybody is told of it, and put it on record."""
        event = job_event(job, JobEvent.QUEUED)
        is_stored = self._state.commit(self._state.put(job_change(event)))
        part = self._part_of(job)
        if part is not None:
            part.introduce()
        return self._recorder.record(JOB_EVENTS, serialize_message(event)) and is_stored

    def started(self, job: Job) -> None:
        """Put the start on record."""
        self._recorder.record(
            JOB_EVENTS, serialize_message(job_event(job, JobEvent.RUNNING))
        )

    def progressed(self, job: Job) -> None:
        """Show late joiners how far it is, and keep that, now and then."""
        snapshot = job.snapshot
        now = time.monotonic()
        part = self._part_of(job)
        if part is None and job.request.refinement:
            job.cancel_reason = (
                job.cancel_reason or "the part was forgotten or has changed"
            )
        if snapshot is None or not snapshot.drops > snapshot.unsettled:
            return
        if now - self._stored_at >= SECONDS_BETWEEN:
            self._stored_at = now
            self._state.put(
                job_change(
                    job_event(job, JobEvent.RUNNING),
                    serialize_message(self.interim(job, snapshot)),
                )
            )
        if part is not None and part.is_due(job.request.scene):
            part.offer_result(job.request.scene, self.interim(job, snapshot))

    def dropped(self, job: Job, chunk: DropChunk) -> None:
        """Put single drops on record."""
        outcomes = chunk.outcomes
        flat = part_messages.flat
        record = DropRecords(
            job_id=job.job_id,
            part_digest=job.part.result().digest,
            first_drop=chunk.first,
            start_down=flat(chunk.downs, "f"),
            pose_index=flat(outcomes.pose, "i"),
            impacts=flat(outcomes.impacts, "I"),
            seconds=flat(outcomes.seconds, "f"),
            energy_left=flat(outcomes.energy_left, "f"),
            stopped_at_trap=True,
        )
        record.header.stamp = times.time_message(times.now())
        self._recorder.record(DROP_RECORDS, serialize_message(record))

    def ended(self, job: Job, state: JobState) -> None:
        """Keep the end and its result, put both on record, and latch the result."""
        part = self._part_of(job) or job.find_part()
        event = job_event(job, state)
        answer = None
        data = b""
        if job.snapshot is not None and part is not None:
            answer = part.number_result(job.snapshot, job.settings, job.job_id)
            if not job.recorded:
                answer = statistics_messages.with_warning(
                    answer, NOT_RECORDED.format("its acceptance could not be")
                )
            data = serialize_message(answer)
        change = job_change(event, data)
        recorded = self._state.commit(self._state.put(change))
        if answer is not None and part is not None:
            answer = part.record(ANSWERS, answer)
        recorded = (
            self._recorder.record(JOB_EVENTS, serialize_message(event)) and recorded
        )
        if answer is None and not (recorded and job.recorded):
            job.message = event.message = (
                f"{job.message} {self._equipment.not_recorded()}".strip()
            )
        elif answer is not None:
            answer = answer if recorded else self._equipment.warn_unrecorded(answer)
            data = serialize_message(answer)
        if job_change(event, data) != change:  # warnings have come since
            self._state.put(job_change(event, data))
        self._note_end(event, len(data))
        current = self._part_of(job)
        if (
            answer is not None
            and current is not None
            and answer.drops > answer.unsettled
        ):
            current.offer_result(job.request.scene, answer)
        self._log.info(
            f"{job.job_id}: {state.name} after {job.drops_done} of "
            f"{job.request.drops} drops of '{job.part_id}'"
            + (f": {job.message}" if job.message else "")
        )

    def _note_end(self, event: JobEvent, size: int) -> None:
        """Let the job be asked for that has ended, and forget the oldest beyond the bounds."""
        with self._lock:
            self.ends[event.job_id] = event
            if size:
                self._answers[event.job_id] = size
            if len(self.ends) > KEPT:
                oldest = next(iter(self.ends))
                del self.ends[oldest]
                self._answers.pop(oldest, None)
                self._state.put(Change("jobs", oldest, None))
            while (
                sum(self._answers.values()) > MOST_ANSWER_BYTES
                and len(self._answers) > 1
            ):
                oldest = next(iter(self._answers))
                del self._answers[oldest]
                row = self._state.get("jobs", oldest)
                if row is not None:
                    self._state.put(Change("jobs", oldest, (*row[:3], b"")))

    def interim(self, job: Job, snapshot: Statistics) -> PoseStatistics:
        """The message of a running job's statistics so far, made once a snapshot."""
        interim = self._interims.get(job.job_id)
        if interim is not None and interim[0] is snapshot:
            return interim[1]
        part = self._part_of(job) or job.find_part()
        if part is None:  # has ended this moment
            return PoseStatistics()
        message = part.number_result(snapshot, job.settings, job.job_id, final=False)
        self._interims = {job.job_id: (snapshot, message)}
        return message

    def answer_of(self, job_id: str, job: Job | None = None) -> PoseStatistics:
        """What a job has to show, or had in the end; empty before the first drops."""
        snapshot = None if job is None else job.snapshot
        if job is not None and not job.state.ended:
            return PoseStatistics() if snapshot is None else self.interim(job, snapshot)
        row = self._state.get("jobs", job_id)
        if not (row and row[3]):
            return PoseStatistics()
        result = deserialize_message(row[3], PoseStatistics)
        result.final = True  # of a job that a kill ended it was kept as not final
        return result

    def _part_of(self, job: Job) -> KnownPart | None:
        """The current part of the name, as long as it is the mesh that the job drops."""
        part = job.find_part()
        if part is None:
            return None
        current = self._parts.current(part.part_id)
        is_of_job = current is not None and current.digest == part.digest
        return current if is_of_job else None
