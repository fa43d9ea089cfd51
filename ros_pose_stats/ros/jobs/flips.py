"""Flips as jobs: how many, for how long, and what is remembered of them."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ...errors import RequestError
from ...records import DropScene, FlipStatistics, Part
from ...resting.poses import poses_in
from ...simulation.drops import DropChunk
from ...simulation.flips import count_flips
from ...simulation.request import Watch, drop_request
from ..parts.memory import Memory
from .job import FlipRequest, Job, JobListener, State
from .run import Ending

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
    """The listener of a queue of flips, which remembers them up to a bound.

    They are not recorded, for a seed gives them again.
    """

    def __init__(self) -> None:
        self._best: Memory[FlipKey, FlipStatistics] = Memory(REMEMBERED, _transitions)
        self._of_jobs: Memory[str, FlipStatistics] = Memory(REMEMBERED, _transitions)
        self.on_progress: Callable[[Job], object] = lambda job: None
        self.on_started: Callable[[Job], object] = lambda job: None
        self.on_end: Callable[[Job], object] = lambda job: None

    def of_job(self, job_id: str) -> FlipStatistics | None:
        """What a job counted, without the poses themselves."""
        return self._of_jobs.get(job_id)

    def best(self, key: FlipKey) -> FlipStatistics | None:
        """The most flips of a key."""
        return self._best.get(key)

    def queued(self, job: Job) -> bool:
        """Nothing to record."""
        return True

    def joined(self, job: Job) -> bool:
        """Nothing to record."""
        return True

    def started(self, job: Job) -> None:
        """Tell goals."""
        self.on_started(job)

    def progressed(self, job: Job) -> None:
        """Tell goals."""
        self.on_progress(job)

    def dropped(self, job: Job, chunk: DropChunk) -> None:
        """Never called: flips are counted, not listed."""

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

    def told(self, job: Job) -> None:
        """Tell whoever waits."""
        self.on_end(job)

    def let_go(self, job_id: str) -> None:
        """What was counted goes when there is no room for it."""


def _transitions(found: FlipStatistics) -> int:
    return int(found.counts.size)


def pose_count(part: Part, scene: DropScene) -> int:
    """Number of a part's poses in a scene."""
    return len(poses_in(part, scene).poses)


def flips_in_all(poses: int, asked: int, settings: Any) -> int:
    """Flips out of all poses, of each as many.

    `asked`: out of each pose; 0: the node's number of drops, shared out. Raises RequestError if
    they are too many, or the poses are.
    """
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
    until = time.monotonic() + request.max_seconds
    scene, ending = request.scene, Ending.COMPLETE
    poses = pose_count(part, scene)
    total = flips_in_all(poses, request.drops, job.settings)

    def should_stop() -> bool:
        nonlocal ending
        if job.cancel_reason:
            ending = Ending.CANCELLED
        elif time.monotonic() > until:
            ending = Ending.OUT_OF_TIME
        elif should_give_way():
            ending = Ending.GAVE_WAY
        return ending is not Ending.COMPLETE

    def on_progress(done: int, _: int) -> None:
        job.drops_done = done
        listener.progressed(job)

    found = count_flips(
        part, scene, request.kick_height,
        drop_request(total // poses, job.seed, 0.0, job.settings.threads()),
        Watch(None, should_stop, background=True), on_progress)
    if found.flips == total:
        return found, Ending.COMPLETE
    if ending is Ending.OUT_OF_TIME:
        late = (f"TIME_LIMIT: ended after {request.max_seconds:g} s with {found.flips} of "
                f"{total} flips.")
        found = replace(found, warnings=(*found.warnings, late))
    return found, ending
