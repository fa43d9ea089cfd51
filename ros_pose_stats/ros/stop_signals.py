"""SIGINT and SIGTERM as a wish to end, from before ROS is imported."""

from __future__ import annotations

import queue
import signal
from types import FrameType

GLANCE_SECONDS = 0.5
"""Python handles signals between waits of its main thread."""


class StopSignals:
    """Takes the place of what SIGINT and SIGTERM do by default.

    Attributes
    ----------
    asked : bool
        Whether the process is to end.
    """

    def __init__(self) -> None:
        self.asked = False
        self._wishes: queue.SimpleQueue[None] = queue.SimpleQueue()  # whose put may interrupt
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self.ask()

    def ask(self) -> None:
        """Ask for the end, from any thread."""
        self.asked = True
        self._wishes.put(None)

    def wait(self) -> None:
        """Return once the end is asked for."""
        while not self.asked:
            try:
                self._wishes.get(timeout=GLANCE_SECONDS)
            except queue.Empty:
                continue
