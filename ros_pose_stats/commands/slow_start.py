"""A word to the user while kernels are compiled."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def announce_slow_start() -> Iterator[None]:
    """Say what is going on, once, when the body compiles a kernel."""
    from ..kernels.compilation import watch_compilations

    told: list[str] = []

    def announce(kernel: str) -> None:
        if not told:
            print("ros_pose_stats: compiling kernels for this machine; later starts are quick "
                  "(`ros_pose_stats compile` does all at once)", file=sys.stderr)
        told.append(kernel)

    with watch_compilations(announce):
        yield
