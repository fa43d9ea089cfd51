"""What commands have in common while they run.

Ctrl-C is a request to stop and report; users are told when kernels are compiled; and a command
checks that it can write its file before it computes anything.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from ..errors import RequestError
from ..whole_files import refuse_unwritable
from .arguments import load_named_part, scene_of
from .progress_bar import ProgressBar

if TYPE_CHECKING:
    from ..records import Part, PoseStatistics

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

    Yields a function that says whether SIGINT came.
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

    compiled: list[str] = []

    def announce(kernel: str) -> None:
        if not compiled:
            print("ros_pose_stats: compiling kernels for this machine; later starts are quick "
                  "(`ros_pose_stats compile` does all at once)", file=sys.stderr)
        compiled.append(kernel)

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


def print_json(values: Any, *, interrupted: bool = False) -> None:
    """Print one object or list on a line; NaN and infinity are refused.

    `interrupted`: whether the object is to say that it is what was done until Ctrl-C.
    """
    json.dump({**values, "interrupted": True} if interrupted else values, sys.stdout,
              allow_nan=False)
    print()


def load_part_and_kernels(options: argparse.Namespace, *, drops: bool = True) -> Part:
    """Load the part that the options name, and the kernels of all that follows.

    `drops`: whether the part is to be dropped.
    """
    with announce_slow_start(), end_on_interrupt():
        from ..estimators import estimate  # noqa: F401 - imported for their kernels
        from ..kernels.compilation import prepare_kernels
        from ..resting import poses  # noqa: F401

        if drops:
            from ..simulation import simulate  # noqa: F401
        part = load_named_part(options)
        prepare_kernels()
    return part


def run_and_report(part: Part, simulate: Callable[..., PoseStatistics], bound: int,
                   options: argparse.Namespace) -> int:
    """Run a simulation under a progress bar and print its answer; returns the exit status.

    `bound`: number of drops after which it is complete.
    """
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        answer = simulate(part, drops=bound, target_error=options.target_error or 0.0,
                          seed=options.seed, workers=options.workers, on_progress=bar.show,
                          should_stop=interrupted, **scene_of(options))
    stopped = interrupted() and answer.drops < bound
    if options.json:
        print_json(answer.as_dict(), interrupted=stopped)
    else:
        from .tables import report

        print(report(part, answer, each=options.each))
        if stopped:
            print(f"interrupted after {answer.drops} of {bound} drops")
    return INTERRUPTED if stopped else 0
