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

"""A simulation: its request, how far it is, and its run up to a reason to stop."""

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import partial
from typing import Any, TypeVar

from ros_pose_stats_msgs.msg import Code, JobStatus

from ...base.errors import RequestError
from ...core.planning import auto, confidence, hybrid
from ...core.records import (
    DropProgress,
    DropScene,
    FlipStatistics,
    Part,
    PoseStatistics,
)
from ...core.records.notes import note
from ...core.resting.poses import poses_in
from ...core.simulation import drops, flips, simulate
from ...core.simulation.request import Watch, drop_request
from ...core.statistics.prefix import Judge, target_reached
from ..memory import Memory
from ..parts.known_part import KnownPart

SNAPSHOT_SECONDS = 0.2
COMBINED_SECONDS = (
    1.0  # between snapshots with an estimate in them: they hold up others
)
SNAPSHOT_SHARE = 0.05  # of the time, for snapshots of parts with thousands of poses
MOST_POSES = 1000  # a transition matrix of more takes tens of megabytes
REMEMBERED = 4_000_000  # transitions, of which each takes some 24 bytes
GAVE_WAY = "it gave way to what clients asked for"
PART_GONE = "the part was forgotten or has changed"


class State(IntEnum):
    """How far a job is."""

    QUEUED = JobStatus.QUEUED
    RUNNING = JobStatus.RUNNING
    DONE = JobStatus.DONE
    CANCELLED = JobStatus.CANCELLED
    FAILED = JobStatus.FAILED

    @property
    def ended(self) -> bool:
        """Whether nothing more comes."""
        return self >= State.DONE


@dataclass(frozen=True)
class JobRequest:
    """What a client asked for, in full; equal requests in flight are one job."""

    part_id: str  # as it was sent: empty for a nameless part
    content: bytes  # digest of the mesh as it was sent
    scene: DropScene
    drops: int
    seed: int  # 0: drawn by the node
    target_error: float
    max_seconds: float
    refinement: bool = False  # started by the node itself; gives way to clients
    # whether its statistics are those of the drops and an estimate together, and the
    # target error is one that is kept with 90 % confidence
    hybrid: bool = False


@dataclass(frozen=True)
class FlipRequest(JobRequest):
    """The same of flips; `drops` are those out of each pose, 0: the node's share."""

    kick_height: float = 0.0  # metres


@dataclass(eq=False)
class Job:
    """A simulation of drops or flips; written by the queue's thread, read by all."""

    job_id: str
    request: JobRequest
    part: Future[KnownPart]  # the mesh may still be on its way through the hull
    seed: int
    settings: Any  # the node's settings when the job was accepted
    state: State = State.QUEUED
    drops_done: int = 0
    expected_error: float = math.nan
    drops_per_second: float = math.nan
    # a recent state while running; the end result afterwards
    snapshot: PoseStatistics | None = None
    flips: FlipStatistics | None = None  # the end result of flips, without the poses
    flips_total: int = 0  # out of all poses, once they have begun
    message: str = ""  # how it ended, and the code of that
    code: int = Code.OK
    is_recorded: bool = True  # whether the acceptance is in the bag and in the state
    # done once its end can be seen
    finished: Future[None] = field(default_factory=Future)
    cancel_reason: str = ""
    is_ending: bool = False  # whether its end is being told; that happens once
    _next_snapshot: float = 0.0  # by the monotonic clock

    @property
    def part_id(self) -> str:
        """Name of the part; of a nameless one, the name it got, once it is there."""
        part = self.find_part()
        return self.request.part_id or ("" if part is None else part.part_id)

    def find_part(self) -> KnownPart | None:
        """The part, if it is there; never waits, also while the job lets go of it."""
        part = self.part
        if not part.done() or part.cancelled() or part.exception() is not None:
            return None
        return part.result()

    def take_progress(self, progress: DropProgress) -> None:
        """Note how far the run is, and now and then its statistics."""
        now = time.monotonic()
        snapshot = self.snapshot
        if now >= self._next_snapshot:
            snapshot = progress.statistics()
            seconds = time.monotonic() - now
            pause = COMBINED_SECONDS if self.request.hybrid else SNAPSHOT_SECONDS
            self._next_snapshot = now + max(pause, seconds / SNAPSHOT_SHARE)
        if not self.is_ending:
            self.drops_done = progress.drops
            self.expected_error = progress.expected_error
            self.drops_per_second = progress.rate
            self.snapshot = snapshot

    def take_outcome(self, outcome: PoseStatistics | FlipStatistics) -> None:
        """Note the end result."""
        if isinstance(outcome, FlipStatistics):
            self.flips = replace(outcome, poses=())
            self.drops_done = outcome.flips
            return
        self.snapshot = outcome
        self.drops_done = outcome.drops
        self.expected_error = outcome.expected_error

    def release(self) -> None:
        """Let go of the part and of what refers to it: goals may hold on to the job."""
        self.part = Future()
        self.snapshot = None


class JobListener:
    """Hears what happens to jobs, in whatever thread brings it about."""

    # shows goals how far a job is: as it begins to run, and some twenty times a second
    follow: Callable[[Job], object] = staticmethod(lambda job: None)

    def queued(self, job: Job) -> bool:
        """Accepted; returns whether that could be stored and recorded."""
        return True

    def started(self, job: Job) -> None:
        """Begins to run."""

    def progressed(self, job: Job) -> None:
        """Some twenty times a second while it runs."""

    def dropped(self, job: Job, chunk: drops.DropChunk) -> None:
        """Single drops, in order."""

    def ended(self, job: Job, state: State) -> None:
        """Has ended with `state`; who asks for it from now on asks the listener."""


Outcome = TypeVar("Outcome", PoseStatistics, FlipStatistics)


class Stop:
    """Whether a run is to stop before its end: its time is over, or for a reason."""

    def __init__(self, job: Job, should_give_way: Callable[[Job], bool]) -> None:
        self._job = job
        self._should_give_way = should_give_way
        self._deadline = time.monotonic() + job.request.max_seconds
        self._is_late = False
        self.reason = ""

    def is_due(self) -> bool:
        """Whether it was cancelled, its time is over, or it has to give way."""
        self.reason = self._job.cancel_reason or self.reason
        self._is_late = not self.reason and time.monotonic() > self._deadline
        if not (self.reason or self._is_late) and self._should_give_way(self._job):
            self.reason = GAVE_WAY
        return self._is_late or self.reason != ""

    def judge(self, outcome: Outcome, complete: bool, extent: str) -> Outcome:
        """The outcome of a run, with a warning where time was too short for it."""
        if complete:
            self.reason = ""
        elif self._is_late:
            seconds = self._job.request.max_seconds
            warning = note("TIME_LIMIT", f"ended after {seconds:g} s with {extent}.")
            return replace(outcome, warnings=(*outcome.warnings, warning))
        return outcome


def run_drops(
    job: Job, part: Part, listener: JobListener, stop: Stop
) -> PoseStatistics:
    """Drop the part as the job asks; what was done."""
    request = job.request

    def on_progress(progress: DropProgress) -> None:
        job.take_progress(progress)
        listener.follow(job)
        listener.progressed(job)

    prior = None
    watch_progress: Callable[[DropProgress], object] | None = on_progress
    if request.hybrid:
        resting = poses_in(part, request.scene)
        prior = confidence.pose_prior(resting, request.scene)
        watch_progress = hybrid.combined_progress(prior, on_progress)
    judge = None
    if prior is not None and request.target_error:
        judge = Judge(
            partial(confidence.judge_drops, prior),
            auto.LEAST_DROPS,
            COMBINED_SECONDS,
        )
    on_drops = partial(listener.dropped, job) if job.settings.log_drops else None
    statistics = simulate.count_drops(
        part,
        request.scene,
        drop_request(
            request.drops, job.seed, request.target_error, job.settings.threads()
        ),
        Watch(watch_progress, stop.is_due, on_drops, background=True),
        judge,
    )
    judgement = confidence.judge_drops(prior, statistics.column("count"))
    complete = statistics.drops == request.drops or target_reached(
        judgement.bound, request.target_error
    )
    if prior is not None:
        statistics = hybrid.hybrid_statistics(statistics, prior)
    extent = f"{statistics.drops} of at most {request.drops} drops"
    return stop.judge(statistics, complete, extent)


FlipKey = tuple[str, DropScene, float]


def flip_key(digest: str, scene: DropScene, kick_height: float) -> FlipKey:
    """On what flips depend, but for their number and seed; not on the drop height."""
    return digest, replace(scene, drop_height=None), kick_height


class FlipReports(JobListener):
    """Remembers flips up to a bound; a seed gives them again, so none is recorded."""

    def __init__(self, counted: Memory[FlipKey, FlipStatistics] | None = None) -> None:
        # those with the most flips of a key, which several queues may share
        self.counted = counted or Memory(
            REMEMBERED, lambda statistics: statistics.counts.size
        )

    def ended(self, job: Job, state: State) -> None:
        """Remember what was counted."""
        statistics = job.flips
        if statistics is None or not statistics.flips:
            return
        key = flip_key(
            statistics.part_digest, job.request.scene, statistics.kick_height
        )
        remembered = self.counted.get(key)
        if remembered is None or remembered.flips < statistics.flips:
            self.counted.put(key, statistics)


def flips_in_all(poses: int, flips_per_pose: int, settings: Any) -> int:
    """Flips out of all poses; 0 out of each: the node's number shared out."""
    if poses > MOST_POSES:
        raise RequestError(
            f"a part of at most {MOST_POSES} poses to flip",
            f"{poses}",
            "raise the parameter cluster_tolerance",
        )
    if not flips_per_pose:
        flips_per_pose = max(1, min(settings.drops, settings.max_drops) // poses)
    total = flips_per_pose * poses
    if total > settings.max_drops:
        raise RequestError(
            f"at most {settings.max_drops} flips out of all poses "
            "(parameter max_drops)",
            f"{flips_per_pose} out of each of {poses}",
            "ask for fewer, or raise the parameter",
        )
    return total


def run_flips(
    job: Job, part: Part, listener: JobListener, stop: Stop
) -> FlipStatistics:
    """Flip the part as the job asks; see `run_drops`."""
    request = job.request
    scene = request.scene
    assert isinstance(request, FlipRequest)
    poses = len(poses_in(part, scene).poses)
    total = flips_in_all(poses, request.drops, job.settings)
    job.flips_total = total

    def on_progress(count: int, _: int) -> None:
        job.drops_done = count
        listener.follow(job)
        listener.progressed(job)

    statistics = flips.count_flips(
        part,
        scene,
        request.kick_height,
        drop_request(total // poses, job.seed, 0.0, job.settings.threads()),
        Watch(None, stop.is_due, background=True),
        on_progress,
    )
    extent = f"{statistics.flips} of {total} flips"
    return stop.judge(statistics, statistics.flips == total, extent)
