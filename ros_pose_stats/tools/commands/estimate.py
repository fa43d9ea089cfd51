"""`estimate PART` and `simulate PART`: poses and probabilities, at once or by dropping a part."""

import argparse
import math
from typing import TYPE_CHECKING

from ...base.errors import RequestError
from ...base.methods import AUTO, BESIDE_DROPS, DEFAULT_METHOD, METHODS
from ...base.text import MOST_POSES, Column, listed, percent
from ...core.records.scene import DEFAULT_DROPS
from . import arguments as given, running

if TYPE_CHECKING:
    from ...core.records import Part, PoseStatistics

CHOICES = {one.name: one for one in METHODS if one.drops != "all"}
ALL = "all"


def register(commands: given.Commands) -> None:
    """Add the command."""
    knowing = listed([f"`{name}`" for name, one in CHOICES.items() if one.knows_scene])
    dropping = "; ".join(f"`{name}` is {CHOICES[name].about}" for name in BESIDE_DROPS)
    command = commands.add_parser(
        "estimate",
        help="estimate the pose statistics of a part at once",
        description="Estimate the stable poses of a part and the probability of coming to rest "
        f"in each. {knowing} take the restitution and the drop height into account; "
        f"the others ignore them. {dropping}; `choice` in the JSON says what it did and why. "
        "These two alone take the number of drops, the target error, the seed and the workers.",
        examples=(
            "ros_pose_stats estimate demo/clamp.stl --unit mm",
            "ros_pose_stats estimate demo/clamp.stl --unit auto --density 7850",
            "ros_pose_stats estimate demo/clamp.stl --unit mm --target-error 0.02 --json",
            "ros_pose_stats estimate demo/gear.stl --unit mm --method hybrid --drops 500",
            "ros_pose_stats estimate demo/hex_bolt.stl --unit mm --method all --each",
        ),
        run=run,
    )
    given.add_part(command, *given.POSES_OF)
    command.add_argument(
        "--method",
        choices=(*CHOICES, ALL),
        default=DEFAULT_METHOD,
        metavar="NAME",
        help=f"one of {', '.join(CHOICES)}, or {ALL}, which sets "
        "every estimator beside the others (default: %(default)s)",
    )
    given.add(command, *given.SCENE, "--each")
    given.add_drop_options(command, None)
    given.add(
        command,
        "--json",
        help="print one JSON object, or with all methods a list "
        "of them, in SI units, which the key `units` names, and no table",
    )


def run(options: argparse.Namespace) -> int:
    """Estimate and print."""
    if (
        options.method == AUTO
        and options.drops is not None
        and not options.target_error
    ):
        raise RequestError(
            "--target-error beside --drops, or --method hybrid",
            "--drops alone",
            "without a target `auto` drops a part 200 times at "
            "most, to check its estimate",
        )
    if options.method in BESIDE_DROPS:
        part = running.load_part_and_kernels(options)
        from ...core.planning import auto, hybrid

        method, most = (
            (auto.auto, auto.MOST_DROPS)
            if options.method == AUTO
            else (hybrid.hybrid, DEFAULT_DROPS)
        )
        return running.run_and_report(
            part, method, most if options.drops is None else options.drops, options
        )
    for name in ("drops", "target_error", "seed", "workers"):
        if getattr(options, name) is not None:
            raise RequestError(
                f"--{name.replace('_', '-')} with a method that drops the part",
                f"the method {options.method}",
                f"give --method {' or '.join(BESIDE_DROPS)}, or `simulate` the part",
            )
    with running.announce_slow_start():
        from ...core.estimators import ESTIMATORS
        from ...core.estimators.estimate import estimate_in

        part = given.load_named_part(options)
        scene = given.scene_of(options)
        answers = [
            estimate_in(part, scene, method)
            for method in (ESTIMATORS if options.method == ALL else [options.method])
        ]
    if options.json:
        plain = [statistics.as_dict() for statistics in answers]
        running.print_json(plain if options.method == ALL else plain[0])
    elif options.method == ALL:
        print(_comparison(answers, part, options.each))
    else:
        print(running.report_table(answers[0], part, options.each))
    return 0


def _comparison(answers: "list[PoseStatistics]", part: "Part", each: bool) -> str:
    """All methods' answers side by side, in the order of the last method's rows."""
    from ...core.records.pose_table import FilledColumn, pose_table
    from ...core.records.statistics import heading, remarks
    from ...core.statistics.pose_groups import listed_poses

    last = answers[-1]
    rows = listed_poses(last, each)
    columns = []
    for answer in answers:
        probabilities = {
            group.first.index: group.probability for group in listed_poses(answer, each)
        }
        cells = [percent(probabilities[row.first.index]) for row in rows[:MOST_POSES]]
        columns.append(FilledColumn(Column(answer.method), cells))
    # Methods that ignore the drop height have none; the scene has one all the same.
    of_scene = [answer for answer in answers if math.isfinite(answer.drop_height)]
    return "\n".join(
        [
            heading(of_scene[0] if of_scene else last, part),
            "",
            f"probability in %, ordered by {last.method}, "
            f"cluster tolerance {last.cluster_tolerance:g}",
            "",
            *pose_table(rows, columns),
            *remarks(answers),
        ]
    )


def register_simulate(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "simulate",
        help="drop a part many times and count its poses",
        description="Drop a part many times onto a rigid frictionless plate and count the "
        "poses in which it comes to rest. Ctrl-C stops and reports what has been done.",
        examples=(
            "ros_pose_stats simulate demo/clamp.stl --unit mm --drops 2e4 --seed 7",
        ),
        run=run_simulate,
    )
    given.add_part(command, *given.POSES_OF)
    given.add_drop_options(command, DEFAULT_DROPS)
    given.add(command, *given.SCENE, "--each", "--json")


def run_simulate(options: argparse.Namespace) -> int:
    """Simulate and print."""
    part = running.load_part_and_kernels(options)
    from ...core.simulation.simulate import simulate

    return running.run_and_report(part, simulate, options.drops, options)
