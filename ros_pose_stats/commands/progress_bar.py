"""A line on the terminal that shows the progress of a simulation, or of reading a bag."""

from __future__ import annotations

import math
import os
import time
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from ..records import DropProgress

WIDTH = 24
NARROWEST = 5
COLUMNS = 80
SECONDS_BETWEEN = 0.1
FIRST_AFTER = 0.3
"""Seconds before a bar appears."""


class ProgressBar:
    """A progress bar with a text; nothing is drawn unless the stream is a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._watched = stream.isatty()
        self._drawn = 0
        self._begin = time.monotonic()
        self._next = self._begin + FIRST_AFTER

    def __enter__(self) -> ProgressBar:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._drawn:
            self._stream.write("\r" + " " * self._drawn + "\r")
            self._stream.flush()

    def _columns(self) -> int:
        try:
            return os.get_terminal_size(self._stream.fileno()).columns or COLUMNS
        except (OSError, ValueError):
            return COLUMNS

    def show(self, progress: DropProgress) -> None:
        """Draw the state of a simulation, at most ten times a second."""
        self.draw(*drops_done(progress))

    def show_bytes(self, done: int, total: int) -> None:
        """Draw how many bytes of files have been read, at most ten times a second."""
        left = (time.monotonic() - self._begin) * (total / max(done, 1) - 1.0)
        self.draw(done / max(total, 1), f"{done / 1e6:.0f} of {total / 1e6:.0f} MB read, "
                  f"{duration(left)} left")

    def draw(self, share: float, text: str) -> None:
        """Draw a bar, filled from 0 to 1, and a text; at most ten times a second."""
        now = time.monotonic()
        if not self._watched or now < self._next:
            return
        self._next = now + SECONDS_BETWEEN
        line = bar_line(share, text, self._columns())
        self._stream.write("\r" + line.ljust(self._drawn))
        self._stream.flush()
        self._drawn = len(line)


def drops_done(progress: DropProgress) -> tuple[float, str]:
    """Progress of a simulation, as a share and as a text."""
    share = progress.drops / progress.bound
    if progress.target_error > 0.0 and math.isfinite(progress.error_bound):
        # The error falls with the root of the drops.
        share = max(share, min(1.0, (progress.target_error / progress.error_bound) ** 2))
    error = ("" if math.isnan(progress.expected_error)
             else f", error {100.0 * progress.expected_error:.2f} points")
    return share, (f"{progress.drops} of {progress.bound} drops, {progress.rate:.0f}/s, "
                   f"{duration(progress.seconds_left)} left{error}")


def bar_line(share: float, text: str, columns: int = COLUMNS) -> str:
    """Bar and text in a line shorter than the terminal is wide; the text alone if narrow."""
    width = min(WIDTH, columns - len(text) - 4)
    if width < NARROWEST:
        return text[:columns - 1]
    bar = ("#" * int(share * width)).ljust(width, ".")
    return f"[{bar}] {text}"


def duration(seconds: float) -> str:
    """Seconds in words; NaN as a question mark."""
    if math.isnan(seconds):
        return "?"
    minutes, rest = divmod(math.ceil(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
