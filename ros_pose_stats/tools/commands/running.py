"""What commands have in common while they run.

A line on the terminal shows the progress. Ctrl-C is a request to stop and report; users are told
when kernels are compiled; and a command checks that it can write its file before it computes
anything.
"""

import argparse
import json
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TextIO

from ...base import errors, files
from .arguments import load_named_part, scene_keywords

if TYPE_CHECKING:
    from ...core.records import DropProgress, Part, PoseStatistics


WIDTH = 24
NARROWEST = 5
COLUMNS = 80
SECONDS_BETWEEN = 0.1
FIRST_AFTER = 0.3  # seconds before a bar appears


class ProgressBar:
    """A progress bar with a text; nothing is drawn unless the stream is a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._watched = stream.isatty()
        self._drawn = 0
        self._begin = time.monotonic()
        self._next = self._begin + FIRST_AFTER

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(self, *_: object) -> None:
        if self._drawn:
            self._stream.write("\r" + " " * self._drawn + "\r")
            self._stream.flush()

    def show(self, progress: "DropProgress") -> None:
        """Draw the state of a simulation, at most ten times a second."""
        share = progress.drops / progress.bound
        if progress.target_error > 0.0 and math.isfinite(progress.error_bound):
            # The error falls with the root of the drops.
            share = max(
                share, min(1.0, (progress.target_error / progress.error_bound) ** 2)
            )
        error = (
            ""
            if math.isnan(progress.expected_error)
            else f", error {100.0 * progress.expected_error:.2f} points"
        )
        self.draw(
            share,
            f"{progress.drops} of {progress.bound} drops, {progress.rate:.0f}/s, "
            f"{duration(progress.seconds_left)} left{error}",
        )

    def show_bytes(self, done: int, total: int) -> None:
        """Draw how many bytes of files have been read, at most ten times a second."""
        left = (time.monotonic() - self._begin) * (total / max(done, 1) - 1.0)
        self.draw(
            done / max(total, 1),
            f"{done / 1e6:.0f} of {total / 1e6:.0f} MB read, {duration(left)} left",
        )

    def draw(self, share: float, text: str) -> None:
        """Draw a bar, filled from 0 to 1, and a text; at most ten times a second."""
        now = time.monotonic()
        if not self._watched or now < self._next:
            return
        self._next = now + SECONDS_BETWEEN
        # Shorter than the terminal is wide; the text alone if that is narrow.
        try:
            columns = os.get_terminal_size(self._stream.fileno()).columns or COLUMNS
        except (OSError, ValueError):
            columns = COLUMNS
        width = min(WIDTH, columns - len(text) - 4)
        bar = ("#" * int(share * width)).ljust(width, ".")
        line = f"[{bar}] {text}" if width >= NARROWEST else text[: columns - 1]
        self._stream.write("\r" + line.ljust(self._drawn))
        self._stream.flush()
        self._drawn = len(line)


def duration(seconds: float) -> str:
    """Seconds in words; NaN as a question mark."""
    if math.isnan(seconds):
        return "?"
    minutes, rest = divmod(math.ceil(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


INTERRUPTED = 130


@contextmanager
def end_on_interrupt() -> Iterator[None]:
    """End at once on SIGINT: the compiler's callbacks may swallow a handler's exception."""

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
    """Turn the first SIGINT into a flag, which is yielded; a second one interrupts as usual."""
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


def compile_missing() -> int:
    """Compile the kernels that are not stored, under a progress bar; how many there were."""
    from ...core.kernels import compilation

    begin = time.monotonic()
    with ProgressBar(sys.stderr) as bar:
        return compilation.compile_missing(
            lambda done, total: bar.draw(
                done / total,
                f"{done} of {total} kernels, {time.monotonic() - begin:.0f} s",
            )
        )


@contextmanager
def announce_slow_start() -> Iterator[None]:
    """Where a kernel is to be compiled in the context, say so and compile all that are missing."""
    from ...core.kernels.compilation import filling_store

    def fill() -> None:
        print(
            "ros_pose_stats: compiling kernels for this machine, once; it takes a minute or two",
            file=sys.stderr,
        )
        compile_missing()

    with filling_store(fill):
        yield


def output_file(name: str, endings: Sequence[str]) -> Path:
    """Path of a file to be written, checked before anything is computed."""
    path = Path(os.path.realpath(name)) if Path(name).is_symlink() else Path(name)
    is_other = path.exists() and not path.is_file()
    if path.suffix.lower() not in endings or is_other:
        raise errors.RequestError(
            f"a file name that ends in {' or '.join(endings)}",
            f"{name!r}{', which is no file' if is_other else ''}",
            f"for instance part{endings[0]}",
        )
    files.refuse_unwritable(path.parent)
    return path


@contextmanager
def needing(package: str) -> Iterator[None]:
    """Import something that needs a package which not everybody has installed."""
    try:
        yield
    except ImportError as error:
        raise errors.RequestError(
            f"the package {package}",
            f"none that can be imported ({error})",
            f"install it with `pip install {package}`",
        ) from error


def print_json(values: Any, *, interrupted: bool = False) -> None:
    """Print an object with its units, or a list of such, on a line.

    `interrupted`: whether Ctrl-C ended what the object is of.
    """
    from ...core.records.plain_values import with_units

    if isinstance(values, dict):
        values = with_units({**values, "interrupted": True} if interrupted else values)
    json.dump(values, sys.stdout, allow_nan=False)
    print()


def print_answer(
    options: argparse.Namespace,
    values: Callable[[], dict[str, Any]],
    lines: Callable[[], Iterable[str]],
    interrupted: str,
) -> int:
    """Print an answer as JSON or in lines, and where Ctrl-C ended it, if so; the exit status."""
    if options.json:
        print_json(values(), interrupted=bool(interrupted))
    else:
        print("\n".join([*lines(), *([interrupted] if interrupted else [])]))
    return INTERRUPTED if interrupted else 0


@contextmanager
def preparing_kernels() -> Iterator[None]:
    """Load parts and what they are computed with, then the kernels of all that was imported."""
    with announce_slow_start(), end_on_interrupt():
        from ...core.kernels.compilation import prepare_kernels

        yield
        prepare_kernels()


def load_part_and_kernels(options: argparse.Namespace) -> "Part":
    """Load the part that the options name, and the kernels of all that follows."""
    with preparing_kernels():
        from ...core import estimators  # noqa: F401 - imported for their kernels
        from ...core.simulation import simulate  # noqa: F401

        return load_named_part(options)


def run_and_report(
    part: "Part",
    simulate: "Callable[..., PoseStatistics]",
    bound: int,
    options: argparse.Namespace,
) -> int:
    """Run a simulation of `bound` drops under a bar and print its answer; the exit status."""
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        answer = simulate(
            part,
            drops=bound,
            target_error=options.target_error or 0.0,
            seed=options.seed,
            workers=options.workers,
            on_progress=bar.show,
            should_stop=interrupted,
            **scene_keywords(options),
        )
    return print_answer(
        options,
        answer.as_dict,
        lambda: [report_table(answer, part, options.each, bool(options.target_error))],
        f"interrupted after {answer.drops} of {bound} drops"
        if interrupted() and answer.drops < bound
        else "",
    )


def report_table(
    found: "PoseStatistics", part: "Part | None", each: bool, explain: bool = False
) -> str:
    """A method's answer, each pose by itself or those that are alike together."""
    from ...core.records.statistics import report
    from ...core.statistics.pose_groups import listed_poses

    return report(found, listed_poses(found, each), part, explain=explain)
