"""SIGINT and SIGTERM as a wish to end, from before ROS is imported."""

import math
import queue
import signal
import threading
import time
from collections.abc import Callable

GLANCE_SECONDS = 0.5  # Python handles signals between waits of its main thread


class StopSignals:
    """Takes the place of what SIGINT and SIGTERM do by default.

    No ``threading.Event``: a handler runs in the thread that waits, maybe in the middle of
    ``Event.wait`` while that holds the lock for which ``Event.set`` then waits for ever.
    """

    def __init__(self) -> None:
        self.asked = False  # whether the process is to end
        self._wishes: queue.SimpleQueue[None] = queue.SimpleQueue()  # whose put may interrupt
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, frame: self.ask())

    def ask(self) -> None:
        """Ask for the end, from any thread."""
        self.asked = True
        self._wishes.put(None)

    def wait(self, seconds: float = math.inf) -> bool:
        """Return whether the end is asked for, as soon as it is or the seconds are over."""
        end = time.monotonic() + seconds
        while not self.asked and (left := end - time.monotonic()) > 0.0:
            try:
                self._wishes.get(timeout=min(GLANCE_SECONDS, left))
            except queue.Empty:
                continue
        return self.asked


def within(seconds: float, act: Callable[[], object]) -> bool:
    """Whether something is done within some seconds; if not it goes on, and nobody waits."""
    done = threading.Event()

    def do() -> None:
        act()
        done.set()

    doing = threading.Thread(target=do, name="end", daemon=True)
    doing.start()
    doing.join(seconds)
    return done.is_set()


def kill_after(seconds: float) -> None:
    """Have the process killed by SIGALRM, which needs no interpreter.

    The end of a DDS participant may spin for ever with the interpreter locked (Fast DDS issue
    6513). Where the signal is somebody else's already, nothing is done.
    """
    if signal.getsignal(signal.SIGALRM) is signal.SIG_DFL:
        signal.setitimer(signal.ITIMER_REAL, seconds)
