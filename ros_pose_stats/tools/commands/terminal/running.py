# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What commands have in common while they run.

A line on the terminal shows the progress. Ctrl-C is a request to stop and report; users
are told when kernels are compiled; and a command checks that it can write its file
before it computes anything.
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
from typing import TYPE_CHECKING, Any

from ....base import errors, extras, files, text
from .arguments import scene_keywords

if TYPE_CHECKING:
    from ....core.records import DropProgress, Part, PoseStatistics


BAR_WIDTH = 24
NARROWEST_BAR = 5
TERMINAL_WIDTH = 80  # where the terminal does not say
REDRAW_SECONDS = 0.1
FIRST_DRAW_SECONDS = 0.3
WAITING_SECONDS = 2.0  # of a task without progress, before a line says what it is
LONGEST_NAME = 40


class ProgressBar:
    """A progress bar with a text, on standard error where that is a terminal."""

    def __init__(self) -> None:
        self._is_terminal = sys.stderr.isatty()
        self._line_length = 0
        self._begin = time.monotonic()
        self._next_draw = self._begin + FIRST_DRAW_SECONDS

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(self, *_: object) -> None:
        if self._line_length:
            _rewrite_line(" " * self._line_length + "\r")

    def show(self, progress: "DropProgress") -> None:
        """Draw the state of a simulation, at most ten times a second."""
        share = progress.drops / progress.bound
        if progress.target_error > 0.0 and math.isfinite(progress.error_bound):
            # The error falls with the root of the drops.
            share_of_target = (progress.target_error / progress.error_bound) ** 2
            share = max(share, min(1.0, share_of_target))
        text = (
            f"{progress.drops} of {progress.bound} drops, {progress.rate:.0f}/s, "
            f"{duration(progress.seconds_left)} left"
        )
        if not math.isnan(progress.expected_error):
            text += f", error {100.0 * progress.expected_error:.2f} points"
        self.draw(share, text)

    def show_bytes(self, count: int, total: int) -> None:
        """Draw how many bytes of files have been read, at most ten times a second."""
        seconds = (time.monotonic() - self._begin) * (total / max(count, 1) - 1.0)
        self.draw(
            count / max(total, 1),
            f"{count / 1e6:.0f} of {total / 1e6:.0f} MB read, {duration(seconds)} left",
        )

    def draw(self, share: float, text: str) -> None:
        """Draw a bar, filled from 0 to 1, and a text; at most ten times a second."""
        now = time.monotonic()
        if not self._is_terminal or now < self._next_draw:
            return
        self._next_draw = now + REDRAW_SECONDS
        line = self._line(share, text)
        _rewrite_line(line.ljust(self._line_length))
        self._line_length = len(line)

    @staticmethod
    def _line(share: float, text: str) -> str:
        """Bar and text, narrower than the terminal; in a narrow one the text."""
        try:
            columns = os.get_terminal_size(sys.stderr.fileno()).columns
        except (OSError, ValueError):
            columns = 0
        columns = columns or TERMINAL_WIDTH
        width = min(BAR_WIDTH, columns - len(text) - 4)
        if width < NARROWEST_BAR:
            return text[: columns - 1]
        bar = ("#" * int(share * width)).ljust(width, ".")
        return f"[{bar}] {text}"


def _rewrite_line(line: str) -> None:
    print(f"\r{line}", end="", file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Seconds in words; NaN as a question mark."""
    if math.isnan(seconds):
        return "?"
    minutes, whole_seconds = divmod(math.ceil(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    if minutes:
        return f"{minutes} min {whole_seconds:02d} s"
    return f"{whole_seconds} s"


INTERRUPTED = 130


@contextmanager
def end_on_interrupt() -> Iterator[None]:
    """End at once on SIGINT: callbacks of the compiler may swallow an exception."""

    def on_interrupt(_number: int, _frame: FrameType | None) -> None:
        print("ros_pose_stats: interrupted", file=sys.stderr, flush=True)
        os._exit(INTERRUPTED)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)


@contextmanager
def stop_on_interrupt() -> Iterator[Callable[[], bool]]:
    """Turn the first SIGINT into a flag, which is yielded; a second one interrupts."""
    # A handler must not wait for a lock, as Event.set does.
    interrupts: list[int] = []
    handler = signal.getsignal(signal.SIGINT)

    def on_interrupt(number: int, _frame: FrameType | None) -> None:
        interrupts.append(number)
        signal.signal(signal.SIGINT, handler)

    signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: bool(interrupts)
    finally:
        signal.signal(signal.SIGINT, handler)


def compile_missing() -> int:
    """Compile kernels that are not stored, under a bar; how many there were."""
    from ....core.kernels import compilation

    begin = time.monotonic()

    with ProgressBar() as bar:

        def show(count: int, total: int) -> None:
            seconds = time.monotonic() - begin
            bar.draw(count / total, f"{count} of {total} kernels, {seconds:.0f} s")

        return compilation.compile_missing(show)


@contextmanager
def announce_slow_start() -> Iterator[None]:
    """Where the context needs a kernel that is not stored, say so and compile all."""
    from ....core.kernels import compilation

    def fill() -> None:
        print(f"ros_pose_stats: {compilation.announcement()}", file=sys.stderr)
        compile_missing()

    with compilation.filling_store(fill):
        yield


def output_file(name: str, endings: Sequence[str]) -> Path:
    """Path of a file to be written, checked before anything is computed."""
    path = Path(os.path.realpath(name)) if Path(name).is_symlink() else Path(name)
    is_occupied = path.exists() and not path.is_file()
    if path.suffix.lower() not in endings or is_occupied:
        raise errors.RequestError(
            f"a file name that ends in {' or '.join(endings)}",
            f"{name!r}{', which is no file' if is_occupied else ''}",
            f"for instance part{endings[0]}",
        )
    files.refuse_unwritable(path.parent)
    return path


def page_file(name: str) -> Path:
    """Path of a page to be written, checked; the modules that pages need are there."""
    path = output_file(name, (".html", ".htm"))
    extras.require_modules("jinja2", "matplotlib", "PIL")
    return path


def picture_file(name: str | None) -> Path | None:
    """Path of a picture to be written, if any; as of a page."""
    if name is None:
        return None
    path = output_file(name, (".png",))
    extras.require_modules("matplotlib", "PIL")
    return path


def describe_size(file: Path) -> str:
    """A file that was written, and its size."""
    return f"{text.printable(str(file))}: {file.stat().st_size / 1e6:.2f} MB"


def print_json(values: Any, *, interrupted: bool = False) -> None:
    """Print an object with its units, or a list of such, on a line.

    `interrupted`: whether Ctrl-C ended what the object is of.
    """
    from ....core.records.plain_values import with_units

    if isinstance(values, dict):
        values = with_units({**values, "interrupted": True} if interrupted else values)
    json.dump(values, sys.stdout, allow_nan=False)
    print()


def print_answer(
    options: argparse.Namespace,
    values: dict[str, Any],
    lines: Iterable[str],
    interruption: str,
) -> int:
    """Print an answer as JSON or in lines, and return the exit status.

    `interruption`: where Ctrl-C ended the work; empty where it did not.
    """
    if options.json:
        print_json(values, interrupted=bool(interruption))
    else:
        print(*lines, sep="\n")
        if interruption:
            print(interruption)
    return INTERRUPTED if interruption else 0


@contextmanager
def preparing_kernels() -> Iterator[None]:
    """Load parts and modules in the context, and then the kernels of these modules."""
    with announce_slow_start(), end_on_interrupt():
        from ....core.kernels.compilation import prepare_kernels

        yield
        prepare_kernels()


@contextmanager
def name_slow_task(task: str) -> Iterator[None]:
    """Where the context takes seconds, tell a terminal what it does, and for how long.

    For what cannot say how far it is.
    """
    if not sys.stderr.isatty():
        yield
        return
    begin = time.monotonic()
    is_over = threading.Event()

    def show() -> None:
        line = ""
        pause = WAITING_SECONDS
        while not is_over.wait(pause):
            line = f"{task}, {time.monotonic() - begin:.0f} s"
            _rewrite_line(line)
            pause = 1.0
        if line:
            _rewrite_line(" " * len(line) + "\r")

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def load_named_part(options: argparse.Namespace) -> "Part":
    """Load the part that the options name."""
    from ....core.mesh import files as mesh_files, mass_properties, parts
    from ....core.mesh.bodies import separation

    name = text.shortened(text.printable(Path(options.part).name), LONGEST_NAME)
    # Reading alone: what follows may compile kernels, under a line of its own.
    with name_slow_task(f"reading {name}"):
        mesh = mesh_files.read_mesh(options.part, options.unit)
    return parts.part_of_file(
        mesh,
        mass_properties.check_properties(
            options.com, options.mass, None, options.density
        ),
        text.printable(Path(options.part).stem),
        separation.check_choice(options.body),
        accept_open=options.accept_open,
    )


def load_part_and_kernels(options: argparse.Namespace) -> "Part":
    """Load the part that the options name, and the kernels of all that follows."""
    with preparing_kernels():
        from ....core import estimators  # noqa: F401 - imported for their kernels
        from ....core.simulation import simulate  # noqa: F401

        return load_named_part(options)


def run_and_report(
    part: "Part",
    simulate: "Callable[..., PoseStatistics]",
    bound: int,
    options: argparse.Namespace,
) -> int:
    """Run a simulation of `bound` drops under a bar and print it; the exit status."""
    with stop_on_interrupt() as is_interrupted, ProgressBar() as bar:
        statistics = simulate(
            part,
            drops=bound,
            target_error=options.target_error or 0.0,
            seed=options.seed,
            workers=options.workers,
            on_progress=bar.show,
            should_stop=is_interrupted,
            **scene_keywords(options),
        )
    interruption = ""
    if is_interrupted() and statistics.drops < bound:
        interruption = f"interrupted after {statistics.drops} of {bound} drops"
    table = report_table(statistics, part, options.each, bool(options.target_error))
    return print_answer(options, statistics.as_dict(), [table], interruption)


def report_table(
    statistics: "PoseStatistics",
    part: "Part | None",
    each_pose: bool,
    explain: bool = False,
) -> str:
    """A method's answer, each pose by itself or those that are alike together."""
    from ....core.records.statistics import report
    from ....core.statistics.model_gap import describe_use
    from ....core.statistics.pose_groups import list_poses

    poses = list_poses(statistics, each_pose)
    table = report(statistics, poses, part, explain=explain)
    return "\n".join([table, describe_use(statistics)]).rstrip()
