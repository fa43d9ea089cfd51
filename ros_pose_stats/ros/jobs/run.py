"""One run of a job's drops or flips, up to its end or to the first reason to stop."""

import time
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ...errors import RequestError
from ...planning import confidence, hybrid
from ...records import DropProgress, DropScene, FlipStatistics, Part, PoseStatistics
from ...resting.poses import poses_in
from ...simulation import flips, simulate
from ...simulation.request import Watch, drop_request
from ...statistics.prefix import Judge, target_reached
from ..parts.known_part import Memory
from .job import COMBINED_SECONDS, FlipRequest, Job, JobListener, State

Outcome = TypeVar("Outcome", PoseStatistics, FlipStatistics)

MOST_POSES = 1000  # a transition matrix of more takes tens of megabytes
REMEMBERED = 2_000_000  # transitions, of which each takes some 24 bytes


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

    def judge(self, outcome: Outcome, complete: bool, done: str) -> tuple[Outcome, Ending]:
        """An outcome with the ending, and a warning where there was no more time."""
        if complete:
            return outcome, Ending.COMPLETE
        if self.ending is Ending.OUT_OF_TIME:
            late = f"TIME_LIMIT: ended after {self._job.request.max_seconds:g} s with {done}."
            outcome = replace(outcome, warnings=(*outcome.warnings, late))
        return outcome, self.ending


def run_drops(job: Job, part: Part, listener: JobListener,
              should_give_way: Callable[[], bool]) -> tuple[PoseStatistics, Ending]:
    """Drop the part as the job asks; what was done, and why no more."""
    request, stop = job.request, _Stop(job, should_give_way)

    def on_progress(progress: DropProgress) -> None:
        job.take(progress)
        job.tell_followers()
        listener.progressed(job)

    prior = confidence.pose_prior(poses_in(part, request.scene),
                                  request.scene) if request.hybrid else None
    judge = None
    if prior is not None and request.target_error:
        judge = Judge(partial(confidence.judge_drops, prior),
                      confidence.first_look(prior, request.target_error, helped=True),
                      COMBINED_SECONDS)
    on_drops = partial(listener.dropped, job) if job.settings.log_drops else None
    counted = simulate.count_drops(
        part, request.scene,
        drop_request(request.drops, job.seed, request.target_error, job.settings.threads()),
        Watch(on_progress if prior is None else hybrid.combined_progress(prior, on_progress),
              stop.is_due, on_drops, background=True), judge)
    poses = sorted(counted.poses, key=lambda pose: pose.index)
    complete = counted.drops == request.drops or target_reached(
        confidence.judge_drops(prior, np.array([pose.count for pose in poses])).bound,
        request.target_error)
    if prior is not None:
        counted = hybrid.hybrid_statistics(counted, prior)
    return stop.judge(counted, complete, f"{counted.drops} of at most {request.drops} drops")


FlipKey = tuple[str, float, float, int, float]


def flip_key(digest: str, scene: DropScene, kick_height: float) -> FlipKey:
    """On what flips depend, but for their number and seed; not on the drop height."""
    return digest, scene.restitution, scene.cluster_tolerance, scene.round_sides, kick_height


class FlipReports(JobListener):
    """Remembers flips up to a bound; they are not recorded, for a seed gives them again."""

    def __init__(self) -> None:
        # the most flips of a key, and those of a job, without the poses themselves
        self._best: Memory[FlipKey, FlipStatistics] = Memory(
            REMEMBERED, lambda counted: counted.counts.size)
        self._of_jobs: Memory[str, FlipStatistics] = Memory(
            REMEMBERED, lambda counted: counted.counts.size)
        self.best, self.of_job = self._best.get, self._of_jobs.get

    def ended(self, job: Job, state: State) -> None:
        """Remember what was counted."""
        if job.flips is None:
            return
        counted = replace(job.flips, poses=())
        self._of_jobs.put(job.job_id, counted)
        key = flip_key(counted.part_digest, job.request.scene, counted.kick_height)
        before = self._best.get(key)
        if counted.flips and (before is None or before.flips < counted.flips):
            self._best.put(key, counted)


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
    assert isinstance(request, FlipRequest)
    scene, stop = request.scene, _Stop(job, should_give_way)
    poses = pose_count(part, scene)
    total = flips_in_all(poses, request.drops, job.settings)

    def on_progress(done: int, _: int) -> None:
        job.drops_done = done
        job.tell_followers()
        listener.progressed(job)

    counted = flips.count_flips(
        part, scene, request.kick_height,
        drop_request(total // poses, job.seed, 0.0, job.settings.threads()),
        Watch(None, stop.is_due, background=True), on_progress)
    return stop.judge(counted, counted.flips == total, f"{counted.flips} of {total} flips")
