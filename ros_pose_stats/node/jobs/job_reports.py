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

"""What happens to drop simulations is stored, recorded, and shown to late joiners."""

import math
import threading
import time
from contextlib import suppress

from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import (
    Code,
    DropRecords,
    JobEvent,
    JobStatus,
    PoseStatistics,
)

from ...core import records
from ...core.simulation.drops import DropChunk
from ..equipment import Equipment, unrecorded_note
from ..messages import part_messages, statistics_messages, times
from ..parts.known_part import KnownPart
from ..parts.registry import PartRegistry
from ..recorder import ANSWERS, DROP_RECORDS, JOB_EVENTS
from ..state import Change
from .run import PART_GONE, Job, JobListener, State

MOST_ENDED = 1000  # finished jobs that can still be asked for
# of the results of ended jobs; older ones are in the bag only
MOST_ANSWER_BYTES = 256 * 2**20
SECONDS_BETWEEN = 1.0  # a running job is stored as far as it is this often
INTERRUPTED = "the node ended before the simulation did"


def job_event(job: Job, state: State | None = None) -> JobEvent:
    """The record of something that happens to a job; by default of how it is now."""
    request = job.request
    scene = request.scene
    part = job.find_part()
    snapshot = job.snapshot  # of which the queue's thread may let go meanwhile
    height = scene.drop_height if snapshot is None else snapshot.drop_height
    report = JobEvent(
        status=JobStatus(
            job_id=job.job_id,
            part_id=job.part_id,
            state=int(job.state if state is None else state),
            code=job.code,
            drops_done=job.drops_done,
            drops_total=request.drops,
        ),
        message=job.message,
        refinement=request.refinement,
        max_seconds=request.max_seconds,
        seed=job.seed,
        target_error=request.target_error,
        **{
            **vars(scene),
            "drop_height": math.nan if height is None else float(height),
        },
        part_digest="" if part is None else part.digest,
    )
    report.header.stamp = times.time_message(times.current_stamp())
    return report


def acceptance(job_id: str) -> tuple[str, int, str]:
    """What orders jobs as they were accepted."""
    return job_id.rpartition("_")[0], len(job_id), job_id


def job_change(event: JobEvent, answer: bytes = b"") -> Change:
    """What the state has of a job: the last that happened to it, and its result."""
    status = event.status
    return Change(
        "jobs",
        status.job_id,
        (status.job_id, int(status.state), serialize_message(event), answer),
    )


class JobReports(JobListener):
    """Stores and records what happens to jobs of drops; logs the end of each."""

    def __init__(self, equipment: Equipment, parts: PartRegistry) -> None:
        self._equipment = equipment
        self._parts = parts
        self._recorder = equipment.recorder
        self._state = equipment.state
        self._log = equipment.node.get_logger()
        self._interims: dict[str, tuple[records.PoseStatistics, PoseStatistics]] = {}
        self._stored_at = 0.0
        # of the newest jobs that have ended, oldest first
        self.ends: dict[str, JobEvent] = {}
        # bytes of their results, as far as the state has these
        self._answer_sizes: dict[str, int] = {}
        self._lock = threading.Lock()

    def restore(self) -> None:
        """Know the jobs of earlier runs again; what had not ended is cancelled."""
        rows: list[tuple[JobEvent, bytes]] = []
        for _, _, event, answer in self._state.rows("jobs"):
            # The checksum was right: what the bindings refuse is an old one.
            with suppress(Exception):
                rows.append((deserialize_message(event, JobEvent), answer))
        cancelled = []
        for event, answer in sorted(
            rows, key=lambda row: acceptance(row[0].status.job_id)
        ):
            if event.status.state < JobStatus.DONE:
                event.status.state = JobStatus.CANCELLED
                event.status.code = Code.CANCELLED
                event.message = INTERRUPTED
                self._state.put(job_change(event, answer))
                cancelled.append(event)
            self._note_end(event, len(answer))
        self._state.commit()
        for event in cancelled:
            self._recorder.record(JOB_EVENTS, serialize_message(event))
            self._log.warning(f"{event.status.job_id}: CANCELLED: {INTERRUPTED}")

    def queued(self, job: Job) -> bool:
        """Store the acceptance, on the disk before anybody hears of it; record it."""
        event = job_event(job, State.QUEUED)
        is_stored = self._state.commit(self._state.put(job_change(event)))
        return self._recorder.record(JOB_EVENTS, serialize_message(event)) and is_stored

    def started(self, job: Job) -> None:
        """Put the start on record, behind the mesh."""
        part = job.find_part()
        if part is not None:
            part.introduce()
        self._log.debug(f"{job.job_id}: RUNNING: drops of '{job.part_id}'")
        event = job_event(job, State.RUNNING)
        self._recorder.record(JOB_EVENTS, serialize_message(event))

    def progressed(self, job: Job) -> None:
        """Now and then show late joiners how far it is, and store that."""
        snapshot = job.snapshot
        now = time.monotonic()
        part = self._part_of(job)
        if part is None and job.request.refinement and not job.cancel_reason:
            job.cancel_reason = PART_GONE
        if snapshot is None or not snapshot.drops > snapshot.unsettled:
            return
        if now - self._stored_at >= SECONDS_BETWEEN:
            self._stored_at = now
            event = job_event(job, State.RUNNING)
            interim = serialize_message(self.interim(job, snapshot))
            self._state.put(job_change(event, interim))
        if part is not None and part.is_due(job.request.scene):
            part.offer_result(job.request.scene, self.interim(job, snapshot))

    def dropped(self, job: Job, chunk: DropChunk) -> None:
        """Put single drops on record."""
        outcomes = chunk.outcomes
        flat = part_messages.pack_array
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
            drawn=outcomes.drawn.tolist(),
        )
        record.header.stamp = times.time_message(times.current_stamp())
        self._recorder.record(DROP_RECORDS, serialize_message(record))

    def ended(self, job: Job, state: State) -> None:
        """Store the end and its result, record both, and latch the result."""
        part = self._part_of(job) or job.find_part()
        event = job_event(job, state)
        answer = None
        data = b""
        if job.snapshot is not None and part is not None:
            answer = part.results.number(job.snapshot, job.settings, job.job_id)
            if not job.is_recorded:
                answer = statistics_messages.with_warning(
                    answer, unrecorded_note("its acceptance could not be")
                )
            data = serialize_message(answer)
        change = job_change(event, data)
        is_recorded = self._state.commit(self._state.put(change))
        if answer is not None and part is not None:
            answer = part.record(ANSWERS, answer)
        if not self._recorder.record(JOB_EVENTS, serialize_message(event)):
            is_recorded = False
        if answer is not None:
            if not is_recorded:
                answer = self._equipment.warn_unrecorded(answer)
            is_recorded = statistics_messages.is_recorded(answer)
            data = serialize_message(answer)
        elif not (is_recorded and job.is_recorded):
            warning = self._equipment.not_recorded()
            job.message = event.message = f"{job.message} {warning}".strip()
        if state is State.DONE and not (is_recorded and job.is_recorded):
            job.code = event.status.code = Code.NOT_RECORDED
        final_change = job_change(event, data)
        if final_change != change:  # warnings have come since
            self._state.put(final_change)
        self._note_end(event, len(data))
        current = self._part_of(job)
        if (
            answer is not None
            and current is not None
            and answer.drops > answer.unsettled
        ):
            current.offer_result(job.request.scene, answer)
        line = (
            f"{job.job_id}: {state.name} after {job.drops_done} of "
            f"{job.request.drops} drops of '{job.part_id}'"
        )
        if job.message:
            line += f": {job.message}"
        self._log.info(line)

    def _note_end(self, event: JobEvent, size: int) -> None:
        """Let an ended job be asked for, and forget the oldest beyond the bounds."""
        with self._lock:
            self.ends[event.status.job_id] = event
            if size:
                self._answer_sizes[event.status.job_id] = size
            if len(self.ends) > MOST_ENDED:
                oldest = next(iter(self.ends))
                del self.ends[oldest]
                self._answer_sizes.pop(oldest, None)
                self._state.put(Change("jobs", oldest, None))
            sizes = self._answer_sizes
            while sum(sizes.values()) > MOST_ANSWER_BYTES and len(sizes) > 1:
                oldest = next(iter(sizes))
                del sizes[oldest]
                row = self._state.get("jobs", oldest)
                if row is not None:
                    self._state.put(Change("jobs", oldest, (*row[:3], b"")))

    def interim(self, job: Job, snapshot: records.PoseStatistics) -> PoseStatistics:
        """The message of a running job's statistics so far, made once a snapshot."""
        interim = self._interims.get(job.job_id)
        if interim is not None and interim[0] is snapshot:
            return interim[1]
        part = self._part_of(job) or job.find_part()
        if part is None:  # has ended this moment
            return PoseStatistics()
        message = part.results.number(snapshot, job.settings, job.job_id, False)
        self._interims = {job.job_id: (snapshot, message)}
        return message

    def answer_of(self, job_id: str, job: Job | None = None) -> PoseStatistics:
        """What a job has to show, or had in the end; empty before the first drops."""
        # Looked at before the state: a job lets go of it as it ends.
        snapshot = None if job is None else job.snapshot
        if job is not None and not job.state.ended:
            return PoseStatistics() if snapshot is None else self.interim(job, snapshot)
        row = self._state.get("jobs", job_id)
        if not (row and row[3]):
            return PoseStatistics()
        result = deserialize_message(row[3], PoseStatistics)
        result.final = True  # not so where a kill ended the job
        return result

    def _part_of(self, job: Job) -> KnownPart | None:
        """The current part of the name, as long as it is the mesh of the job."""
        part = job.find_part()
        if part is None:
            return None
        current = self._parts.current(part.part_id)
        if current is None or current.digest != part.digest:
            return None
        return current
