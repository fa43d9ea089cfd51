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

"""`catalogue PART... -o DIR`: all parts of folders in one table and on one page."""

import argparse
import math
import time
from itertools import islice
from typing import TYPE_CHECKING

from ...base.text import printable, several
from .terminal import arguments, running

if TYPE_CHECKING:
    from ..catalogue.making import Catalogue, CatalogueProgress

MOST_NAMED = 10  # refused parts on the terminal


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "catalogue",
        help="list the poses of all parts of a folder, in a table and on a page",
        description="Look at every part of some folders and files: its stable poses, "
        "their probabilities with errors, footprint and height, how well it feeds, "
        "warnings, and, where a part is refused, why. The folder of -o gets "
        "`index.html`, to sort and filter without a network, `catalogue.csv` with a "
        "row a part and `poses.csv` with a row a pose. A run that is cut off goes on "
        "when the same command is given again, and looks at new and changed files "
        "only.",
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
    arguments.add_options(
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
        help="drop each part until its answer is within this root mean square error "
        "over the poses with 90 %% confidence, those that take most drops after all "
        "others; 0.01 is one percentage point (default: the answer of `estimate`)",
    )
    arguments.add_options(command, "--unit", help=arguments.SHARED_UNIT_HELP)
    arguments.add_options(
        command, "--density", *arguments.POSE_OPTIONS, *arguments.SCENE_OPTIONS
    )
    command.add_argument(
        "--parquet",
        action="store_true",
        help="write the tables as Parquet files, too; that needs pyarrow",
    )
    machines = command.add_mutually_exclusive_group()
    machines.add_argument(
        "--workers",
        type=arguments.read_count,
        metavar="W",
        help="number of processes (default: all cores)",
    )
    machines.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of a dask.distributed cluster that does the work instead; "
        "files are sent to it",
    )
    arguments.add_options(
        command,
        "--json",
        help="print one JSON object that says what was written and refused, with all "
        "rows",
    )


def run(options: argparse.Namespace) -> int:
    """Make the catalogue and say where it is."""
    folder = arguments.output_folder(options.output)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...core.kernels.compilation import prepare_kernels
        from ..catalogue import making, request, store

        catalogue_request = request.CatalogueRequest(
            arguments.drop_scene(options),
            options.unit,
            options.density,
            options.target_error,
        )
        if options.scheduler is None:
            maker = making.on_processes(options.workers)
        else:
            maker = making.on_cluster(options.scheduler)
        if options.parquet:
            store.load_parquet()
        parts = request.find_parts(options.parts)
        if options.scheduler is None:
            # Before several processes would compile them at once.
            prepare_kernels()
    begin = time.monotonic()
    with (
        running.stop_on_interrupt() as is_interrupted,
        running.ProgressBar() as bar,
    ):
        catalogue = making.make_catalogue(
            folder,
            parts,
            catalogue_request,
            maker,
            parquet=options.parquet,
            keep_rows=options.json,
            on_progress=lambda progress: show_progress(bar, progress),
            should_stop=is_interrupted,
        )
    seconds = time.monotonic() - begin
    if options.json:
        print_json(catalogue, seconds)
    else:
        print_summary(catalogue, seconds)
    return 0 if catalogue.complete else running.INTERRUPTED


def show_progress(bar: running.ProgressBar, progress: "CatalogueProgress") -> None:
    """Draw how many parts are finished, and the seconds to go."""
    looked_at = progress.parts - progress.earlier_parts
    seconds = math.nan
    if looked_at:
        seconds = (progress.bound - progress.parts) * progress.seconds / looked_at
    state = "sure" if progress.dropping else "estimated"
    bar.draw(
        progress.parts / progress.bound,
        f"{progress.parts} of {progress.bound} parts {state}, "
        f"{running.duration(seconds)} left",
    )


def print_json(catalogue: "Catalogue", seconds: float) -> None:
    """Print what was written and refused, with all rows."""
    running.print_json(
        {
            "folder": catalogue.folder,
            "page": catalogue.page,
            "tables": catalogue.tables,
            "done": catalogue.row_count,
            "bound": catalogue.bound,
            "found": catalogue.earlier_rows,
            "refused": len(catalogue.tally.refused),
            "guessed": dict(catalogue.tally.guessed),
            "doubted": catalogue.tally.doubted,
            "warnings": {
                code: len(files) for code, files in catalogue.tally.warnings.items()
            },
            "unlike": catalogue.tally.unlike,
            "to_be_dropped": catalogue.to_be_dropped,
            "seconds": seconds,
            "parts": catalogue.rows or (),
        },
        interrupted=not catalogue.complete,
    )


def print_summary(catalogue: "Catalogue", seconds: float) -> None:
    """Print what was written, refused and doubted, and what is left to do."""
    tally = catalogue.tally
    earlier = (
        f", {catalogue.earlier_rows} of them done before"
        if catalogue.earlier_rows
        else ""
    )
    lines = [
        f"{catalogue.page}: {several(catalogue.row_count, 'part')}{earlier}, "
        f"{len(tally.refused)} refused, took {seconds:.1f} s",
        *map(str, catalogue.tables),
    ]
    if tally.doubted:
        lines.append(
            f"warnings about {tally.doubted} of {several(tally.answered, 'part')}: "
            f"{tally.codes}"
        )
    if tally.guessed:
        lines.append(f"{tally.guesses}; --unit makes sure")
    for name, reason in islice(tally.refused.items(), MOST_NAMED):
        lines.append(f"refused {name}: {reason}")
    if len(tally.refused) > MOST_NAMED:
        lines.append(
            f"and {len(tally.refused) - MOST_NAMED} more, with reasons in the table"
        )
    for name, reason in islice(tally.unlike.items(), MOST_NAMED):
        lines.append(f"check the unit of {name}: it is {reason}")
    if not catalogue.complete:
        lines.append(
            f"interrupted: {describe_open_work(catalogue)}; "
            "the same command goes on from here"
        )
    for line in lines:
        print(printable(line))


def describe_open_work(catalogue: "Catalogue") -> str:
    """The parts that a run which was interrupted has not come to."""
    counts = []
    if catalogue.row_count < catalogue.bound:
        counts.append(f"{catalogue.bound - catalogue.row_count} parts to be looked at")
    if catalogue.to_be_dropped:
        counts.append(f"{catalogue.to_be_dropped} parts to be dropped")
    return " and ".join(counts)
