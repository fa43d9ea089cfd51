"""One run of a job's drops, up to its end or to the first reason to stop."""

import time
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial

import numpy as np

from ...planning.confidence import first_look, judge_drops, pose_prior
from ...planning.hybrid import combined_progress, hybrid_statistics
from ...records import DropProgress, Part, PoseStatistics
from ...resting.poses import poses_in
from ...simulation.drops import DropChunk
from ...simulation.request import Watch, drop_request
from ...simulation.simulate import count_drops
from ...statistics.prefix import Judge, target_reached
from ...statistics.prior import PosePrior
from .job import COMBINED_SECONDS, Job, JobListener, JobRequest


class Ending(Enum):
    """Why a run of drops is over."""

    COMPLETE = 1
    CANCELLED = 2
    OUT_OF_TIME = 3
    GAVE_WAY = 4


def run_drops(job: Job, part: Part, listener: JobListener,
              should_give_way: Callable[[], bool]) -> tuple[PoseStatistics, Ending]:
    """Drop the part as the job asks.

    `job, listener`: both are told how far the run is; `should_give_way`: whether somebody who
    comes first is waiting. Returns what was done, and why no more. Raises PoseStatsError if the
    part cannot be dropped.
    """
    request = job.request
    until = time.monotonic() + request.max_seconds
    ending = Ending.COMPLETE

    def should_stop() -> bool:
        nonlocal ending
        if job.cancel_reason:
            ending = Ending.CANCELLED
        elif time.monotonic() > until:
            ending = Ending.OUT_OF_TIME
        elif should_give_way():
            ending = Ending.GAVE_WAY
        return ending is not Ending.COMPLETE

    def on_progress(progress: DropProgress) -> None:
        job.take(progress)
        listener.progressed(job)

    def on_drops(chunk: DropChunk) -> None:
        listener.dropped(job, chunk)

    prior = _prior(part, request)
    found = count_drops(
        part, request.scene,
        drop_request(request.drops, job.seed, request.target_error, job.settings.threads()),
        Watch(on_progress if prior is None else combined_progress(prior, on_progress),
              should_stop, on_drops if job.settings.log_drops else None, background=True),
        _judge(prior, request.target_error))
    complete = _complete(found, request, prior)
    if prior is not None:
        found = hybrid_statistics(found, prior)
    if complete:
        return found, Ending.COMPLETE
    if ending is Ending.OUT_OF_TIME:
        found = _warned(found, request)
    return found, ending


def _complete(found: PoseStatistics, request: JobRequest, prior: PosePrior | None) -> bool:
    if found.drops == request.drops:
        return True
    counts = np.array([pose.count for pose in sorted(found.poses, key=lambda one: one.index)])
    return target_reached(judge_drops(prior, counts).bound, request.target_error)


def _warned(found: PoseStatistics, request: JobRequest) -> PoseStatistics:
    late = (f"TIME_LIMIT: ended after {request.max_seconds:g} s with {found.drops} of at most "
            f"{request.drops} drops.")
    return replace(found, warnings=(*found.warnings, late))


def _prior(part: Part, request: JobRequest) -> PosePrior | None:
    """The estimate that the drops are combined with, if that is wanted."""
    if not request.hybrid:
        return None
    return pose_prior(poses_in(part, request.scene), request.scene)


def _judge(prior: PosePrior | None, target_error: float) -> Judge | None:
    """Who decides whether drops and estimate are sure enough; nobody without a target."""
    if prior is None or not target_error:
        return None
    return Judge(partial(judge_drops, prior), first_look(prior, target_error, helped=True),
                 COMBINED_SECONDS)
