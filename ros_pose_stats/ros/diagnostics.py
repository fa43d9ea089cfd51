"""What the node says of its own health, once a second on /diagnostics."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from .messages.times import now, time_message

REMEMBERED = 20
"""Refused meshes listed with their reasons."""

COPY_SECONDS = 2.0
"""The two copies of a latched mesh, and a client that asks again and again, count once."""

RECENT_SECONDS = 60.0
"""A refused mesh is a warning for this long."""


class _Refusal(NamedTuple):
    """One refusal: by the clock that never jumps, and as it is told."""

    at: float
    stamp: int
    source: str
    reason: str


class Refusals:
    """Meshes and counts that were refused, and meshes that were lost."""

    def __init__(self) -> None:
        self._recent: deque[_Refusal] = deque(maxlen=REMEMBERED)
        self._lock = threading.Lock()
        self.refused = 0
        self.overrun = 0

    def refuse(self, source: str, reason: str) -> bool:
        """Note a refusal; False if it is a copy of one just before."""
        with self._lock:
            at = time.monotonic()
            copy = any((one.source, one.reason) == (source, reason)
                       and at - one.at < COPY_SECONDS for one in self._recent)
            if not copy:
                self.refused += 1
                self._recent.append(_Refusal(at, now(), source, reason))
        return not copy

    def lose(self, count: int) -> None:
        """Note meshes that a flood overran."""
        with self._lock:
            self.overrun += count

    def status(self, name: str, parts: int, waiting: int) -> DiagnosticStatus:
        """The meshes' line."""
        with self._lock:
            recent, refused, overrun = list(self._recent), self.refused, self.overrun
        fresh = bool(recent) and time.monotonic() - recent[-1].at < RECENT_SECONDS
        text = f"refused: {recent[-1].source}: {recent[-1].reason}" if fresh else f"{parts} parts"
        values: dict[str, Any] = {"parts": parts, "meshes waiting": waiting, "refused": refused,
                                  "overrun": overrun}
        for place, one in enumerate(reversed(recent)):
            values[f"refused {place}"] = f"{one.stamp / 1e9:.3f} {one.source}: {one.reason}"
        return status(name, fresh, text, values)


def status(name: str, warn: bool, text: str, values: dict[str, Any]) -> DiagnosticStatus:
    """One line with its values."""
    level = DiagnosticStatus.WARN if warn else DiagnosticStatus.OK
    return DiagnosticStatus(
        level=level, name=name, message=text, hardware_id="",
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


class Diagnostics:
    """Gathers the lines.

    Parameters
    ----------
    sources : sequence of callables
        Each gives a `DiagnosticStatus`.
    publish : callable
    """

    def __init__(self, sources: Sequence[Callable[[], DiagnosticStatus]],
                 publish: Callable[[DiagnosticArray], object]) -> None:
        self._sources = sources
        self._publish = publish

    def tick(self) -> None:
        """Publish."""
        message = DiagnosticArray(status=[source() for source in self._sources])
        message.header.stamp = time_message(now())
        self._publish(message)
