"""What happens to drop simulations goes on record, to late joiners and to goals."""

from __future__ import annotations

import threading
from array import array
from collections import deque
from collections.abc import Callable

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import DropRecords, JobEvent, PoseStatistics

from ...records import PoseStatistics as Statistics
from ...simulation.drops import DropChunk
from ..messages.times import now, time_message
from ..parts.announcer import NOT_RECORDED
from ..parts.part_store import KnownPart
from ..parts.result_store import ResultStore
from ..recorder import DROP_RECORDS, JOB_EVENTS, Recorder
from . import KEPT, Job, State

MOST_ANSWER_BYTES = 256 * 2**20
"""Of the results of ended jobs that are kept; older ones are in the bag only."""


def job_event(job: Job, event: int, message: str = "") -> JobEvent:
    """The record of something that happened to a job; a pure function but for the time."""
    request = job.request
    found = JobEvent(event=event)
    found.header.stamp = time_message(now())
    found.job_id, found.part_id, found.message = job.job_id, job.part_id, message
    found.refinement = request.refinement
    found.drops, found.drops_done, found.seed = request.drops, job.drops_done, job.seed
    found.restitution = float(request.scene.restitution)
    found.cluster_tolerance = float(request.scene.cluster_tolerance)
    found.round_sides = request.scene.round_sides
    found.target_error, found.max_seconds = request.target_error, request.max_seconds
    found.drop_height = float("nan") if request.scene.drop_height is None else float(
        request.scene.drop_height)
    part, snapshot = job.built(), job.snapshot
    if part is not None:
        found.part_digest = part.digest
    if snapshot is not None:
        found.drop_height = snapshot.drop_height
    return found


def drop_records(job: Job, digest: str, chunk: DropChunk) -> DropRecords:
    """The record of single drops; a pure function but for the time."""
    found = DropRecords(job_id=job.job_id, part_digest=digest, first_drop=chunk.first,
                        stopped_at_trap=True)
    found.header.stamp = time_message(now())
    outcomes = chunk.outcomes
    found.start_down = array("f", chunk.downs.astype(np.float32).tobytes())
    found.pose_index = array("i", outcomes.pose.astype(np.int32).tobytes())
    found.impacts = array("I", outcomes.impacts.astype(np.uint32).tobytes())
    found.seconds = array("f", outcomes.seconds.astype(np.float32).tobytes())
    found.energy_left = array("f", outcomes.energy_left.astype(np.float32).tobytes())
    return found


class JobReports:
    """The listener of the job queue; says the end of each job in one line."""

    def __init__(self, results: ResultStore, recorder: Recorder,
                 say: Callable[[str], object]) -> None:
        self._results = results
        self._recorder = recorder
        self._say = say
        self._unfinished: dict[str, tuple[JobEvent, int]] = {}
        self._recording = threading.RLock()
        self._interims: dict[str, tuple[Statistics, PoseStatistics]] = {}
        self._answered: deque[Job] = deque()
        self._answer_bytes = 0
        self.on_progress: Callable[[Job], object] = lambda job: None
        self.on_started: Callable[[Job], object] = lambda job: None
        self.on_end: Callable[[Job], object] = lambda job: None

    def queued(self, job: Job) -> bool:
        """Put the acceptance on record before it is told.

        Nobody is told of what the node starts by itself, so that does not wait for the disk.
        """
        return self._record_unfinished(job_event(job, JobEvent.QUEUED), durable=job.asked)

    def joined(self, job: Job) -> bool:
        """Have what is on record of a job on disk, since a client is told of it now."""
        return self._recorder.sync()

    def started(self, job: Job) -> None:
        """Put the start on record."""
        self._record_unfinished(job_event(job, JobEvent.RUNNING), durable=False)
        self.on_started(job)

    def progressed(self, job: Job) -> None:
        """Tell goals, and late joiners now and then."""
        self.on_progress(job)
        snapshot, known = job.snapshot, self._part_of(job)
        if snapshot is None or known is None or not snapshot.drops > snapshot.unsettled:
            return
        if self._results.is_due(known, job.request.scene):
            self._results.offer_results(known, job.request.scene,
                                        [self.interim(job, snapshot)])

    def dropped(self, job: Job, chunk: DropChunk) -> None:
        """Put single drops on record."""
        message = drop_records(job, job.part.result().digest, chunk)
        self._recorder.record(DROP_RECORDS, serialize_message(message))

    def ended(self, job: Job, state: State) -> None:
        """Put the end and its result on record, and latch the result."""
        message = self._recorded_answer(job)
        with self._recording:  # until the end is on record, the acceptance has to be
            self._unfinished.pop(job.job_id, None)
            recorded = self._record(job_event(job, int(state), job.message),
                                    durable=job.asked or state is State.DONE)
        if message is not None:
            if not recorded:
                message = self._results.announcer.warn_unrecorded(message)
            self._latch(job, message)
            self._remember(job, serialize_message(message))
        elif not (recorded and job.recorded):  # there is no result that could say so
            said = self._warnings(job) or (self._results.announcer.not_recorded(),)
            job.message = " ".join(filter(None, (job.message, *said)))
        self._say(f"{job.job_id}: {state.name} after {job.drops_done} of "
                  f"{job.request.drops} drops of '{job.part_id}'"
                  + (f": {job.message}" if job.message else ""))

    def told(self, job: Job) -> None:
        """Tell the goals."""
        self.on_end(job)

    def record_again(self) -> None:
        """Put on record again how far unfinished jobs are, where the bag may not have it."""
        with self._recording:
            for event, mark in list(self._unfinished.values()):
                if mark < self._recorder.trusted_from:
                    self._record_unfinished(event, durable=False)

    def _record_unfinished(self, event: JobEvent, *, durable: bool) -> bool:
        """Put on record that a job waits or runs, and keep that until its end."""
        with self._recording:
            mark = self._recorder.mark
            recorded = self._record(event, durable=durable)
            self._unfinished[event.job_id] = event, mark if recorded else -1
            return recorded

    def _recorded_answer(self, job: Job) -> PoseStatistics | None:
        """The message of what a job has done; it is durable once the job's end is."""
        found, known = job.snapshot, self._known_or_own(job)
        if found is None or known is None:
            return None
        message = self._results.number_result(
            known, found, job.settings, job.job_id, True, self._warnings(job))
        return self._results.announcer.record_answer(message, durable=False)

    def _latch(self, job: Job, message: PoseStatistics) -> None:
        current = self._part_of(job)
        if current is not None and message.drops > message.unsettled:
            self._results.offer_results(current, job.request.scene, [message])
            if job.request.hybrid:
                self._results.keep_refinement(current, message, job.request.scene)

    def _remember(self, job: Job, answer: bytes) -> None:
        """Keep the answers of the newest jobs, as far as there is room."""
        job.answer = answer
        self._answered.append(job)
        self._answer_bytes += len(answer)
        while (self._answer_bytes > MOST_ANSWER_BYTES or len(self._answered) > KEPT) and len(
                self._answered) > 1:
            oldest = self._answered.popleft()
            self._answer_bytes -= len(oldest.answer)
            oldest.answer = b""

    def interim(self, job: Job, snapshot: Statistics) -> PoseStatistics:
        """The message of a running job's statistics so far, made once a snapshot."""
        made = self._interims.get(job.job_id)
        if made is not None and made[0] is snapshot:
            return made[1]
        known = self._known_or_own(job)
        if known is None:  # has ended this moment
            return PoseStatistics()
        message = self._results.number_result(known, snapshot, job.settings, job.job_id, False)
        self._interims = {job.job_id: (snapshot, message)}
        return message

    def current_answer(self, job: Job) -> PoseStatistics:
        """What a job has to show at this time; empty before the first drops."""
        snapshot = job.snapshot
        if job.answer:
            return deserialize_message(job.answer, PoseStatistics)
        return PoseStatistics() if snapshot is None else self.interim(job, snapshot)

    def _part_of(self, job: Job) -> KnownPart | None:
        """The known part, as long as it is the part that the job drops."""
        part = job.built()
        if part is None:
            return None
        known = self._results.parts.current(part.part_id)
        return known if known is not None and known.part.digest == part.digest else None

    def _known_or_own(self, job: Job) -> KnownPart | None:
        part = job.built()
        known = self._part_of(job)
        return KnownPart(part, b"", (-1.0, -1.0)) if known is None and part is not None else known

    def _warnings(self, job: Job) -> tuple[str, ...]:
        return () if job.recorded else (NOT_RECORDED.format("its acceptance could not be"),)

    def _record(self, event: JobEvent, *, durable: bool) -> bool:
        return self._recorder.record(JOB_EVENTS, serialize_message(event), durable=durable)
