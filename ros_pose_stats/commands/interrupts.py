"""Ctrl-C as a request to stop and report, not as an accident."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

INTERRUPTED = 130


@contextmanager
def end_on_interrupt() -> Iterator[None]:
    """End the process at once on SIGINT, while there is nothing to report yet.

    An exception out of the handler may be swallowed by the compiler's callbacks.
    """
    def on_interrupt(_number: int, _frame: FrameType | None) -> None:
        sys.stderr.write("ros_pose_stats: interrupted\n")
        sys.stderr.flush()
        os._exit(INTERRUPTED)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def stop_on_interrupt() -> Iterator[Callable[[], bool]]:
    """Turn the first SIGINT into a flag; a second one interrupts as usual.

    Yields
    ------
    callable
        Tells whether it came.
    """
    asked = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def on_interrupt(_number: int, _frame: FrameType | None) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)
