"""`catalogue FOLDER|FILE... -o DIR`: all parts of a folder in one table and on one page."""

import argparse
import sys
import time
from typing import TYPE_CHECKING

from ...base.text import printable, several
from . import arguments as given, running

if TYPE_CHECKING:
    from ..catalogue.making import Catalogue, CatalogueProgress

NAMED = 10  # refused parts that are named on the terminal


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "catalogue",
        help="list the poses of all parts of a folder, in a table and on a page",
        description="Look at every part of some folders and files: its stable poses, their "
        "probabilities with errors, footprint and height, how well it feeds, warnings, and, where "
        "a part is refused, why. The folder of -o gets `index.html`, to sort and filter without "
        "a network, `catalogue.csv` with a row a part and `poses.csv` with a row a pose. A run "
        "that is cut off goes on when the same command is given again, and looks at new and "
        "changed files only.",
        examples=(
            "ros_pose_stats catalogue demo --unit mm -o quotes",
            "ros_pose_stats catalogue demo/clamp.stl demo/gear.stl --unit mm "
            "--target-error 0.02 -o dropped --json",
        ),
        run=run,
    )
    command.add_argument(
        "parts",
        metavar="PART",
        nargs="+",
        help="files, or folders with all that is below them: STEP, STL, OBJ, "
        "PLY, OFF or 3MF",
    )
    given.add(
        command,
        "--output",
        required=True,
        metavar="DIR",
        help="folder of the catalogue, created where it is missing",
    )
    command.add_argument(
        "--target-error",
        type=float,
        default=0.0,
        metavar="E",
        help="after the estimates, drop those parts whose estimate is not within "
        "this root mean square error over the poses with 90 %% confidence; 0.01 "
        "is one percentage point (default: 0.02 for parts unlike those that the "
        "estimate was measured on, none for others)",
    )
    given.add(command, "--unit", help=given.SHARED_UNIT)
    given.add(command, "--density", *given.POSES_OF, *given.SCENE)
    command.add_argument(
        "--parquet",
        action="store_true",
        help="write the tables as Parquet files, too; that needs pyarrow",
    )
    where = command.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=given.read_count,
        metavar="W",
        help="number of processes (default: all cores)",
    )
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of a dask.distributed cluster that does the work instead; "
        "files are sent to it",
    )
    given.add(
        command,
        "--json",
        help="print one JSON object that says what was written and refused, with all rows",
    )


def run(options: argparse.Namespace) -> int:
    """Make the catalogue and say where it is."""
    folder = given.folder(options.output)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...core.kernels.compilation import prepare_kernels
        from ..catalogue import making, request as requests, store

        request = requests.CatalogueRequest(
            given.scene_of(options), options.unit, options.density, options.target_error
        )
        if options.scheduler is None:
            maker = making.on_processes(options.workers)
        else:
            with running.needing("distributed"):
                maker = making.on_cluster(options.scheduler)
        if options.parquet:
            with running.needing("pyarrow"):
                store.load_parquet()
        parts = requests.find_parts(options.parts)
        if options.scheduler is None:
            prepare_kernels()  # before several processes would compile them at once
    begin = time.monotonic()
    with (
        running.stop_on_interrupt() as interrupted,
        running.ProgressBar(sys.stderr) as bar,
    ):
        made = making.make_catalogue(
            folder,
            parts,
            request,
            maker,
            parquet=options.parquet,
            keep_rows=options.json,
            on_progress=lambda one: bar.draw(*done(one)),
            should_stop=interrupted,
        )
    (_print_json if options.json else _print_words)(made, time.monotonic() - begin)
    return 0 if made.complete else running.INTERRUPTED


def done(progress: "CatalogueProgress") -> tuple[float, str]:
    """How far the run is, as a share and as a text."""
    own = progress.parts - progress.found
    left = (
        (progress.bound - progress.parts) * progress.seconds / own
        if own
        else float("nan")
    )
    return (
        progress.parts / progress.bound,
        f"{progress.parts} of {progress.bound} parts "
        f"{'sure' if progress.dropping else 'estimated'}, {running.duration(left)} left",
    )


def _print_json(made: "Catalogue", seconds: float) -> None:
    running.print_json(
        {
            "folder": made.folder,
            "page": made.page,
            "tables": made.tables,
            "done": made.done,
            "bound": made.bound,
            "found": made.found,
            "refused": len(made.tally.refused),
            "doubted": made.tally.doubted,
            "warnings": dict(made.tally.warnings),
            "unlike": made.tally.unlike,
            "to_be_dropped": made.to_be_dropped,
            "seconds": seconds,
            "parts": made.rows or (),
        },
        interrupted=not made.complete,
    )


def _print_words(made: "Catalogue", seconds: float) -> None:
    counted = made.tally
    found = f", {made.found} of them done before" if made.found else ""
    print(
        printable(
            f"{made.page}: {several(made.done, 'part')}{found}, "
            f"{len(counted.refused)} refused, took {seconds:.1f} s"
        )
    )
    for table in made.tables:
        print(printable(str(table)))
    if counted.doubted:
        print(
            f"warnings about {counted.doubted} of {several(counted.answered, 'part')}: "
            f"{counted.codes}"
        )
    for name, why in list(counted.refused.items())[:NAMED]:
        print(printable(f"refused {name}: {why}"))
    if len(counted.refused) > NAMED:
        print(f"and {len(counted.refused) - NAMED} more, with reasons in the table")
    for name, why in list(counted.unlike.items())[:NAMED]:
        print(printable(f"check the unit of {name}: it is {why}"))
    if not made.complete:
        left = [f"{made.bound - made.done} parts to be looked at"] * (
            made.done < made.bound
        )
        left += [f"{made.to_be_dropped} parts to be dropped"] * bool(made.to_be_dropped)
        print(f"interrupted: {' and '.join(left)}; the same command goes on from here")
