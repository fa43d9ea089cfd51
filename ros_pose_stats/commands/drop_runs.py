"""What the commands that drop a part share: options, a run that Ctrl-C ends, its report."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from .arguments import part_of, read_count
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


class DropRun(NamedTuple):
    """How a run tells its progress, and hears that it is to stop."""

    on_progress: Callable[[DropProgress], object]
    should_stop: Callable[[], bool]


def add_drop_options(command: argparse.ArgumentParser, drops: int | None) -> None:
    """Add how many drops, up to which error, from which seed, on how many threads.

    Parameters
    ----------
    command : argparse.ArgumentParser
    drops : int or None
        The default; None where a command must know whether it was given.
    """
    shown = "10000 for hybrid, no bound for auto" if drops is None else drops
    command.add_argument("--drops", type=read_count, default=drops, metavar="N",
                         help="number of drops, or the most where a target error is given "
                         f"(default: {shown})")
    command.add_argument("--target-error", type=float, default=None if drops is None else 0.0,
                         metavar="E", help="stop once the expected error is down to this "
                         "fraction; 0.01 is one percentage point (default: none)")
    command.add_argument("--seed", type=read_count, metavar="S",
                         help="the same seed gives the same counts (default: a fresh one, "
                         "which is printed)")
    command.add_argument("--workers", type=read_count, metavar="W",
                         help="number of threads (default: all cores)")


def warm_part(options: argparse.Namespace, *, drops: bool = True) -> Part:
    """The part that the options name, with the kernels of all that follows loaded.

    Parameters
    ----------
    options : argparse.Namespace
    drops : bool
        Whether the part is to be dropped.
    """
    with announce_slow_start(), end_on_interrupt():
        from ..estimators import estimate  # noqa: F401 - imported for their kernels
        from ..kernels.compilation import prepare_kernels
        from ..resting import poses  # noqa: F401

        if drops:
            from ..simulation import simulate  # noqa: F401
        part = part_of(options)
        prepare_kernels()
    return part


def run_drops(part: Part, start: Callable[[DropRun], PoseStatistics], bound: int, *,
              as_json: bool) -> int:
    """Run, with a bar where somebody watches, and print; returns the exit status.

    Parameters
    ----------
    part : Part
    start : callable
        Runs the drops.
    bound : int
        Drops that make it whole.
    as_json : bool
        Print one JSON object, not a table.
    """
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found = start(DropRun(bar.show, interrupted))
    stopped = interrupted() and found.drops < bound
    if as_json:
        extra = {"interrupted": True} if stopped else {}
        print_json({**found.as_dict(), **extra})
    else:
        from .tables import report

        print(report(part, found))
        if stopped:
            print(f"interrupted after {found.drops} of {bound} drops")
    return INTERRUPTED if stopped else 0
