"""Meshes and counts that are refused, as the log and diagnostics have them."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, NamedTuple

from ..errors import PoseStatsError
from .floods import Floods
from .messages.times import now

REMEMBERED = 20
"""Refused meshes listed with their reasons."""

COPY_SECONDS = 2.0
"""The two copies of a latched mesh, and a client that asks again and again, count once."""

RECENT_SECONDS = 60.0
"""A refused mesh is a warning for this long."""


class Health(NamedTuple):
    """One line of diagnostics: whether it is a warning, its text, and values by their key."""

    warn: bool
    text: str
    values: dict[str, Any]


class _Refusal(NamedTuple):
    """One refusal: by the clock that never jumps, and as it is told."""

    at: float
    stamp: int
    source: str
    reason: str


class Refusals:
    """Meshes and counts that were refused, meshes that were lost, and floods of either.

    `say`: told each refusal in one line, but for copies and, beyond the usual, of a flood.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        self._say = say
        self.floods = Floods(say)
        self._recent: deque[_Refusal] = deque(maxlen=REMEMBERED)
        self._lock = threading.Lock()
        self.refused = 0
        self.overrun = 0

    def refuse(self, source: str, reason: str, what: str = "mesh") -> None:
        """Count and tell a refusal, unless it is a copy of one just before."""
        with self._lock:
            at = time.monotonic()
            if any((one.source, one.reason) == (source, reason) and at - one.at < COPY_SECONDS
                   for one in self._recent):
                return
            self.refused += 1
            self._recent.append(_Refusal(at, now(), source, reason))
        if self.floods.count("refusals"):
            self._say(f"{source}: {what} refused: {reason}")

    def watch_mesh(self, source: Callable[[], str], coming: Future[Any]) -> None:
        """Have a mesh that turns out to be bad counted as refused.

        `source`: gives where it came from, once it has been looked at.
        """
        def look(done: Future[Any]) -> None:
            error = None if done.cancelled() else done.exception()
            if isinstance(error, PoseStatsError):
                self.refuse(source(), str(error))
            elif error is not None:
                self.refuse(source(), f"internal failure: {type(error).__name__}: {error}")

        coming.add_done_callback(look)

    def count_lost(self, count: int) -> None:
        """Count meshes that a flood overran."""
        with self._lock:
            self.overrun += count

    def health(self, parts: int, waiting: int) -> Health:
        """The line about meshes."""
        with self._lock:
            recent, refused, overrun = list(self._recent), self.refused, self.overrun
        fresh = bool(recent) and time.monotonic() - recent[-1].at < RECENT_SECONDS
        floods = "; ".join(f"{count} of {source} within a minute"
                           for source, count in self.floods.current().items())
        text = f"refused: {recent[-1].source}: {recent[-1].reason}" if fresh else (
            f"a flood: {floods}" if floods else f"{parts} parts")
        values: dict[str, Any] = {"parts": parts, "meshes waiting": waiting, "refused": refused,
                                  "overrun": overrun, "floods": floods or "none"}
        for place, one in enumerate(reversed(recent)):
            values[f"refused {place}"] = f"{one.stamp / 1e9:.3f} {one.source}: {one.reason}"
        return Health(fresh or bool(floods), text, values)
