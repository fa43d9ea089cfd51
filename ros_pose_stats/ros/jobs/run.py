"""One run of a job's drops or flips, up to its end or to the first reason to stop."""

import time
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...errors import RequestError
from ...planning.confidence import first_look, judge_drops, pose_prior
from ...planning.hybrid import combined_progress, hybrid_statistics
from ...records import DropProgress, DropScene, FlipStatistics, Part, PoseStatistics
from ...resting.poses import poses_in
from ...simulation.flips import count_flips
from ...simulation.request import Watch, drop_request
from ...simulation.simulate import count_drops
from ...statistics.prefix import Judge, target_reached
from ...statistics.prior import PosePrior
from ..parts.memory import Memory
from .job import COMBINED_SECONDS, FlipRequest, Job, JobListener, JobRequest, State


class Ending(Enum):
    """Why a run of drops is over."""

    COMPLETE = 1
    CANCELLED = 2
    OUT_OF_TIME = 3
    GAVE_WAY = 4


class _Stop:
    """Looks whether a run is to stop, and keeps why."""

    def __init__(self, job: Job, should_give_way: Callable[[], bool]) -> None:
        self._job, self._should_give_way = job, should_give_way
        self._until = time.monotonic() + job.request.max_seconds
        self.ending = Ending.COMPLETE

    def is_due(self) -> bool:
        """Whether somebody cancelled it, its time is over, or it has to give way."""
        if self._job.cancel_reason:
            self.ending = Ending.CANCELLED
        elif time.monotonic() > self._until:
            self.ending = Ending.OUT_OF_TIME
        elif self._should_give_way():
            self.ending = Ending.GAVE_WAY
        return self.ending is not Ending.COMPLETE


def run_drops(job: Job, part: Part, listener: JobListener,
              should_give_way: Callable[[], bool]) -> tuple[PoseStatistics, Ending]:
    """Drop the part as the job asks; what was done, and why no more."""
    request, stop = job.request, _Stop(job, should_give_way)

    def on_progress(progress: DropProgress) -> None:
        job.take(progress)
        job.tell_followers()
        listener.progressed(job)

    prior = _prior(part, request)
    on_drops = partial(listener.dropped, job) if job.settings.log_drops else None
    found = count_drops(
        part, request.scene,
        drop_request(request.drops, job.seed, request.target_error, job.settings.threads()),
        Watch(on_progress if prior is None else combined_progress(prior, on_progress),
              stop.is_due, on_drops, background=True),
        _judge(prior, request.target_error))
    complete = _complete(found, request, prior)
    if prior is not None:
        found = hybrid_statistics(found, prior)
    if complete:
        return found, Ending.COMPLETE
    if stop.ending is Ending.OUT_OF_TIME:
        found = _warned(found, request)
    return found, stop.ending


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


MOST_POSES = 1000
"""A transition matrix of more takes tens of megabytes."""

REMEMBERED = 2_000_000
"""Transitions, of which each takes some 24 bytes."""


class FlipKey(NamedTuple):
    """On what flips depend, but for their number and seed; not on the drop height."""

    digest: str
    restitution: float
    cluster_tolerance: float
    round_sides: int
    kick_height: float


def flip_key(digest: str, scene: DropScene, kick_height: float) -> FlipKey:
    """The key of flips in a scene."""
    return FlipKey(digest, scene.restitution, scene.cluster_tolerance, scene.round_sides,
                   kick_height)


class FlipReports(JobListener):
    """Remembers flips up to a bound; they are not recorded, for a seed gives them again."""

    def __init__(self) -> None:
        self._best: Memory[FlipKey, FlipStatistics] = Memory(REMEMBERED, _transitions)
        self._of_jobs: Memory[str, FlipStatistics] = Memory(REMEMBERED, _transitions)

    def of_job(self, job_id: str) -> FlipStatistics | None:
        """What a job counted, without the poses themselves."""
        return self._of_jobs.get(job_id)

    def best(self, key: FlipKey) -> FlipStatistics | None:
        """The most flips of a key."""
        return self._best.get(key)

    def ended(self, job: Job, state: State) -> None:
        """Remember what was counted."""
        if job.flips is None:
            return
        found = replace(job.flips, poses=())
        self._of_jobs.put(job.job_id, found)
        key = flip_key(found.part_digest, job.request.scene, found.kick_height)
        before = self._best.get(key)
        if found.flips and (before is None or before.flips < found.flips):
            self._best.put(key, found)


def _transitions(found: FlipStatistics) -> int:
    return int(found.counts.size)


def pose_count(part: Part, scene: DropScene) -> int:
    """Number of a part's poses in a scene."""
    return len(poses_in(part, scene).poses)


def flips_in_all(poses: int, asked: int, settings: Any) -> int:
    """Flips out of all poses, `asked` out of each or else the node's number shared out."""
    if poses > MOST_POSES:
        raise RequestError(f"a part of at most {MOST_POSES} poses to flip", f"{poses}",
                           "raise the parameter cluster_tolerance")
    each = asked or max(1, min(settings.drops, settings.max_drops) // poses)
    if each * poses > settings.max_drops:
        raise RequestError(
            f"at most {settings.max_drops} flips out of all poses (parameter max_drops)",
            f"{each} out of each of {poses}", "ask for fewer, or raise the parameter")
    return each * poses


def run_flips(job: Job, part: Part, listener: JobListener,
              should_give_way: Callable[[], bool]) -> tuple[FlipStatistics, Ending]:
    """Flip the part as the job asks; see `run_drops`."""
    request = job.request
    if not isinstance(request, FlipRequest):
        raise TypeError(f"expected a FlipRequest, got {type(request).__name__}")
    scene, stop = request.scene, _Stop(job, should_give_way)
    poses = pose_count(part, scene)
    total = flips_in_all(poses, request.drops, job.settings)

    def on_progress(done: int, _: int) -> None:
        job.drops_done = done
        job.tell_followers()
        listener.progressed(job)

    found = count_flips(
        part, scene, request.kick_height,
        drop_request(total // poses, job.seed, 0.0, job.settings.threads()),
        Watch(None, stop.is_due, background=True), on_progress)
    if found.flips == total:
        return found, Ending.COMPLETE
    if stop.ending is Ending.OUT_OF_TIME:
        late = (f"TIME_LIMIT: ended after {request.max_seconds:g} s with {found.flips} of "
                f"{total} flips.")
        found = replace(found, warnings=(*found.warnings, late))
    return found, stop.ending
