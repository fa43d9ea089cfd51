"""Topics and parts on which far more comes than a cell has use for: said once a minute."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

MINUTE: Final = 60.0

MOST_MESSAGES: Final = 600
"""Of one topic in a minute; ten a second."""

MOST_SWAPS: Final = 60
"""Meshes that take each other's place as one part in a minute."""

MOST_SOURCES: Final = 1000
"""Sources that are counted in one minute; a flood of new names is one of their topic."""


class Floods:
    """Counts what comes from each source, minute by minute.

    `say`: told when a flood begins and, while it lasts, once a minute how many there were.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        self._say = say
        self._lock = threading.Lock()
        self._began = time.monotonic()
        self._counts: dict[str, int] = {}
        self._most: dict[str, int] = {}
        self._last: dict[str, int] = {}

    def count(self, source: str, most: int = MOST_MESSAGES) -> bool:
        """Count one more; return whether that is within what is usual.

        `source`: as it is to be told; `most`: what is usual in a minute.
        """
        with self._lock:
            told = self._turn()
            if source in self._counts or len(self._counts) < MOST_SOURCES:
                self._counts[source] = self._counts.get(source, 0) + 1
                self._most[source] = most
            count = self._counts.get(source, 0)
            if count == most + 1 and source not in self._last:
                told.append(f"a flood: more than {most} of {source} within a minute")
        for line in told:
            self._say(line)
        return count <= most

    def current(self) -> dict[str, int]:
        """How many came of each source that floods, in the last whole minute or the present."""
        with self._lock:
            told = self._turn()
            found = {**self._last, **{source: max(count, self._last.get(source, 0))
                                      for source, count in self._counts.items()
                                      if count > self._most[source]}}
        for line in told:
            self._say(line)
        return found

    def _turn(self) -> list[str]:
        """Begin another minute where one is over; return what is to be told of that one."""
        passed = time.monotonic() - self._began
        if passed < MINUTE:
            return []
        self._began += passed
        self._last = {source: count for source, count in self._counts.items()
                      if count > self._most[source]}
        self._counts, self._most = {}, {}
        return [f"a flood: {count} of {source} in the last minute"
                for source, count in self._last.items()]
