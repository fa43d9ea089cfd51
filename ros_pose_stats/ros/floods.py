"""Topics and parts on which far more comes than a cell has use for: said once a minute."""

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
        self._counts: dict[str, tuple[int, int]] = {}  # of this minute, and what is usual
        self._last: dict[str, int] = {}  # what flooded in the minute before

    def count(self, source: str, most: int = MOST_MESSAGES) -> bool:
        """Count one more; return whether that is within what is usual.

        `source`: as it is to be told; `most`: what is usual in a minute.
        """
        with self._lock:
            self._turn()
            if source not in self._counts and len(self._counts) >= MOST_SOURCES:
                return True
            count = self._counts.get(source, (0, most))[0] + 1
            self._counts[source] = count, most
            if count == most + 1 and source not in self._last:
                self._say(f"a flood: more than {most} of {source} within a minute")
        return count <= most

    def current(self) -> dict[str, int]:
        """How many came of each source that floods, in the last whole minute or the present."""
        with self._lock:
            self._turn()
            return {**self._last, **{source: max(count, self._last.get(source, 0))
                                     for source, count in self._floods()}}

    def _floods(self) -> list[tuple[str, int]]:
        return [(source, count) for source, (count, most) in self._counts.items() if count > most]

    def _turn(self) -> None:
        """Begin another minute where one is over, and say what came in that one."""
        passed = time.monotonic() - self._began
        if passed >= MINUTE:
            self._began += passed
            self._last, self._counts = dict(self._floods()), {}
            for source, count in self._last.items():
                self._say(f"a flood: {count} of {source} in the last minute")
