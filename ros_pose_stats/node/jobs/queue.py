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

"""A bounded queue of simulations: clients come first, refinements give way to them."""

import itertools
import secrets
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from typing import Any

from ros_pose_stats_msgs.msg import Code

from ...base.errors import PoseStatsError
from ...core.records import FlipStatistics, Part, PoseStatistics
from ..lanes import result_or_refusal
from ..messages.codes import BusyError, code_of, describe_error, refusal_at_end
from ..parts.known_part import KnownPart
from ..refusals import Health
from ..stop_signals import finish_within
from .run import (
    GAVE_WAY,
    PART_GONE,
    Job,
    JobListener,
    JobRequest,
    State,
    Stop,
    run_drops,
)

Run = Callable[[Job, Part, JobListener, Stop], PoseStatistics | FlipStatistics]
"""Computes what a job asks for, as `run_drops` does."""

# warnings that are the message of an end, and the code of that
CUT_SHORT = {"TIME_LIMIT": Code.TIMED_OUT, "TARGET_MISSED": Code.OK}
POLL_SECONDS = 0.02
# for what runs when the queue is closed; some parts are prepared for minutes
LAST_SECONDS = 0.6


class Jobs:
    """The queue, and the thread that works it off.

    Ids of jobs begin with `run_name`, so they are unique across restarts.
    """

    def __init__(
        self,
        run_name: str,
        listener: JobListener,
        say_failure: Callable[[str], object],
        run: Run = run_drops,
    ) -> None:
        self._run_name = run_name
        self.listener = listener
        self._say_failure = say_failure
        self._run = run
        self._numbers = itertools.count(1)
        # those that have not ended, in the order of their acceptance
        self._jobs: dict[str, Job] = {}
        self.running_job: Job | None = None
        self._accepting = threading.Lock()
        self._changing = threading.Lock()
        self._closing = ""
        self._pool = ThreadPoolExecutor(1, "jobs")

    def submit(
        self,
        request: JobRequest,
        part: Future[KnownPart],
        settings: Any,
        has_room: bool = False,
    ) -> Job:
        """Accept a simulation, or join the same in flight; raises BusyError.

        `has_room`: one that follows another of the same client is accepted in any case.
        """
        with self._accepting:  # acceptance goes on record one at a time
            with self._changing:
                for job in self._jobs.values():
                    if _is_twin(request, job):
                        return job
                if self._closing:
                    raise refusal_at_end()
                if not (request.refinement or has_room):
                    self._check_room(settings.max_queued_jobs)
            job = Job(
                f"{self._run_name}_{next(self._numbers):04d}",
                request,
                part,
                request.seed or secrets.randbits(32) or 1,
                settings,
            )
            job.is_recorded = self.listener.queued(job)
            with self._changing:
                self._jobs[job.job_id] = job
            self._pool.submit(self._run_next)
            return job

    def _check_room(self, most: int) -> None:
        """Refuse a client's job where as many wait as may, and one runs."""
        is_idle = self.running_job is None or self.running_job.state.ended
        if self.count_waiting()[0] >= most + is_idle:
            raise BusyError(
                f"at most {most} simulations waiting (parameter max_queued_jobs)",
                "a full queue",
                "wait, or cancel one",
            )

    def cancel(self, job_id: str, reason: str) -> None:
        """Ask a job to end; one that has ended stays as it is."""
        with self._changing:
            job = self._jobs.get(job_id)
            if job is None:
                return
            job.cancel_reason = job.cancel_reason or reason  # the first one stays
            if job.state is not State.QUEUED:
                return
        self._end(job, State.CANCELLED, reason)

    def cancel_refinement(
        self, part_id: str, reason: str, but: JobRequest | None
    ) -> None:
        """Ask the refinements of a part to end, but for one that is wanted anew.

        Those of parts that are gone end with them: they hold on to these.
        """
        for job in self.all():
            if not job.request.refinement:
                continue
            part = job.find_part()
            if job.part_id == part_id:
                if job.request != but:
                    self.cancel(job.job_id, reason)
            elif part is not None and not part.is_current:
                self.cancel(job.job_id, PART_GONE)

    def get(self, job_id: str) -> Job | None:
        """A job by its id, as long as it has not ended."""
        with self._changing:
            return self._jobs.get(job_id)

    def all(self) -> list[Job]:
        """All jobs that have not ended, oldest first."""
        with self._changing:
            return list(self._jobs.values())

    def count_waiting(self) -> tuple[int, int]:
        """Jobs waiting for clients, and refinements waiting."""
        waiting = self._waiting()
        refinements = sum(job.request.refinement for job in waiting)
        return len(waiting) - refinements, refinements

    def _waiting(self) -> list[Job]:
        return [
            job
            for job in list(self._jobs.values())
            if job.state is State.QUEUED and not job.cancel_reason
        ]

    def close(self, reason: str) -> None:
        """Cancel all and wait a while for the thread."""
        # Who was accepted before this is cancelled, who comes then is refused.
        with self._accepting:
            self._closing = reason
        for job in self.all():
            self.cancel(job.job_id, reason)
        is_done = finish_within(LAST_SECONDS, self._pool.shutdown)
        running = self.running_job
        if not is_done and running is not None:
            self._end(running, State.CANCELLED, reason)

    def _run_next(self) -> None:
        with self._changing:
            waiting = self._waiting()
            if not waiting:  # it has been cancelled
                return
            job = min(waiting, key=lambda job: job.request.refinement)
            job.state = State.RUNNING
            self.running_job = job
        try:
            self._run_job(job)
        except Exception as error:  # a refusal, or a failure that is told like one
            if not isinstance(error, PoseStatsError):
                self._say_failure(f"{job.job_id}: {describe_error(error)}")
            self._end(job, State.FAILED, describe_error(error), code_of(error))
        self.running_job = None

    def _run_job(self, job: Job) -> None:
        while not (job.part.done() or job.cancel_reason):
            wait([job.part], POLL_SECONDS)
        if job.cancel_reason:
            self._end(job, State.CANCELLED, job.cancel_reason)
            return
        part = result_or_refusal(job.part).geometry
        self.listener.started(job)
        self.listener.follow(job)
        stop = Stop(job, self._should_give_way)
        outcome = self._run(job, part, self.listener, stop)
        with self._changing:
            if stop.reason == GAVE_WAY and not job.cancel_reason:
                job.state = State.QUEUED
                job.drops_done = 0
                self._pool.submit(self._run_next)
                return
        job.take_outcome(outcome)
        if stop.reason:
            self._end(job, State.CANCELLED, job.cancel_reason)
            return
        cut_short = [
            warning for warning in outcome.warnings if warning.code in CUT_SHORT
        ]
        code = max((CUT_SHORT[warning.code] for warning in cut_short), default=Code.OK)
        self._end(job, State.DONE, " ".join(map(str, cut_short)), code)

    def _should_give_way(self, job: Job) -> bool:
        """Whether clients wait for what a refinement takes."""
        return job.request.refinement and self.count_waiting()[0] > 0

    def _end(
        self, job: Job, state: State, message: str, code: int = Code.CANCELLED
    ) -> None:
        with self._changing:
            if job.is_ending:  # by the other thread, when the queue was closed
                return
            job.is_ending = True
        if job.snapshot is not None:
            # Of a run that did not stop in time, no later drops are kept.
            job.drops_done = job.snapshot.drops
        job.message = message
        job.code = code
        try:
            self.listener.ended(job, state)
        except Exception as error:  # must not keep a job from ending
            self._say_failure(f"{job.job_id}: {describe_error(error)}")
        with self._changing:
            job.state = state
            del self._jobs[job.job_id]
        job.release()
        job.finished.set_result(None)


def _is_twin(request: JobRequest, job: Job) -> bool:
    """Whether a job is what is asked for; what a client asked gives no way."""
    gives_way = job.request.refinement and not (request.refinement or request.hybrid)
    if job.cancel_reason or gives_way:
        return False
    return replace(job.request, refinement=request.refinement) == request


def job_health(jobs: Jobs, settings: Any) -> Health:
    """The line about drop simulations."""
    requests, refinements = jobs.count_waiting()
    job = jobs.running_job
    line = "idle"
    if job is not None:
        line = (
            f"{job.job_id}: {job.drops_done} of {job.request.drops} drops "
            f"of '{job.part_id}'"
        )
    return Health(
        False,
        line,
        {
            "queued": requests,
            "refinements queued": refinements,
            "queue bound": settings.max_queued_jobs,
            "running": "" if job is None else job.job_id,
            "threads": settings.threads(),
        },
    )


def flip_health(goals: Jobs, plans: Jobs) -> Health:
    """The line about flips, those of goals and those of plans."""
    running = [job for job in (goals.running_job, plans.running_job) if job is not None]
    lines = [
        f"{job.job_id}: {job.drops_done} flips of '{job.part_id}'" for job in running
    ]
    return Health(
        False,
        "; ".join(lines) or "idle",
        {
            "goals queued": goals.count_waiting()[0],
            "plans queued": plans.count_waiting()[0],
            "running": ", ".join(job.job_id for job in running),
        },
    )
