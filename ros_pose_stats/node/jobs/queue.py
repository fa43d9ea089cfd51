"""A bounded queue of simulations; clients come first, refinements give way and begin again."""

import itertools
import secrets
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from functools import partial
from typing import Any

from ...base.errors import PoseStatsError, RequestError
from ...core.records import FlipStatistics, Part, PoseStatistics
from ..lanes import describe_error, refusal_at_end, result_or_refusal
from ..parts.known_part import KnownPart
from ..refusals import Health
from ..stop_signals import within
from .run import GAVE_WAY, Job, JobListener, JobRequest, State, Stop, run_drops

Run = Callable[[Job, Part, JobListener, Stop], PoseStatistics | FlipStatistics]
"""Computes what a job asks for, as `run_drops` does."""

CUT_SHORT = ("TIME_LIMIT", "TARGET_MISSED")  # warnings that are the message of an end
POLL_SECONDS = 0.02
LAST_SECONDS = (
    0.6  # for what runs when the queue is closed; some parts are prepared for minutes
)


class Jobs:
    """The queue and what works it off; ids begin with `run_name`, unique across restarts."""

    def __init__(
        self,
        run_name: str,
        listener: JobListener,
        on_failure: Callable[[str], object],
        run: Run = run_drops,
    ) -> None:
        self._run_name = run_name
        self.listener = listener
        self._on_failure = on_failure
        self._compute = run
        self._numbers = itertools.count(1)
        self._jobs: dict[
            str, Job
        ] = {}  # that have not ended, in the order of their acceptance
        self.running: Job | None = None
        self._accepting = threading.Lock()
        self._changing = threading.Lock()
        self._closing = ""
        self._pool = ThreadPoolExecutor(1, "jobs")

    def submit(
        self,
        request: JobRequest,
        part: Future[KnownPart],
        settings: Any,
        is_accepted: bool = False,
    ) -> Job:
        """Accept a simulation, or join the same in flight; what `is_accepted` has room."""
        with self._accepting:  # acceptance goes on record one at a time
            with self._changing:
                twin = next(
                    filter(partial(_is_twin, request), self._jobs.values()), None
                )
                if twin is not None:
                    return twin
                if self._closing:
                    raise refusal_at_end()
                most = settings.max_queued_jobs
                running = self.running
                if not (request.refinement or is_accepted) and (
                    self.counts()[0] >= most + (running is None or running.state.ended)
                ):
                    raise RequestError(
                        f"at most {most} simulations waiting (parameter max_queued_jobs)",
                        "a full queue",
                        "wait, or cancel one",
                    )
            seed = request.seed or secrets.randbits(32) or 1
            job = Job(
                f"{self._run_name}_{next(self._numbers):04d}",
                request,
                part,
                seed,
                settings,
            )
            job.recorded = self.listener.queued(job)
            with self._changing:
                self._jobs[job.job_id] = job
            self._pool.submit(self._run_next)
            return job

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
        self, part_id: str, reason: str, but: JobRequest | None = None
    ) -> None:
        """Ask the refinements of a part to end, but for one that was asked for anew."""
        for job in self.all():
            if job.request.refinement and job.part_id == part_id and job.request != but:
                self.cancel(job.job_id, reason)

    def get(self, job_id: str) -> Job | None:
        """A job by its id, as long as it has not ended."""
        with self._changing:
            return self._jobs.get(job_id)

    def all(self) -> list[Job]:
        """All jobs that have not ended, oldest first."""
        with self._changing:
            return list(self._jobs.values())

    def counts(self) -> tuple[int, int]:
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
        with (
            self._accepting
        ):  # who was before this is cancelled, who comes then is refused
            self._closing = reason
        for job in self.all():
            self.cancel(job.job_id, reason)
        is_done = within(LAST_SECONDS, self._pool.shutdown)
        running = self.running
        if not is_done and running is not None:
            self._end(running, State.CANCELLED, reason)

    def _run_next(self) -> None:
        with self._changing:
            waiting = self._waiting()
            if not waiting:  # it has been cancelled
                return
            job = self.running = min(waiting, key=lambda job: job.request.refinement)
            job.state = State.RUNNING
        try:
            self._run(job)
        except Exception as error:  # a refusal, or a failure that is told like one
            if not isinstance(error, PoseStatsError):
                self._on_failure(f"{job.job_id}: {describe_error(error)}")
            self._end(job, State.FAILED, describe_error(error))
        self.running = None

    def _run(self, job: Job) -> None:
        while not (job.part.done() or job.cancel_reason):
            wait([job.part], POLL_SECONDS)
        if job.cancel_reason:
            self._end(job, State.CANCELLED, job.cancel_reason)
            return
        part = result_or_refusal(job.part).geometry
        self.listener.started(job)
        self.listener.follow(job)
        stop = Stop(job, lambda: job.request.refinement and self.counts()[0] > 0)
        outcome = self._compute(job, part, self.listener, stop)
        with self._changing:
            if stop.why == GAVE_WAY and not job.cancel_reason:
                job.state = State.QUEUED
                job.drops_done = 0
                self._pool.submit(self._run_next)
                return
        job.keep(outcome)
        if stop.why:
            self._end(job, State.CANCELLED, job.cancel_reason)
        else:
            self._end(
                job,
                State.DONE,
                " ".join(
                    line for line in outcome.warnings if line.startswith(CUT_SHORT)
                ),
            )

    def _end(self, job: Job, state: State, message: str) -> None:
        with self._changing:
            if job.ending:  # by the other thread, when the queue was closed
                return
            job.ending = True
        if (
            job.snapshot is not None
        ):  # of a run that did not stop in time, no later drops are kept
            job.drops_done = job.snapshot.drops
        job.message = message
        try:
            self.listener.ended(job, state)
        except Exception as error:  # must not keep a job from ending
            self._on_failure(f"{job.job_id}: {describe_error(error)}")
        with self._changing:
            job.state = state
            del self._jobs[job.job_id]
        job.release()
        job.finished.set_result(None)


def _is_twin(request: JobRequest, job: Job) -> bool:
    """Whether a job is what is asked for; what a client asked gives no way."""
    gives_way = job.request.refinement and not (request.refinement or request.hybrid)
    return not (job.cancel_reason or gives_way) and (
        replace(job.request, refinement=request.refinement) == request
    )


def job_health(jobs: Jobs, settings: Any) -> Health:
    """The line about drop simulations."""
    asked, refinements = jobs.counts()
    job = jobs.running
    text = (
        "idle"
        if job is None
        else (
            f"{job.job_id}: {job.drops_done} of {job.request.drops} drops of '{job.part_id}'"
        )
    )
    return Health(
        False,
        text,
        {
            "queued": asked,
            "refinements queued": refinements,
            "queue bound": settings.max_queued_jobs,
            "running": "" if job is None else job.job_id,
            "threads": settings.threads(),
        },
    )


def flip_health(goals: Jobs, answers: Jobs) -> Health:
    """The line about flips, those of goals and of answers of ~/feeding."""
    running = [job for job in (goals.running, answers.running) if job is not None]
    text = "; ".join(
        f"{job.job_id}: {job.drops_done} flips of '{job.part_id}'" for job in running
    )
    return Health(
        False,
        text or "idle",
        {
            "goals queued": goals.counts()[0],
            "answers queued": answers.counts()[0],
            "running": ", ".join(job.job_id for job in running),
        },
    )
