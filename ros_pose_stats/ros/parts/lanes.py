"""The lanes in which meshes wait."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

from ...mesh.overlap import TakesLongError

LAST_SECONDS = 0.5
"""What is in hand may be finished for so long when the queue is closed."""


class Pace(IntEnum):
    """How much time a lane has for one task."""

    QUICK = 0
    """Moments: it is done in the node."""

    MIDDLE = 1
    """A try, in a process."""

    SLOW = 2
    """All that a mesh may take, in another process."""


class Rank(IntEnum):
    """What goes first in a lane."""

    URGENT = 0
    MESH = 1
    LATER = 2


@dataclass(eq=False)
class Task:
    """Something to do."""

    work: Callable[[], Any]
    size: int  # bytes that it holds on to
    part_id: str  # empty: of no name
    pace: Pace  # the first lane in which it may be done
    rank: Rank
    future: Future[Any] = field(default_factory=Future)  # of what comes of it
    lane: Pace = Pace.QUICK  # in which it waits

    def do(self, pace: Pace) -> bool:
        """Do it; what comes of it belongs to whoever asked, if they still wait.

        Returns false where it needs more time than its lane has.
        """
        try:
            found = self.work()
        except BaseException as error:
            if isinstance(error, TakesLongError) and pace is not Pace.SLOW:
                return False
            with suppress(InvalidStateError):
                self.future.set_exception(error)
        else:
            with suppress(InvalidStateError):  # the queue was closed just now
                self.future.set_result(found)
        return True


class Lane:
    """Tasks that wait, and the one in hand.

    Attributes `waiting`: by rank.
    """

    def __init__(self, pace: Pace) -> None:
        self.pace = pace
        self.waiting: tuple[deque[Task], ...] = tuple(deque() for _ in Rank)
        self.in_hand: Task | None = None

    def pop(self) -> Task | None:
        """The next task, taken out; none where none waits."""
        return next((tasks.popleft() for tasks in self.waiting if tasks), None)

    def ended(self, thread: threading.Thread) -> bool:
        """Whether the lane's thread ends soon; if not, nobody waits for what is in hand."""
        if thread.is_alive():
            thread.join(timeout=LAST_SECONDS)
        in_hand = self.in_hand
        if thread.is_alive() and in_hand is not None:
            in_hand.future.cancel()
        return not thread.is_alive()
