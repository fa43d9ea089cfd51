"""Who is told what happens to jobs."""

from __future__ import annotations

from typing import Protocol

from ...simulation.drops import DropChunk
from .job import Job, State


class JobListener(Protocol):
    """Told what happens to jobs; all but `queued` in the queue's own thread."""

    def queued(self, job: Job) -> bool:
        """Accepted; returns when that is on record, false where it could not be put there."""

    def started(self, job: Job) -> None:
        """Begins to run."""

    def progressed(self, job: Job) -> None:
        """Some twenty times a second while it runs."""

    def dropped(self, job: Job, chunk: DropChunk) -> None:
        """Single drops, in order."""

    def ended(self, job: Job, state: State) -> None:
        """Has ended with `state`, which is seen by others once this has returned."""

    def told(self, job: Job) -> None:
        """The end is there to be seen."""
