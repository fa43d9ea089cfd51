"""`simulate PART`: pose statistics by dropping the part many times."""

from __future__ import annotations

import argparse
import json
import sys

from .interrupts import INTERRUPTED, end_on_interrupt, stop_on_interrupt
from .part_options import add_part_options, add_scene_options, part_of
from .progress_bar import ProgressBar
from .slow_start import announce_slow_start

SAMPLINGS = ("random", "lattice")
DEFAULT_DROPS = 10_000


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "simulate", help="drop a part many times and count its poses",
        description="Drop a part many times onto a rigid frictionless plate and count the "
        "poses in which it comes to rest. Ctrl-C stops and reports what has been done.")
    add_part_options(command)
    command.add_argument("--drops", type=int, default=DEFAULT_DROPS, metavar="N",
                         help="how many, or at most where a target error is given "
                         "(default: %(default)s)")
    add_scene_options(command)
    command.add_argument("--target-error", type=float, default=0.0, metavar="E",
                         help="stop once the expected error, as a fraction, is down to this "
                         "(default: all drops)")
    command.add_argument("--seed", type=int, metavar="S",
                         help="the same seed gives the same counts (default: a fresh one)")
    command.add_argument("--workers", type=int, metavar="W", help="threads (default: all cores)")
    command.add_argument("--sampling", choices=SAMPLINGS, default=SAMPLINGS[0],
                         help="starting directions at random, or evenly spread "
                         "(default: %(default)s)")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Simulate and print."""
    with announce_slow_start(), end_on_interrupt():
        from ..simulation import simulate

        part = part_of(options)
        simulate(part, 1, seed=0, workers=1)  # compiles what is not compiled yet
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found = simulate(
            part, options.drops, options.restitution, options.seed, options.drop_height,
            options.target_error, options.workers, options.sampling, on_progress=bar.show,
            should_stop=interrupted, cluster_tolerance=options.cluster_tolerance)
    stopped = interrupted() and found.drops < options.drops
    if options.json:
        extra = {"interrupted": True} if stopped else {}
        json.dump({**found.as_dict(), **extra}, sys.stdout, allow_nan=False)
        print()
    else:
        from .tables import drop_report

        print(drop_report(part, found))
        if stopped:
            print(f"interrupted after {found.drops} of {options.drops} drops")
    return INTERRUPTED if stopped else 0
