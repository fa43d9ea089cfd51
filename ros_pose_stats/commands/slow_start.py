"""A word to the user while the kernels are compiled for the first time."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 2.5  # seconds; a warm start takes about half of it


@contextmanager
def announce_slow_start() -> Iterator[None]:
    """Say what is going on when the body takes longer than a warm start."""
    def announce() -> None:
        print("ros_pose_stats: compiling kernels for this machine; later starts are quick",
              file=sys.stderr)

    timer = threading.Timer(PATIENCE, announce)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
