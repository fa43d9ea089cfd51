"""`feeding PART`: what a vision feeder is to do with a part, and what it gets."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import RequestError
from ...base.text import (
    Column,
    bounded,
    columns,
    length_in_words,
    listed,
    millimetres,
    several,
)
from ...core.records.notes import Note, note_paragraph
from ...core.records.scene import HIGHEST_KICK, SCENE_FIELDS, height_warnings
from .terminal import arguments, flip_counts, running

if TYPE_CHECKING:
    from ...core.planning.feeding_plan import FeederCell, FeedingPlan, KickPlan
    from ...core.records import Part, PoseStatistics

DEFAULT_FLIPS = 10_000  # with a kick, out of all poses, as a node answers

TIMES = {
    "pick-time": (1.0, "seconds to pick a part"),
    "camera-time": (0.2, "seconds of a picture"),
    "drop-time": (0.5, "seconds until dropped or kicked parts lie still"),
}


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "feeding",
        help="plan a feeder cell: poses to pick and to flip, kick, parts on the plate",
        description="Plan a cell with a camera, a robot and a plate that kicks all "
        "parts on it together: which poses to pick, from which a kick is worth its "
        "time, which kick, how many parts to put on the plate, and how many are picked "
        "a minute, with an interval that has the plate's error in it.",
        examples=(
            "ros_pose_stats feeding demo/clamp.stl --unit mm --wanted 0 1 "
            "--plate 300mm 200mm --png kicks.png",
        ),
        run=run,
    )
    arguments.add_part(command, *arguments.POSE_OPTIONS, *arguments.SCENE_OPTIONS)
    arguments.add_options(command, "--wanted", required=True)
    command.add_argument(
        "--plate",
        nargs=2,
        type=arguments.read_length,
        required=True,
        metavar=("L", "W"),
        help="sides of the area over which the centres of "
        "the parts spread, as 0.3 (metres) or 300mm",
    )
    command.add_argument(
        "--clearance",
        type=arguments.read_length,
        default=0.0,
        metavar="C",
        help="room that the gripper needs around a part, as 0.002 or 2mm (default: 0)",
    )
    arguments.add_options(command, "--rate", "--cycle-time")
    for name, (seconds, about) in TIMES.items():
        command.add_argument(
            f"--{name}",
            type=float,
            default=seconds,
            metavar="S",
            help=f"{about} (default: %(default)s)",
        )
    command.add_argument(
        "--kicks",
        type=arguments.read_length,
        nargs="*",
        metavar="H",
        help="kick heights that the plate can give, as 0.01 or 10mm (default: "
        "thirteen from a twentieth of the part's radius to five radii)",
    )
    flip_counts.add_counts_option(command)
    command.add_argument(
        "--flips",
        type=arguments.read_count,
        metavar="N",
        help=f"kicks out of each pose at each height (default: {DEFAULT_FLIPS} shared "
        "out over the poses)",
    )
    arguments.add_options(
        command,
        "--png",
        help="draw the parts a minute over the kick heights, as FILE.png",
    )
    arguments.add_options(command, "--seed", "--workers", "--json")


def run(options: argparse.Namespace) -> int:
    """Estimate, kick from every height, plan and print."""
    picture = running.picture_file(options.png)
    refuse_no_kicks(picture, options)
    part = running.load_part_and_kernels(options)
    from ...core.planning import auto, feeding_plan
    from ...core.simulation import flips, request

    cell = feeding_plan.FeederCell(
        options.rate,
        tuple(options.plate),
        options.clearance,
        options.cycle_time,
        options.pick_time,
        options.camera_time,
        options.drop_time,
    )
    statistics = auto.estimate(part, **arguments.scene_keywords(options))
    # What is refused is refused at once.
    feeding_plan.plan_feeding(statistics, options.wanted, cell)
    counted_flips = flip_counts.read_flips(options.counts, len(statistics.poses))
    kicks = options.kicks
    if kicks is None:
        kicks = flips.usual_kicks(statistics.radius)
    flip_count = options.flips
    if flip_count is None:
        flip_count = max(1, DEFAULT_FLIPS // len(statistics.poses))
    flip_request = request.drop_request(flip_count, options.seed, 0.0, options.workers)
    with running.stop_on_interrupt() as is_interrupted, running.ProgressBar() as bar:
        simulated_flips = flip_counts.kick_from_heights(
            part, kicks, flip_request, is_interrupted, bar, options
        )
    interruption = ""
    if is_interrupted():
        counts = f"{len(simulated_flips)} of {len(set(kicks))}"
        interruption = f"interrupted after {counts} kick heights"
    elif counted_flips and simulated_flips:
        simulated_flips = flip_counts.learn_settings(simulated_flips, counted_flips)
    plan = feeding_plan.plan_feeding(
        statistics, options.wanted, cell, simulated_flips, part
    )
    if picture is not None and simulated_flips:
        draw_kicks(picture, part, cell, plan)
    warnings = collect_warnings(statistics, kicks, options)
    return running.print_answer(
        options,
        {
            **{name: getattr(statistics, name) for name in STATISTICS_KEYS},
            "wanted": options.wanted,
            "seed": flip_request.seed,
            "flips": flip_count,
            "warnings": warnings,
            **plan.as_dict(),
        },
        plan_table(statistics, plan, cell, flip_request.seed, warnings),
        interruption,
    )


STATISTICS_KEYS = (
    "part_id",
    "part_digest",
    "method",
    *SCENE_FIELDS,
    "plate_error",
    "version",
)
"""What the answer repeats of the estimate."""


def refuse_no_kicks(picture: Path | None, options: argparse.Namespace) -> None:
    """Refuse an empty --kicks beside options that need kick heights."""
    if options.kicks != []:
        return
    if picture is not None:
        raise RequestError(
            "--kicks with heights for --png",
            "none",
            "leave --kicks out for the "
            "usual thirteen, or name some, for instance --kicks 5mm 10mm",
        )
    if options.counts is not None:
        raise RequestError(
            "kick heights beside --counts",
            "none",
            "leave --kicks out for the "
            "usual thirteen: counted flips are learnt from those of the model",
        )


def collect_warnings(
    statistics: "PoseStatistics", kicks: "Sequence[float]", options: argparse.Namespace
) -> "list[Note]":
    """Warnings of the estimate, about poses that look alike, and about high kicks."""
    from ...core.statistics.pose_groups import warn_of_lookalikes

    return [
        *statistics.warnings,
        *warn_of_lookalikes(statistics, options.wanted),
        *height_warnings(
            "kick", max(kicks, default=0.0), statistics.radius, HIGHEST_KICK
        ),
    ]


def draw_kicks(
    picture: Path, part: "Part", cell: "FeederCell", plan: "FeedingPlan"
) -> None:
    """Draw the parts a minute over the kick heights."""
    from ...base.files import write_file
    from ..plots import figures, shares

    without_kick, *kicked = plan.options
    figure = shares.kick_figure(
        part.part_id,
        cell.rate,
        cell.cycle_seconds,
        without_kick.per_minute,
        [(option.kick_height, option.per_minute) for option in kicked],
    )
    write_file(picture, figures.figure_png(figure))


def plan_table(
    statistics: "PoseStatistics",
    plan: "FeedingPlan",
    cell: "FeederCell",
    seed: int,
    warnings: "list[Note]",
) -> list[str]:
    """The plan for people."""
    from ...core.planning.feeding_plan import FLIPS_ERROR

    poses_by_action = {
        action: [k for k, planned in enumerate(plan.actions) if planned == action]
        for action in ("pick", "flip", "leave")
    }
    best = plan.best
    heads = [
        Column("kick height", "mm"),
        Column("parts on the plate"),
        Column("kicks until it is emptied"),
        Column("picked a minute"),
        Column("", left=True),
    ]
    rows = [option_cells(option, best) for option in plan.options]
    length, width = map(millimetres, cell.plate)
    return [
        f"{statistics.part_id}: {bounded(best.per_minute)} picked a minute, "
        f"{describe_kick(best)}",
        f"{statistics.scene}, method {statistics.method}",
        *(
            f"{action}: {listed(poses)}"
            for action, poses in poses_by_action.items()
            if poses
        ),
        f"{several(best.parts, 'part')} on a plate of {length} by {width} mm; the "
        f"first picture has {best.pickable:.3g} to pick",
        "",
        *columns(heads, rows),
        f"in brackets: 90 % intervals, with {100.0 * statistics.plate_error:.2g} "
        f"points of error of the plate and {100.0 * FLIPS_ERROR:g} of flips that "
        f"nobody counted; seed {seed}",
        *note_paragraph(warnings),
    ]


def option_cells(option: "KickPlan", best: "KickPlan") -> list[str]:
    """The cells of a row: a kick, what it takes and gains, and how good it is."""
    from ...core.planning.feeding_plan import MOST_KICKS

    kicks = str(option.kicks)
    if option.kicks >= MOST_KICKS:
        kicks = f"{MOST_KICKS} or more"
    mark = ""
    if option is best:
        mark = "best"
    elif option.per_minute.high >= best.per_minute.value:
        mark = "as good, within its error"
    return [
        millimetres(option.kick_height),
        str(option.parts),
        kicks,
        bounded(option.per_minute),
        f"{option.feeder_setting} {mark}".strip(),
    ]


def describe_kick(option: "KickPlan") -> str:
    """By which setting of the feeder or how high parts are kicked."""
    if option.feeder_setting:
        return f"at setting {option.feeder_setting}"
    if option.kick_height:
        return f"kicked by {length_in_words(option.kick_height)}"
    return "not kicked"
