"""What the commands that drop a part share: options, loading, a run with a bar, and its report."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from .arguments import load_named_part, read_count
from .progress_bar import ProgressBar
from .running import (
    INTERRUPTED,
    announce_slow_start,
    end_on_interrupt,
    print_json,
    stop_on_interrupt,
)

if TYPE_CHECKING:
    from ..records import DropProgress, Part, PoseStatistics


class RunCallbacks(NamedTuple):
    """The callbacks of one simulation: it reports its progress, and asks whether to stop."""

    on_progress: Callable[[DropProgress], object]
    should_stop: Callable[[], bool]


def add_drop_options(command: argparse.ArgumentParser, drops: int | None) -> None:
    """Add the number of drops, the target error, the seed and the number of threads.

    `drops`: the default; None where a command must know whether it was given.
    """
    shown = "10000 for hybrid, no bound for auto" if drops is None else drops
    command.add_argument("--drops", type=read_count, default=drops, metavar="N",
                         help="number of drops, or the most where a target error is given "
                         f"(default: {shown})")
    command.add_argument("--target-error", type=float, default=None if drops is None else 0.0,
                         metavar="E", help="stop once the root mean square error over "
                         "the poses is within this fraction with 90 %% confidence; 0.01 is one "
                         "percentage point (default: none)")
    command.add_argument("--seed", type=read_count, metavar="S",
                         help="the same seed gives the same counts (default: a fresh one, "
                         "which is printed)")
    command.add_argument("--workers", type=read_count, metavar="W",
                         help="number of threads (default: all cores)")


def add_table_options(command: argparse.ArgumentParser, more: str = "") -> None:
    """Add how the answer is printed.

    `more`: what else is to be said about the JSON.
    """
    command.add_argument("--each", action="store_true",
                         help="give every pose a row of its own; else poses that the part's "
                         "symmetry makes alike share one, with their number and total")
    command.add_argument("--json", action="store_true",
                         help=f"print one JSON object{more}, with every pose")


def load_part_and_kernels(options: argparse.Namespace) -> Part:
    """Load the part that the options name, and the kernels of all that follows."""
    with announce_slow_start(), end_on_interrupt():
        from ..estimators import estimate  # noqa: F401 - imported for their kernels
        from ..kernels.compilation import prepare_kernels
        from ..simulation import simulate  # noqa: F401

        part = load_named_part(options)
        prepare_kernels()
    return part


def run_and_report(part: Part, start: Callable[[RunCallbacks], PoseStatistics], bound: int,
                   options: argparse.Namespace) -> int:
    """Run a simulation under a progress bar and print its answer; returns the exit status.

    `bound`: number of drops after which it is complete.
    """
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found = start(RunCallbacks(bar.show, interrupted))
    stopped = interrupted() and found.drops < bound
    if options.json:
        extra = {"interrupted": True} if stopped else {}
        print_json({**found.as_dict(), **extra})
    else:
        from .tables import report

        print(report(part, found, each=options.each))
        if stopped:
            print(f"interrupted after {found.drops} of {bound} drops")
    return INTERRUPTED if stopped else 0
