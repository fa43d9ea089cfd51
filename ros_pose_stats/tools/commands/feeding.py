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

"""`feeding PART`: what a vision feeder is to do with a part, and what it gets."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import RequestError
from ...core.records.notes import note_paragraph
from ...core.records.scene import SCENE_FIELDS
from .terminal import arguments, cells, flip_counts, running

if TYPE_CHECKING:
    from ...core.planning.feeder_cell import FeederCell
    from ...core.planning.feeding_plan import FeedingPlan
    from ...core.records import Part


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "feeding",
        help="plan a feeder cell: poses to pick and to flip, kick, parts on the plate",
        description="Plan a cell: which poses to pick, from which a kick is worth its "
        "time, which kick, and how many parts are picked a minute, with an interval "
        "that has the plate's error in it. With --plate a robot picks parts under a "
        "camera, all others are kicked together, and the plan says how many parts to "
        "put there. Without, parts come singly, and each that lies wrong is dropped "
        "again, or kicked where --kicks says how high.",
        examples=(
            "ros_pose_stats feeding demo/clamp.stl --unit mm --wanted 0 1 "
            "--plate 300mm 200mm --png kicks.png",
        ),
        run=run,
    )
    arguments.add_part(command, *arguments.POSE_OPTIONS, *arguments.SCENE_OPTIONS)
    arguments.add_options(command, "--wanted", required=True)
    cells.add_cell(command)
    command.add_argument(
        "--kicks",
        type=arguments.read_length,
        nargs="*",
        metavar="H",
        help="kick heights that the cell can give, as 0.01 or 10mm (default: with "
        "--plate or --counts thirteen from a twentieth of the part's radius to five "
        "radii, else none)",
    )
    flip_counts.add_counts_option(
        command,
        "; or of parts that were counted as they lie after a drop, with the columns "
        "part, pose and count, as `report --count-sheet` writes it",
    )
    flip_counts.add_flips(command)
    arguments.add_options(
        command,
        "--png",
        help="draw the parts a minute over the kick heights, as FILE.png",
    )
    arguments.add_options(command, "--workers", "--json")


def run(options: argparse.Namespace) -> int:
    """Estimate, kick from every height, plan and print."""
    picture = running.picture_file(options.png)
    flip_table = options.counts
    if flip_counts.is_of_landings(flip_table):
        flip_table = None
    refuse_no_kicks(picture, flip_table, options)
    part = running.load_part_and_kernels(options)
    from ...core.planning.feeding_plan import plan_feeding

    cell = cells.read_cell(options)
    statistics = cells.drop_into(cell, part, options)
    counted_flips = flip_counts.read_flips(flip_table, len(statistics.poses))
    kicks = cell.kick_heights(statistics.radius, options.kicks, bool(counted_flips))
    request = flip_counts.flip_request(options, len(statistics.poses))
    with running.stop_on_interrupt() as is_interrupted, running.ProgressBar() as bar:
        simulated_flips = flip_counts.kick_from_heights(
            part, kicks, request, is_interrupted, bar, options
        )
    interruption = ""
    if is_interrupted():
        counts = f"{len(simulated_flips)} of {len(set(kicks))}"
        interruption = f"interrupted after {counts} kick heights"
    elif counted_flips and simulated_flips:
        simulated_flips = flip_counts.learn_settings(simulated_flips, counted_flips)
    plan = plan_feeding(statistics, options.wanted, cell, simulated_flips, part)
    if picture is not None and simulated_flips:
        draw_kicks(picture, part, cell, plan)
    return running.print_answer(
        options,
        {
            **{name: getattr(statistics, name) for name in STATISTICS_KEYS},
            "wanted": options.wanted,
            "seed": request.seed,
            "flips_per_pose": request.drops,
            **plan.as_dict(),
        },
        [
            *cells.plan_lines(statistics, plan, options.wanted),
            *note_paragraph(plan.warnings),
        ],
        interruption,
    )


STATISTICS_KEYS = (
    "part_id",
    "part_digest",
    "method",
    "counted_parts",
    *SCENE_FIELDS,
    "plate_error",
    "version",
)
"""What the answer repeats of the estimate."""


def refuse_no_kicks(
    picture: Path | None, flip_table: str | None, options: argparse.Namespace
) -> None:
    """Refuse options that need kick heights where there are none."""
    has_usual = options.kicks is None and (options.plate or flip_table)
    if options.kicks or has_usual:
        return
    if picture is not None:
        raise RequestError(
            "--kicks with heights for --png",
            "none",
            "name some, for instance --kicks 5mm 10mm, or with --plate leave --kicks "
            "out for the usual thirteen",
        )
    if flip_table is not None:
        raise RequestError(
            "kick heights beside --counts",
            "none",
            "leave --kicks out for the "
            "usual thirteen: counted flips are learnt from those of the model",
        )


def draw_kicks(
    picture: Path, part: "Part", cell: "FeederCell", plan: "FeedingPlan"
) -> None:
    """Draw the parts a minute over the kick heights."""
    from ...base.files import write_file
    from ..plots import figures, shares

    figure = shares.kick_figure(part.part_id, cell, plan)
    write_file(picture, figures.figure_png(figure))
