"""`feeding PART`: what a vision feeder is to do with a part, and what it gets."""

import argparse
import sys
from typing import TYPE_CHECKING

from ....base.errors import RequestError
from ....base.text import (
    Column,
    columns,
    length_in_words,
    listed,
    millimetres,
    remarks,
    several,
)
from ....core.records.scene import HIGHEST_KICK, height_warnings
from .. import arguments as given, running
from .flips import add_counts_option, read_flips, show_bounded

if TYPE_CHECKING:
    from ....core.planning.feeding_plan import FeederCell, FeedingPlan
    from ....core.records import PoseStatistics

FLIPS = 10_000  # with a kick, out of all poses, as a node answers

TIMES = {
    "pick-time": (1.0, "seconds to pick a part"),
    "camera-time": (0.2, "seconds of a picture"),
    "drop-time": (0.5, "seconds until dropped or kicked parts lie still"),
}


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "feeding",
        help="plan a feeder cell: poses to pick and to flip, kick, parts on the plate",
        description="Plan a cell with a camera, a robot and a plate that kicks all parts on it "
        "together: which poses to pick, from which a kick is worth its time, which kick, how many "
        "parts to put on the plate, and how many are picked a minute, with an interval that has "
        "the plate's error in it.",
        examples=(
            "ros_pose_stats feeding demo/clamp.stl --unit mm --wanted 0 1 "
            "--plate 300mm 200mm --png kicks.png",
        ),
        run=run,
    )
    given.add_part(command, *given.POSES_OF, *given.SCENE)
    given.add(command, "--wanted", required=True)
    command.add_argument(
        "--plate",
        nargs=2,
        type=given.read_length,
        required=True,
        metavar=("L", "W"),
        help="sides of the area over which the centres of "
        "the parts spread, as 0.3 (metres) or 300mm",
    )
    command.add_argument(
        "--clearance",
        type=given.read_length,
        default=0.0,
        metavar="C",
        help="room that the gripper needs around a part, as 0.002 or 2mm (default: 0)",
    )
    given.add(command, "--rate", "--cycle-time")
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
        type=given.read_length,
        nargs="*",
        metavar="H",
        help="kick heights that the plate can give, as 0.01 or 10mm (default: "
        "thirteen from a twentieth of the part's radius to five radii)",
    )
    add_counts_option(command)
    command.add_argument(
        "--flips",
        type=given.read_count,
        metavar="N",
        help=f"kicks out of each pose at each height (default: {FLIPS} shared "
        "out over the poses)",
    )
    given.add(
        command,
        "--png",
        help="draw the parts a minute over the kick heights, as FILE.png",
    )
    given.add(command, "--seed", "--workers", "--json")


def run(options: argparse.Namespace) -> int:
    """Estimate, kick from every height, plan and print."""
    picture = (
        None if options.png is None else running.output_file(options.png, (".png",))
    )
    if picture is not None and options.kicks == []:
        raise RequestError(
            "--kicks with heights for --png",
            "none",
            "leave --kicks out for the "
            "usual thirteen, or name some, for instance --kicks 5mm 10mm",
        )
    if options.counts is not None and options.kicks == []:
        raise RequestError(
            "kick heights beside --counts",
            "none",
            "leave --kicks out for the "
            "usual thirteen: counted flips are learnt from those of the model",
        )
    part = running.load_part_and_kernels(options)
    from ....core.planning import auto, feeding_plan
    from ....core.simulation import flips as kicking, request as requests
    from ....core.statistics import feeding, pose_groups

    cell = feeding_plan.FeederCell(
        options.rate,
        tuple(options.plate),
        options.clearance,
        options.cycle_time,
        options.pick_time,
        options.camera_time,
        options.drop_time,
    )
    dropped = auto.estimate(part, **given.scene_keywords(options))
    # What is refused is refused at once.
    feeding_plan.plan_feeding(dropped, options.wanted, cell)
    counted = read_flips(options.counts, len(dropped.poses))
    kicks = (
        kicking.usual_kicks(dropped.radius) if options.kicks is None else options.kicks
    )
    warnings = [
        *dropped.warnings,
        *pose_groups.warn_of_alike(dropped, options.wanted),
        *height_warnings("kick", max(kicks, default=0.0), dropped.radius, HIGHEST_KICK),
    ]
    each = (
        max(1, FLIPS // len(dropped.poses)) if options.flips is None else options.flips
    )
    request = requests.drop_request(each, options.seed, 0.0, options.workers)
    with (
        running.stop_on_interrupt() as interrupted,
        running.ProgressBar(sys.stderr) as bar,
    ):
        flips = kicking.flips_by_kick(
            part,
            given.scene_of(options),
            kicks,
            request,
            requests.Watch.of(None, interrupted),
            lambda done, total: bar.draw(done / total, f"kick {done + 1} of {total}"),
        )
    stopped = interrupted()
    if counted and flips and not stopped:
        flips = [
            feeding.learn_flips(flips, each, speed) for speed, each in counted.items()
        ]
    plan = feeding_plan.plan_feeding(dropped, options.wanted, cell, flips, part)
    if picture is not None and flips:
        from ....base.files import write_file
        from ...plots import figures, shares

        without, *kicked = plan.options
        write_file(
            picture,
            figures.figure_png(
                shares.kick_figure(
                    part.part_id,
                    cell.rate,
                    cell.cycle_time,
                    without.per_minute,
                    [(kick.kick_height, kick.per_minute) for kick in kicked],
                )
            ),
        )
    names = (
        "part_id",
        "part_digest",
        "method",
        "restitution",
        "drop_height",
        "cluster_tolerance",
        "round_sides",
        "plate_error",
        "version",
    )
    return running.print_answer(
        options,
        lambda: {
            **{name: getattr(dropped, name) for name in names},
            "wanted": options.wanted,
            "seed": request.seed,
            "flips": each,
            "warnings": warnings,
            "notes": dropped.notes,
            **plan.as_dict(),
        },
        lambda: _lines(dropped, plan, cell, request.seed, warnings),
        f"interrupted after {len(flips)} of {len(set(kicks))} kick heights"
        if stopped
        else "",
    )


def _lines(
    dropped: "PoseStatistics",
    plan: "FeedingPlan",
    cell: "FeederCell",
    seed: int,
    warnings: list[str],
) -> list[str]:
    """The plan for people."""
    from ....core.planning.feeding_plan import FLIPS_ERROR, MOST_KICKS

    poses = {
        action: [index for index, each in enumerate(plan.actions) if each == action]
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
    marks = [
        "best"
        if each is best
        else "as good, within its error"
        if each.per_minute.high >= best.per_minute.value
        else ""
        for each in plan.options
    ]
    rows = [
        [
            millimetres(each.kick_height),
            str(each.parts),
            str(each.kicks) if each.kicks < MOST_KICKS else f"{MOST_KICKS} or more",
            show_bounded(each.per_minute),
            f"{each.feeder_speed} {mark}".strip(),
        ]
        for each, mark in zip(plan.options, marks, strict=True)
    ]
    kick = (
        f"at speed {best.feeder_speed}"
        if best.feeder_speed
        else f"kicked by {length_in_words(best.kick_height)}"
        if best.kick_height
        else "not kicked"
    )
    return [
        f"{dropped.part_id}: {show_bounded(best.per_minute)} picked a minute, {kick}",
        f"{dropped.scene}, method {dropped.method}",
        *(f"{action}: {listed(which)}" for action, which in poses.items() if which),
        f"{several(best.parts, 'part')} on a plate of {millimetres(cell.plate[0])} by "
        f"{millimetres(cell.plate[1])} mm; the first picture has {best.pickable:.3g} to pick",
        "",
        *columns(heads, rows),
        f"in brackets: 90 % intervals, with {100.0 * dropped.plate_error:.2g} points of error "
        f"of the plate and {100.0 * FLIPS_ERROR:g} of flips that nobody counted; seed {seed}",
        *remarks(warnings, dropped.notes),
    ]
