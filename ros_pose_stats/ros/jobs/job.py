"""One drop simulation: what was asked for, and how far it is."""

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

from ...records import DropProgress, DropScene, FlipStatistics, Part, PoseStatistics
from ...simulation.drops import DropChunk

SNAPSHOT_SECONDS = 0.2
COMBINED_SECONDS = 1.0
"""Between snapshots of drops combined with an estimate, which hold other threads up."""

SNAPSHOT_SHARE = 0.05
"""Snapshots of a part with thousands of poses take at most this share of the time."""


class State(IntEnum):
    """As in `GetDropSimulation`."""

    UNKNOWN = 0
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
    part: Future[Part]  # the mesh may still be on its way through the hull
    seed: int
    settings: Any  # the node's settings when the job was accepted
    state: State = State.QUEUED
    drops_done: int = 0
    expected_error: float = math.nan
    drops_per_second: float = math.nan
    # a recent state while running; the end result afterwards
    snapshot: PoseStatistics | None = None
    flips: FlipStatistics | None = None  # the end result of flips, until it has been told
    message: str = ""  # how it ended
    recorded: bool = True  # whether the acceptance is in the bag and in the state
    asked: bool = False  # whether a client has been told of it, who may rely on that
    finished: Future[None] = field(default_factory=Future)  # done once its end can be seen
    # called when it begins to run, and some twenty times a second from then on
    followers: list[Callable[["Job"], object]] = field(default_factory=list)
    cancel_reason: str = ""
    ending: bool = False  # whether its end is being told; that happens once
    name: str = ""  # of a part that has been let go of
    _next_snapshot: float = 0.0

    @property
    def part_id(self) -> str:
        """Name of the part; of a nameless one, the name it got, once it is there."""
        part = self.built()
        return self.request.part_id or (self.name if part is None else part.part_id)

    def built(self) -> Part | None:
        """The part, if it is there; never waits, also while the job lets go of it."""
        part = self.part
        good = part.done() and not part.cancelled() and part.exception() is None
        return part.result() if good else None

    def cancel(self, reason: str) -> None:
        """Ask the job to end; the first reason stays."""
        self.cancel_reason = self.cancel_reason or reason

    def take(self, progress: DropProgress) -> None:
        """Note how far the run is, and now and then its statistics."""
        self.drops_done, self.expected_error = progress.drops, progress.expected_error
        self.drops_per_second = progress.rate
        now = time.monotonic()
        if now < self._next_snapshot:
            return
        self.snapshot = progress.statistics()
        took = time.monotonic() - now
        pause = COMBINED_SECONDS if self.request.hybrid else SNAPSHOT_SECONDS
        self._next_snapshot = now + max(pause, took / SNAPSHOT_SHARE)

    def tell_followers(self) -> None:
        """Have whoever follows the job see how far it is."""
        for follow in tuple(self.followers):
            follow(self)

    def release(self) -> None:
        """Let go of the part and of what refers to it: a thousand ended jobs are kept."""
        self.name = self.part_id
        self.part = Future()
        self.snapshot = self.flips = None
        self.followers.clear()

    def keep(self, outcome: PoseStatistics | FlipStatistics) -> None:
        """Note the end result."""
        if isinstance(outcome, FlipStatistics):
            self.flips, self.drops_done = outcome, outcome.flips
            return
        self.snapshot, self.drops_done = outcome, outcome.drops
        self.expected_error = outcome.expected_error


class JobListener:
    """Keeps what happens to jobs; all but the first two are called in the queue's own thread."""

    def queued(self, job: Job) -> bool:
        """Accepted; returns when that is kept and on record, false where it cannot be."""
        return True

    def joined(self, job: Job) -> bool:
        """A client asked for what the node had begun by itself; returns as `queued` does."""
        return True

    def started(self, job: Job) -> None:
        """Begins to run."""

    def progressed(self, job: Job) -> None:
        """Some twenty times a second while it runs."""

    def dropped(self, job: Job, chunk: DropChunk) -> None:
        """Single drops, in order."""

    def ended(self, job: Job, state: State) -> None:
        """Has ended with `state`, which is seen by others once this has returned."""

    def let_go(self, job_id: str) -> None:
        """Nobody can ask for it any more."""
