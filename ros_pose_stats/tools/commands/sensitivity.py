"""`sensitivity PART --wanted I...`: which change of a part feeds better, and by how much."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base.errors import RequestError
from ...base.text import Column, columns, name_poses, points, several
from ...core.records.scene import describe_scene
from . import arguments as given, running

if TYPE_CHECKING:
    from ..design import sensitivity, suggest


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "sensitivity",
        help="which change of a part feeds better, and by how much",
        description="Estimate how the share of the wanted poses changes with the centre of mass, "
        "with stretching, and with each resting face moved in or out, and check the best changes "
        "by drops of the part before and after from the same starts. With --suggest it combines "
        "up to three changes within a bound.",
        examples=(
            "ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 "
            "--png sensitivity.png",
            "ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 --suggest "
            "--within 1mm --stl changed.stl",
        ),
        run=run,
    )
    given.add_part(command, *given.POSES_OF)
    given.add(command, "--wanted", required=True)
    command.add_argument(
        "--step",
        type=given.read_length,
        metavar="L",
        help="the change that is meant, as 0.001 (metres) or 1mm (default: a "
        "twentieth of the part's radius)",
    )
    command.add_argument(
        "--checks",
        type=given.read_count,
        default=5,
        metavar="N",
        help="changes that are checked by drops, those that raise the share most "
        "(default: %(default)s)",
    )
    command.add_argument(
        "--suggest",
        action="store_true",
        help="combine up to three changes within a bound so that the share "
        "rises; a symmetric part stays symmetric",
    )
    command.add_argument(
        "--within",
        type=given.read_length,
        metavar="L",
        help="with --suggest: how far the outline and the centre of mass may "
        "move, as 0.001 (metres) or 1mm",
    )
    command.add_argument(
        "--stl",
        metavar="FILE",
        help="with --suggest: write the changed hull as FILE.stl, in millimetres",
    )
    given.add(
        command,
        "--png",
        help="draw where to add to the part and where to take away, as FILE.png",
    )
    given.add(
        command,
        "--drops",
        default=2000,
        help="drops of each part (default: %(default)s)",
    )
    given.add(command, *given.SCENE, "--seed", "--workers", "--json")


def run(options: argparse.Namespace) -> int:
    """Estimate, check, suggest and print."""
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
    picture, hull = (
        None if name is None else running.output_file(name, (kind,))
        for kind, name in ((".png", options.png), (".stl", options.stl))
    )
    from ...base.files import write_file
    from ...core.resting.poses import poses_in
    from ..design import changes, sensitivity, suggest

    part = running.load_part_and_kernels(options)
    if options.suggest:
        changes.check_reach(
            "bound", options.within, poses_in(part, given.scene_of(options)).body.radius
        )
    keywords = {
        **given.scene_keywords(options),
        "workers": options.workers,
        "drops": options.drops,
    }
    proposed = None
    with (
        running.stop_on_interrupt() as interrupted,
        running.ProgressBar(sys.stderr) as bar,
    ):
        found = sensitivity.sensitivity(
            part,
            options.wanted,
            step=options.step,
            checks=options.checks,
            seed=options.seed,
            on_progress=lambda share: bar.draw(
                share, f"{100.0 * share:.0f} %, changes"
            ),
            should_stop=interrupted,
            **keywords,
        )
        if options.suggest and not interrupted():
            proposed = suggest.suggest(
                part,
                options.wanted,
                options.within,
                seed=found.seed,
                on_progress=lambda share: bar.draw(
                    share, f"{100.0 * share:.0f} %, suggestion"
                ),
                should_stop=interrupted,
                **keywords,
            )
        stopped = interrupted()
    files: dict[Path, bytes] = {}
    with running.end_on_interrupt():
        if picture is not None:
            from ..plots import changes as drawing, figures

            files[picture] = figures.figure_png(drawing.changes_figure(found))
        if hull is not None and proposed is not None:
            from ...core.mesh.files import stl_bytes

            hulled = proposed.changed.part
            files[hull] = stl_bytes(1e3 * hulled.vertices, hulled.triangles)
        for file, content in files.items():
            write_file(file, content)
    extra = {} if proposed is None else {"suggestion": proposed.as_dict()}
    lines = sensitivity_table(found)
    if proposed is not None:
        lines[1:1] = suggestion_table(proposed)
    return running.print_answer(
        options,
        lambda: {**found.as_dict(), **extra},
        lambda: [*lines, *(f"wrote {file}" for file in files)],
        "interrupted" if stopped else "",
    )


MOST_ROWS = 30


def sensitivity_table(found: "sensitivity.Sensitivity") -> list[str]:
    """Lines: what gains most, the share as it is, and the steps that gain, with their checks."""
    from ..design import describe

    space = found.space
    best = found.best
    heads = [
        Column("step", left=True),
        Column("alike"),
        Column("gain", "points"),
        Column("error", "points"),
        Column("by drops", "points"),
        Column("90 %", "points"),
        Column("slope"),
        Column("", left=True),
    ]
    rows = []
    for one in best[:MOST_ROWS]:
        per, unit = (0.1, "mm") if one.feature.is_length else (1.0, "%")
        remarks = [
            f"points per {unit}",
            *([describe.CONTRADICTED] if one.contradicted else []),
            *([f"gone: {name_poses(one.lost)}"] if one.lost else []),
        ]
        rows.append(
            [
                describe.name_step(space, one.number, one.step),
                str(len(one.alike)),
                points(one.change),
                f"{100.0 * one.error * abs(one.step):.1f}",
                *(
                    ("-", "-")
                    if one.check is None
                    else (points(one.check.value), _interval(one.check))
                ),
                f"{round(per * one.slope, 2) + 0.0:+.2f}",
                ", ".join(remarks),
            ]
        )
    lines = [
        found.describe_gain(),
        f"{space.part.part_id}: wanted {name_poses(found.wanted)}: "
        f"{_bounded(found.accepted)} by {found.method}, in brackets 90 % intervals",
        describe_scene(found.scene.restitution, found.scene.drop_height),
    ]
    if rows:
        lines += [
            "",
            "what a step gains, where that is more than its own error, the most first",
            *columns(heads, rows),
        ]
        if len(best) > len(rows):
            lines.append(f"... and {several(len(best) - len(rows), 'smaller gain')}")
        lines.append(
            f"checks: {found.drops} drops of the part before and after from the same "
            f"starts, others for each, seed {found.seed}"
            if found.checked
            else "no step was checked by drops"
        )
    return [
        *lines,
        "",
        *found.warnings,
        f"computed in {found.seconds:.1f} s; --json lists all "
        "effects with their errors",
        describe.JUDGED,
    ]


def suggestion_table(found: "suggest.Suggestion") -> list[str]:
    """Lines: the steps, and what they gain by estimate and by drops."""
    from ..design import describe

    if not found.steps:
        return [
            f"suggestion: no change within {1e3 * found.within:g} mm raises the estimate"
        ]
    heads = [
        Column("step", left=True),
        Column("gain", "points"),
        Column("by drops", "points"),
        Column("90 %", "points"),
    ]
    rows = [
        [
            describe.name_moves(found.space, one.moves),
            points(one.estimated),
            points(one.gain.value),
            _interval(one.gain),
        ]
        for one in found.steps
    ]
    return [
        f"suggestion within {1e3 * found.within:g} mm: {_bounded(found.dropped_before)} -> "
        f"{_bounded(found.dropped_after)}, {points(found.gain.value)} points "
        f"({_interval(found.gain)})",
        *columns(heads, rows),
        *([f"  gone: wanted {name_poses(found.lost)}"] if found.lost else []),
        f"by {found.drops} drops of the part as it is and after each step, seed {found.seed}, "
        "that had no say in the choice; the estimate chose and so flatters it",
        f"the outline moves by {1e3 * found.outline:.3f} mm, the centre of mass by "
        f"{1e3 * found.center_shift:.3f} mm",
        "",
    ]


def _interval(known: Any) -> str:
    return f"{points(known.low)} to {points(known.high)}"


def _bounded(share: tuple[float, float, float]) -> str:
    return "{:.1f} % [{:.1f} to {:.1f} %]".format(*(100.0 * each for each in share))
