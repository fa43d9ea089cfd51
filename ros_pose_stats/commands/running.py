"""What commands have in common while they run.

Ctrl-C is a request to stop and report; users are told when kernels are compiled; and a command
checks that it can write its file before it computes anything.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from ..errors import RequestError
from ..files import refuse_unwritable

INTERRUPTED = 130


@contextmanager
def end_on_interrupt() -> Iterator[None]:
    """End the process at once on SIGINT, while there is nothing to report yet.

    An exception from the handler might get lost in the compiler's callbacks.
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

    Yields returns whether SIGINT came.
    """
    asked: list[int] = []  # a handler must not wait for a lock, as Event.set does
    before = signal.getsignal(signal.SIGINT)

    def on_interrupt(number: int, _frame: FrameType | None) -> None:
        asked.append(number)
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: bool(asked)
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def announce_slow_start() -> Iterator[None]:
    """Print a note, once, when a kernel is compiled in the context."""
    from ..kernels.compilation import watch_compilations

    told: list[str] = []

    def announce(kernel: str) -> None:
        if not told:
            print("ros_pose_stats: compiling kernels for this machine; later starts are quick "
                  "(`ros_pose_stats compile` does all at once)", file=sys.stderr)
        told.append(kernel)

    with watch_compilations(announce):
        yield


def output_file(name: str, endings: Sequence[str]) -> Path:
    """Path of a file to be written, checked before anything is computed.

    Raises RequestError if its ending is none of those expected, it is a folder, or its folder
    cannot be written to.
    """
    path = Path(name)
    if path.suffix.lower() not in endings or path.is_dir():
        raise RequestError(f"a file name that ends in {' or '.join(endings)}", f"{name!r}",
                           f"for instance part{endings[0]}")
    refuse_unwritable(path.parent)
    return path


@contextmanager
def needing(package: str) -> Iterator[None]:
    """Import something that needs a package which not everybody has installed.

    Raises RequestError if it cannot be imported.
    """
    try:
        yield
    except ImportError as error:
        raise RequestError(f"the package {package}", f"none that can be imported ({error})",
                           f"install it with `pip install {package}`") from error


def print_json(values: Any) -> None:
    """Print one object or list on a line; NaN and infinity are refused."""
    json.dump(values, sys.stdout, allow_nan=False)
    print()
