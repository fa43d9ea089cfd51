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

"""`sensitivity PART --wanted I...`: which change makes a part rest as wanted."""

import argparse
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import RequestError
from ...base.files import write_file
from ...base.text import Column, columns, name_poses, points, ranges
from ...core.records.notes import note_lines
from ...core.records.scene import DEFAULT_SEED, describe_scene
from .terminal import arguments, running

if TYPE_CHECKING:
    from ..design.paired_drops import PairedDifference
    from ..design.sensitivity import Effect, Sensitivity
    from ..design.suggest import Suggestion


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "sensitivity",
        help="which change of a part feeds better, and by how much",
        description="Estimate how the share of the wanted poses, or how near all "
        "shares are to wanted ones, changes with the centre of mass, with stretching, "
        "and with each resting face moved in or out; and drop the part before and "
        "after the best changes from the same starts, which tells what gains. With "
        "--suggest it combines up to three changes within a bound.",
        examples=(
            "ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 "
            "--png sensitivity.png",
            "ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 --suggest "
            "--within 1mm --stl changed.stl",
            "ros_pose_stats sensitivity demo/clamp.stl --unit mm "
            "--target 0=1/3 1=1/3 2-6=1/3",
        ),
        run=run,
    )
    arguments.add_part(command, *arguments.POSE_OPTIONS)
    goals = command.add_mutually_exclusive_group(required=True)
    goals.add_argument("--wanted", **arguments.OPTIONS["--wanted"])
    goals.add_argument(
        "--target",
        type=read_wanted_share,
        nargs="+",
        metavar="I=SHARE",
        help="the wanted share of each pose, or of several together, in place of one "
        "sum, for instance 0=50%% 1,2=30%% 3-5=20%%; all poses have one",
    )
    command.add_argument(
        "--step",
        type=arguments.read_length,
        metavar="L",
        help="the change that is meant, as 0.001 (metres) or 1mm (default: a "
        "twentieth of the part's radius)",
    )
    command.add_argument(
        "--checks",
        type=arguments.read_count,
        default=6,
        metavar="N",
        help="changes that are checked by drops, those that gain most by estimate "
        "(default: %(default)s)",
    )
    command.add_argument(
        "--suggest",
        action="store_true",
        help="combine up to three changes within a bound that gain most; a symmetric "
        "part stays symmetric",
    )
    command.add_argument(
        "--within",
        type=arguments.read_length,
        metavar="L",
        help="with --suggest: how far the outline and the centre of mass may "
        "move, as 0.001 (metres) or 1mm",
    )
    command.add_argument(
        "--stl",
        metavar="FILE",
        help="with --suggest: write the changed hull as FILE.stl, in millimetres",
    )
    arguments.add_options(
        command,
        "--png",
        help="draw where to add to the part and where to take away, as FILE.png",
    )
    arguments.add_options(
        command,
        "--drops",
        default=20_000,
        help="the most drops of each part; they end where all gains are known to 1.25 "
        "points (default: %(default)s)",
    )
    arguments.add_options(
        command,
        "--seed",
        default=DEFAULT_SEED,
        help="the same seed gives the same drops (default: %(default)s, as `estimate`)",
    )
    arguments.add_options(command, *arguments.SCENE_OPTIONS, "--workers", "--json")


def read_wanted_share(text: str) -> tuple[tuple[int, ...], float]:
    """Poses and the share that is wanted of them together: 0,1=30%, 2=1/3, 3-5=0.2."""
    poses, _, share = text.partition("=")
    number = share.strip()
    try:
        fraction = float(Fraction(number.removesuffix("%")))
        if number.endswith("%"):
            fraction *= 0.01
        return tuple(arguments.read_indices(poses)), fraction
    except (argparse.ArgumentTypeError, ValueError, ZeroDivisionError, OverflowError):
        raise arguments.refusal(
            "poses and their share, for instance 0,1=30% or 2=1/3", text
        ) from None


def run(options: argparse.Namespace) -> int:
    """Estimate, check, suggest and print."""
    check_options(options)
    picture = running.picture_file(options.png)
    hull = None if options.stl is None else running.output_file(options.stl, (".stl",))
    from ...core.resting.poses import poses_in
    from ..design import changes, suggest
    from ..design.sensitivity import sensitivity

    part = running.load_part_and_kernels(options)
    if options.suggest:
        body = poses_in(part, arguments.drop_scene(options)).body
        changes.check_reach("bound", options.within, body.radius)
    keywords = {
        **arguments.scene_keywords(options),
        "seed": options.seed,
        "workers": options.workers,
        "drops": options.drops,
    }
    wanted = dict(options.target) if options.target else options.wanted
    suggestion = None
    with (
        running.stop_on_interrupt() as is_interrupted,
        running.ProgressBar() as bar,
    ):
        effects = sensitivity(
            part,
            wanted,
            step=options.step,
            checks=options.checks,
            on_progress=lambda share: bar.draw(
                share, f"{100.0 * share:.0f} %, changes"
            ),
            should_stop=is_interrupted,
            **keywords,
        )
        if options.suggest and not is_interrupted():
            suggestion = suggest.suggest(
                part,
                wanted,
                options.within,
                on_progress=lambda share: bar.draw(
                    share, f"{100.0 * share:.0f} %, suggestion"
                ),
                should_stop=is_interrupted,
                **keywords,
            )
        interruption = "interrupted" if is_interrupted() else ""
    with running.end_on_interrupt():
        written_files = write_files(picture, hull, effects, suggestion)
    values = effects.as_dict()
    lines = sensitivity_table(effects)
    if suggestion is not None:
        values["suggestion"] = suggestion.as_dict()
        lines[1:1] = suggestion_table(suggestion)
    lines += [f"wrote {file}" for file in written_files]
    return running.print_answer(options, values, lines, interruption)


def check_options(options: argparse.Namespace) -> None:
    """Refuse --suggest without a bound, what goes with it alone, and poses twice."""
    if not options.suggest and (options.within is not None or options.stl is not None):
        raise RequestError(
            "--suggest with --within and --stl", "none of it", "add --suggest"
        )
    if options.suggest and options.within is None:
        raise RequestError(
            "--within with --suggest",
            "no bound",
            "give how far the outline may move, for instance --within 1mm",
        )
    if options.target and len(dict(options.target)) < len(options.target):
        raise RequestError(
            "one --target for each pose", "the same poses twice", "name each pose once"
        )


def write_files(
    picture: Path | None,
    hull: Path | None,
    sensitivity: "Sensitivity",
    suggestion: "Suggestion | None",
) -> list[Path]:
    """Write the picture and the changed hull as requested; return their paths."""
    written_files = []
    if picture is not None:
        from ..plots import figures
        from ..plots.changes import changes_figure

        write_file(picture, figures.figure_png(changes_figure(sensitivity)))
        written_files.append(picture)
    if hull is not None and suggestion is not None:
        from ...core.mesh.files import stl_bytes

        part = suggestion.changed.part
        write_file(hull, stl_bytes(1e3 * part.vertices, part.triangles))
        written_files.append(hull)
    return written_files


def sensitivity_table(sensitivity: "Sensitivity") -> list[str]:
    """Lines: what gains most, the share as it is, and the checked steps."""
    from ..design import describe

    scene = sensitivity.scene
    lines = [
        sensitivity.describe_gain(),
        f"{sensitivity.space.part.part_id}: {sensitivity.describe_goal()}, in brackets "
        "90 % intervals",
        describe_scene(scene.restitution, scene.drop_height),
    ]
    if sensitivity.goal.has_shares:
        lines += ["", *target_table(sensitivity)]
    if sensitivity.checked:
        lines += ["", *effects_table(sensitivity)]
    return [
        *lines,
        "",
        *note_lines(sensitivity.warnings),
        f"computed in {sensitivity.seconds:.1f} s; --json lists all "
        "effects with their errors",
        describe.JUDGED,
    ]


def target_table(sensitivity: "Sensitivity") -> list[str]:
    """Lines: wanted shares and those of the part, a class of poses each."""
    goal = sensitivity.goal
    heads = [
        Column("poses", left=True),
        Column("wanted", "%"),
        Column("as it is", "%"),
    ]
    rows = [
        [
            ranges(goal.poses(number)),
            f"{100.0 * goal.shares[number]:.1f}",
            f"{100.0 * sensitivity.class_shares[number]:.1f}",
        ]
        for number in range(1, goal.shares.size)
    ]
    return columns(heads, rows)


def effects_table(sensitivity: "Sensitivity") -> list[str]:
    """Lines: the checked steps, a row each, and how they were checked."""
    from ..design import describe

    heads = [
        Column("step", left=True),
        Column("alike"),
        Column("by drops", "points"),
        Column("90 %", "points"),
        Column("by estimate", "points"),
        Column("", left=True),
    ]
    rows = [
        effect_cells(sensitivity, effect, check)
        for effect, check in sensitivity.checked
    ]
    return [
        "what a step gains by drops, the most first",
        *columns(heads, rows),
        f"{sensitivity.drops} drops of the part before and after from the same starts, "
        f"seed {sensitivity.seed}; the intervals hold together",
        describe.SURE,
    ]


def effect_cells(
    sensitivity: "Sensitivity", effect: "Effect", check: "PairedDifference"
) -> list[str]:
    """The cells of a row: a step, its gain by drops and by estimate, and remarks."""
    from ..design import describe

    remarks = [effect.remark] if effect.remark else []
    if effect.lost:
        remarks.append(f"gone: {name_poses(effect.lost)}")
    return [
        describe.name_step(sensitivity.space, effect.number, effect.step),
        str(len(effect.alike)),
        points(check.value),
        points_interval(check),
        points(effect.change),
        ", ".join(remarks),
    ]


def suggestion_table(suggestion: "Suggestion") -> list[str]:
    """Lines: the steps, and what they gain by estimate and by drops."""
    from ..design import describe

    bound = f"{1e3 * suggestion.within:g} mm"
    if not suggestion.steps:
        return [f"suggestion: drops show no gain of any change within {bound}"]
    heads = [
        Column("step", left=True),
        Column("by drops", "points"),
        Column("90 %", "points"),
        Column("by estimate", "points"),
    ]
    rows = [
        [
            describe.name_moves(suggestion.space, step.moves),
            points(step.gain.value),
            points_interval(step.gain),
            points(step.estimated),
        ]
        for step in suggestion.steps
    ]
    gain = suggestion.gain
    center = " ".join(f"{1e3 * x:.6g}mm" for x in suggestion.center_of_mass.tolist())
    lines = [
        f"suggestion within {bound}: {bounded_percent(suggestion.dropped_before)} -> "
        f"{bounded_percent(suggestion.dropped_after)}, {points(gain.value)} points "
        f"({points_interval(gain)})",
        *columns(heads, rows),
    ]
    if suggestion.lost:
        lines.append(f"  gone: wanted {name_poses(suggestion.lost)}")
    return [
        *lines,
        f"by {suggestion.drops} drops of the part as it is and after each step, seed "
        f"{suggestion.seed}, that had no say in the choice; the intervals hold "
        "together",
        f"the outline moves by {1e3 * suggestion.outline:.3f} mm, the centre of mass "
        f"by {1e3 * suggestion.center_shift:.3f} mm",
        f"with the hull of --stl: --com {center}",
        "",
    ]


def points_interval(difference: "PairedDifference") -> str:
    """The 90 % interval of a difference."""
    return f"{points(difference.low)} to {points(difference.high)}"


def bounded_percent(share: tuple[float, float, float]) -> str:
    """A share with its interval."""
    value, low, high = (100.0 * fraction for fraction in share)
    return f"{value:.1f} % [{low:.1f} to {high:.1f} %]"
