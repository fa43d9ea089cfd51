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

"""`dataset`: pose statistics of many random polyhedra by simulation, in one file."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats.tools.commands.terminal.arguments import read_count
from ros_pose_stats.tools.commands.terminal.running import (
    INTERRUPTED,
    ProgressBar,
    announce_slow_start,
    duration,
    end_on_interrupt,
    print_json,
    stop_on_interrupt,
)

if TYPE_CHECKING:
    from ..dataset import DatasetProgress, DatasetSpec, Maker

PAPER_BODIES = 1057
PAPER_DROPS = 100
PAPER_RESTITUTIONS = (0.2, 0.5, 0.8)


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "dataset",
        help="simulate the paper's random polyhedra, into one file",
        description="Draw the paper's random polyhedra, drop each many times at each "
        "restitution, and write bodies, stable poses and counts to one numpy archive. "
        "A run that is cut off goes on when the same command is given again.",
        examples=(
            "python -m study dataset --bodies 40 --drops 200 --shift 0.25 -o small.npz",
        ),
    )
    command.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="the archive to write (default: a name that says what is in it)",
    )
    command.add_argument(
        "--bodies",
        type=read_count,
        default=PAPER_BODIES,
        metavar="B",
        help="number of bodies (default: %(default)s)",
    )
    command.add_argument(
        "--drops",
        type=read_count,
        default=PAPER_DROPS,
        metavar="N",
        help="number of drops of each body at each restitution (default: %(default)s)",
    )
    command.add_argument(
        "--restitution",
        type=float,
        nargs="+",
        metavar="R",
        default=list(PAPER_RESTITUTIONS),
        help="coefficients of restitution (default: 0.2 0.5 0.8)",
    )
    for word, settings in shift_options(0.0).items():
        command.add_argument(word, **settings)
    command.add_argument(
        "--seed",
        type=read_count,
        default=1,
        metavar="S",
        help="the same seed gives the same file (default: %(default)s)",
    )
    machines = command.add_mutually_exclusive_group()
    machines.add_argument(
        "--workers",
        type=read_count,
        metavar="W",
        help="number of threads (default: all cores)",
    )
    machines.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of a dask.distributed cluster that does the work instead",
    )
    command.add_argument(
        "--json",
        action="store_true",
        help="print one JSON object that says what was written",
    )
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Make the dataset and say what it holds."""
    with announce_slow_start(), end_on_interrupt():
        from ros_pose_stats.core.kernels.compilation import prepare_kernels

        from ..dataset import DatasetSpec, make_dataset

        spec = DatasetSpec(
            options.bodies,
            options.drops,
            tuple(options.restitution),
            options.shift,
            options.shift_moment,
            options.seed,
        )
        maker = _maker(options)
        if options.scheduler is None:
            prepare_kernels()
    file = Path(options.output or default_name(spec))
    begin = time.monotonic()
    with stop_on_interrupt() as interrupted, ProgressBar() as bar:
        complete = make_dataset(
            file,
            spec,
            maker,
            on_progress=lambda progress: bar.draw(*progress_text(progress)),
            should_stop=interrupted,
        )
    if not complete:
        print(
            "ros_pose_stats: interrupted; the same command goes on from here",
            file=sys.stderr,
        )
        return INTERRUPTED
    _report(file, time.monotonic() - begin, options.json)
    return 0


def default_name(spec: DatasetSpec) -> str:
    """File name of a dataset; restitutions are named where they are not the paper's."""
    others = (
        ""
        if spec.restitutions == PAPER_RESTITUTIONS
        else "_".join(
            ["_restitution", *(f"{restitution:g}" for restitution in spec.restitutions)]
        )
    )
    return (
        f"polyhedra_{spec.bodies}_shift_{spec.shift:g}_{spec.shift_moment}_"
        f"drops_{spec.drops}{others}_seed_{spec.seed}.npz"
    )


def progress_text(progress: DatasetProgress) -> tuple[float, str]:
    """How far the run is, as a share and as a text."""
    made_bodies = progress.bodies - progress.earlier_bodies
    remaining = (
        (progress.bound - progress.bodies) * progress.seconds / made_bodies
        if made_bodies
        else float("nan")
    )
    kept_bodies = (
        f" ({progress.earlier_bodies} found)" if progress.earlier_bodies else ""
    )
    return (
        progress.bodies / progress.bound,
        f"{progress.bodies} of {progress.bound} bodies{kept_bodies}, "
        f"{duration(remaining)} left",
    )


def _maker(options: argparse.Namespace) -> Maker:
    if options.scheduler is None:
        from ..dataset import on_threads

        return on_threads(options.workers)
    from ..dataset.cluster import on_cluster

    return on_cluster(options.scheduler)


def _report(file: Path, seconds: float, as_json: bool) -> None:
    from ..dataset import read_dataset

    dataset = read_dataset(file)
    spec = dataset.spec
    arrays = dataset.arrays
    drops = spec.bodies * len(spec.restitutions) * spec.drops
    unsettled = drops - int(arrays["settled"].sum())
    facts = {
        "file": str(file),
        "scene": spec.scene,
        **spec.as_dict(),
        "poses": len(dataset.body),
        "drops_in_all": drops,
        "unsettled": unsettled,
        "redraws": int(arrays["redraws"].sum()),
        "bytes": file.stat().st_size,
        "seconds": seconds,
    }
    if as_json:
        print_json(facts)
        return
    print(
        f"{file}: {file.stat().st_size / 1e6:.2f} MB, {spec.scene}\n"
        f"{spec.bodies} random polyhedra with {len(dataset.body)} stable poses, "
        f"shift {spec.shift:g} ({spec.shift_moment}), {facts['redraws']} drawn anew\n"
        f"{drops} drops, {spec.drops} of each at each restitution; {unsettled} did not "
        f"settle\ntook {seconds:.1f} s"
    )


SHIFT_MOMENTS = ("inertia", "second")


def shift_options(shift: float | None) -> dict[str, dict[str, Any]]:
    """Options of the shift of the centre of mass; None as the default: all there
    are.
    """
    default_text = "%(default)s" if shift is not None else "all that are there"
    return {
        "--shift": {
            "type": float,
            "default": shift,
            "metavar": "S",
            "help": "scale of the shift of the centre of mass; 0 leaves it at the "
            f"centroid, 1 is as the paper prints it (default: {default_text})",
        },
        "--shift-moment": {
            "choices": SHIFT_MOMENTS,
            "default": SHIFT_MOMENTS[0],
            "help": "the shift is measured in roots of the principal moments of "
            "inertia over the mass, as printed, or of the second moments "
            "(default: %(default)s)",
        },
    }
