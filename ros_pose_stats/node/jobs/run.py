"""A simulation: what was asked for, how far it is, and its run up to the first reason to stop."""

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ...base.errors import RequestError
from ...core.planning import confidence, hybrid
from ...core.records import (
    DropProgress,
    DropScene,
    FlipStatistics,
    Part,
    PoseStatistics,
)
from ...core.resting.poses import poses_in
from ...core.simulation import drops, flips, simulate
from ...core.simulation.request import Watch, drop_request
from ...core.statistics.prefix import Judge, target_reached
from ..memory import Memory
from ..parts.known_part import KnownPart

SNAPSHOT_SECONDS = 0.2
COMBINED_SECONDS = (
    1.0  # between snapshots with an estimate in them, which hold up other threads
)
SNAPSHOT_SHARE = (
    0.05  # of the time that snapshots of parts with thousands of poses may take
)


class State(IntEnum):
    """As in `GetDropSimulation`."""

    QUEUED = 1
    RUNNING = 2
    DONE = 3
    CANCELLED = 4
    FAILED = 5

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
    # its statistics are those of the drops and an estimate together, and the target error is one
    # that is kept with 90 % confidence
    hybrid: bool = False


@dataclass(frozen=True)
class FlipRequest(JobRequest):
    """The same of flips; `drops` are those out of each pose, 0: the node's shared out."""

    kick_height: float = 0.0  # metres


@dataclass(eq=False)
class Job:
    """A drop simulation, or one of flips; written by the queue's thread, read by all."""

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
    message: str = ""  # how it ended
    recorded: bool = True  # whether the acceptance is in the bag and in the state
    finished: Future[None] = field(
        default_factory=Future
    )  # done once its end can be seen
    cancel_reason: str = ""
    ending: bool = False  # whether its end is being told; that happens once
    _next_snapshot: float = 0.0

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

    def take(self, progress: DropProgress) -> None:
        """Note how far the run is, and now and then its statistics."""
        now = time.monotonic()
        snapshot = self.snapshot
        if now >= self._next_snapshot:
            snapshot = progress.statistics()
            took = time.monotonic() - now
            pause = COMBINED_SECONDS if self.request.hybrid else SNAPSHOT_SECONDS
            self._next_snapshot = now + max(pause, took / SNAPSHOT_SHARE)
        if not self.ending:
            self.drops_done = progress.drops
            self.expected_error = progress.expected_error
            self.drops_per_second = progress.rate
            self.snapshot = snapshot

    def release(self) -> None:
        """Let go of the part and of what refers to it: goals may hold on to the job."""
        self.part = Future()
        self.snapshot = None

    def keep(self, outcome: PoseStatistics | FlipStatistics) -> None:
        """Note the end result."""
        if isinstance(outcome, FlipStatistics):
            self.flips = replace(outcome, poses=())
            self.drops_done = outcome.flips
            return
        self.snapshot = outcome
        self.drops_done = outcome.drops
        self.expected_error = outcome.expected_error


class JobListener:
    """Keeps what happens to jobs, in the thread of the queue or of whoever submits or cancels."""

    # shows goals how far a job is: as it begins to run, and some twenty times a second
    follow: Callable[[Job], object] = staticmethod(lambda job: None)

    def queued(self, job: Job) -> bool:
        """Accepted; returns when that is kept and on record, false where it cannot be."""
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

GAVE_WAY = "it gave way to what clients asked for"
MOST_POSES = 1000  # a transition matrix of more takes tens of megabytes
REMEMBERED = 4_000_000  # transitions, of which each takes some 24 bytes


class Stop:
    """Looks whether a run is to stop before its end, because its time is over or for `why`."""

    def __init__(self, job: Job, should_give_way: Callable[[], bool]) -> None:
        self._job = job
        self._should_give_way = should_give_way
        self._until = time.monotonic() + job.request.max_seconds
        self._is_late = False
        self.why = ""

    def is_due(self) -> bool:
        """Whether somebody cancelled it, its time is over, or it has to give way."""
        self.why = self._job.cancel_reason or self.why
        self._is_late = not self.why and time.monotonic() > self._until
        if not (self.why or self._is_late) and self._should_give_way():
            self.why = GAVE_WAY
        return self._is_late or self.why != ""

    def judge(self, outcome: Outcome, complete: bool, done: str) -> Outcome:
        """What a run has made, with a warning where there was no more time for all of it."""
        if complete:
            self.why = ""
        elif self._is_late:
            late = f"TIME_LIMIT: ended after {self._job.request.max_seconds:g} s with {done}."
            return replace(outcome, warnings=(*outcome.warnings, late))
        return outcome


def run_drops(
    job: Job, part: Part, listener: JobListener, stop: Stop
) -> PoseStatistics:
    """Drop the part as the job asks; what was done."""
    request = job.request

    def on_progress(progress: DropProgress) -> None:
        job.take(progress)
        listener.follow(job)
        listener.progressed(job)

    prior = (
        confidence.pose_prior(poses_in(part, request.scene), request.scene)
        if request.hybrid
        else None
    )
    judge = None
    if prior is not None and request.target_error:
        judge = Judge(
            partial(confidence.judge_drops, prior),
            confidence.first_look(prior, request.target_error, helped=True),
            COMBINED_SECONDS,
        )
    on_drops = partial(listener.dropped, job) if job.settings.log_drops else None
    counted = simulate.count_drops(
        part,
        request.scene,
        drop_request(
            request.drops, job.seed, request.target_error, job.settings.threads()
        ),
        Watch(
            on_progress
            if prior is None
            else hybrid.combined_progress(prior, on_progress),
            stop.is_due,
            on_drops,
            background=True,
        ),
        judge,
    )
    counts = np.array([pose.count for pose in counted.by_index.values()])
    complete = counted.drops == request.drops or target_reached(
        confidence.judge_drops(prior, counts).bound, request.target_error
    )
    if prior is not None:
        counted = hybrid.hybrid_statistics(counted, prior)
    return stop.judge(
        counted, complete, f"{counted.drops} of at most {request.drops} drops"
    )


FlipKey = tuple[str, float, float, int, float]


def flip_key(digest: str, scene: DropScene, kick_height: float) -> FlipKey:
    """On what flips depend, but for their number and seed; not on the drop height."""
    return (
        digest,
        scene.restitution,
        scene.cluster_tolerance,
        scene.round_sides,
        kick_height,
    )


class FlipReports(JobListener):
    """Remembers flips up to a bound; they are not recorded, for a seed gives them again."""

    def __init__(self) -> None:
        self.counted: Memory[FlipKey, FlipStatistics] = Memory(  # the most of a key
            REMEMBERED, lambda counted: counted.counts.size
        )

    def ended(self, job: Job, state: State) -> None:
        """Remember what was counted."""
        if job.flips is None or not job.flips.flips:
            return
        key = flip_key(job.flips.part_digest, job.request.scene, job.flips.kick_height)
        before = self.counted.get(key)
        if before is None or before.flips < job.flips.flips:
            self.counted.put(key, job.flips)


def flips_in_all(poses: int, asked: int, settings: Any) -> int:
    """Flips out of all poses, `asked` out of each or else the node's number shared out."""
    if poses > MOST_POSES:
        raise RequestError(
            f"a part of at most {MOST_POSES} poses to flip",
            f"{poses}",
            "raise the parameter cluster_tolerance",
        )
    each = asked or max(1, min(settings.drops, settings.max_drops) // poses)
    if each * poses > settings.max_drops:
        raise RequestError(
            f"at most {settings.max_drops} flips out of all poses (parameter max_drops)",
            f"{each} out of each of {poses}",
            "ask for fewer, or raise the parameter",
        )
    return each * poses


def run_flips(
    job: Job, part: Part, listener: JobListener, stop: Stop
) -> FlipStatistics:
    """Flip the part as the job asks; see `run_drops`."""
    request = job.request
    scene = job.request.scene
    assert isinstance(request, FlipRequest)
    poses = len(poses_in(part, scene).poses)
    total = job.flips_total = flips_in_all(poses, request.drops, job.settings)

    def on_progress(done: int, _: int) -> None:
        job.drops_done = done
        listener.follow(job)
        listener.progressed(job)

    counted = flips.count_flips(
        part,
        scene,
        request.kick_height,
        drop_request(total // poses, job.seed, 0.0, job.settings.threads()),
        Watch(None, stop.is_due, background=True),
        on_progress,
    )
    return stop.judge(
        counted, counted.flips == total, f"{counted.flips} of {total} flips"
    )
