"""`sensitivity PART --wanted I...`: which change of a part feeds better, and by how much."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING, Any

from ...errors import RequestError
from ...text import Column, columns, name_poses, several
from .. import arguments as given, running

if TYPE_CHECKING:
    from ...design.effects import Effect, Sensitivity
    from ...design.suggest import Suggestion
    from ...records import Part
    from ...statistics.feeding import Bounded


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "sensitivity", help="which change of a part feeds better, and by how much",
        description="Estimate how the share of the wanted poses changes with the centre of mass, "
        "with stretching, and with each resting face moved in or out, and check the best changes "
        "by drops of the part before and after from the same starts. With --suggest it combines "
        "changes within a bound.",
        examples=("ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 "
                  "--png sensitivity.png",
                  "ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 --suggest "
                  "--within 1 --stl changed.stl"))
    given.add_part_options(command)
    given.add_wanted_option(command, "I", "indices of the poses that are accepted, for "
                            "instance 0 1 or 0-3", required=True)
    command.add_argument("--step", type=float, metavar="MM",
                         help="the change that is meant, in millimetres whatever the unit of the "
                         "file (default: a twentieth of the part's radius)")
    command.add_argument("--checks", type=given.read_count, default=5, metavar="N",
                         help="changes that are checked by drops, those that raise the share most "
                         "(default: %(default)s)")
    command.add_argument("--suggest", action="store_true",
                         help="combine changes within a bound so that the share rises; a "
                         "symmetric part stays symmetric")
    command.add_argument("--within", type=float, metavar="MM",
                         help="with --suggest: how far the outline and the centre of mass may "
                         "move, in millimetres")
    command.add_argument("--stl", metavar="FILE",
                         help="with --suggest: write the changed hull as FILE.stl, in millimetres")
    command.add_argument("--png", metavar="FILE",
                         help="draw where to add to the part and where to take away, as FILE.png")
    given.add_scene_options(command)
    command.add_argument("--drops", type=given.read_count, metavar="N",
                         help="drops of each part, and no bound of time (default: 2000 for a "
                         "check and 4000 for a suggestion, fewer where they take long)")
    given.add_seed_option(command, "the same seed and number of drops give the same counts "
                          "(default: a fresh one, which is printed)")
    given.add_workers_option(command)
    given.add_json_option(command)
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Estimate, check, suggest and print."""
    if not options.suggest and (options.within is not None or options.stl is not None):
        raise RequestError("--suggest with --within and --stl", "none of it", "add --suggest")
    if options.suggest and options.within is None:
        raise RequestError("--within with --suggest", "no bound",
                           "give how far the outline may move, for instance --within 1")
    files = {kind: None if name is None else running.output_file(name, (f".{kind}",))
             for kind, name in (("png", options.png), ("stl", options.stl))}
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...design import sensitivity, suggest  # noqa: F401 - imported for their kernels
        from ...design.climb import check_within

        part = running.load_part_and_kernels(options)
        if options.suggest:
            from ...resting.poses import resting_poses

            check_within(1e-3 * options.within, resting_poses(
                part, options.cluster_tolerance, options.round_sides).body.radius)
    with running.stop_on_interrupt() as interrupted, running.ProgressBar(sys.stderr) as bar:
        found, proposed = _compute(part, options, bar, interrupted)
        stopped = interrupted()
    with running.end_on_interrupt():
        written = _write_files(files, found, proposed)
    if options.json:
        from ...design.describe import sensitivity_as_dict, suggestion_as_dict

        extra = {} if proposed is None else {"suggestion": suggestion_as_dict(proposed)}
        running.print_json({**sensitivity_as_dict(found), **extra}, interrupted=stopped)
    else:

        lines = sensitivity_table(found)
        if proposed is not None:
            lines += ["", *suggestion_table(proposed)]
        lines += [*(f"wrote {file}" for file in written),
                  *(["interrupted"] if stopped else [])]
        print("\n".join(lines))
    return running.INTERRUPTED if stopped else 0


def _compute(part: Part, options: argparse.Namespace, bar: running.ProgressBar, interrupted: Any
             ) -> tuple[Sensitivity, Suggestion | None]:
    from ...design.sensitivity import sensitivity
    from ...design.suggest import suggest

    scene = {**given.scene_keywords(options), "workers": options.workers, "drops": options.drops,
             "should_stop": interrupted}
    found = sensitivity(
        part, options.wanted, step=None if options.step is None else 1e-3 * options.step,
        checks=options.checks, seed=options.seed,
        on_progress=lambda share: bar.draw(share, f"{100.0 * share:.0f} %, changes"), **scene)
    if not options.suggest or interrupted():
        return found, None
    return found, suggest(
        part, options.wanted, 1e-3 * options.within, seed=found.seed,
        on_progress=lambda share: bar.draw(share, f"{100.0 * share:.0f} %, suggestion"), **scene)


def _write_files(files: dict[str, Any], found: Sensitivity, proposed: Suggestion | None
                 ) -> list[Any]:
    """Write what was asked for and is there; returns the files written."""
    from ...files import write_file

    written = []
    if files["png"] is not None:
        from ...plots.changes import changes_figure
        from ...plots.files import figure_png

        write_file(files["png"], figure_png(changes_figure(found)))
        written.append(files["png"])
    if files["stl"] is not None and proposed is not None:
        from ...mesh.files import stl_bytes

        part = proposed.changed.part
        write_file(files["stl"], stl_bytes(1e3 * part.vertices, part.triangles))
        written.append(files["stl"])
    return written


MOST_ROWS = 30


def sensitivity_table(found: Sensitivity) -> list[str]:
    """Lines: the share as it is, the effects, the greatest first, and the checks."""
    from ...design import describe

    space, shown = found.space, found.effects[:MOST_ROWS]
    joined = any(len(effect.alike) > 1 for effect in shown)
    heads = [Column("change", left=True), *([Column("alike")] if joined else []),
             Column("effect"), Column("error"), Column("", left=True)]
    rows = []
    for one in shown:
        scale = 0.1 if one.feature.is_length else 1.0
        rows.append([describe.name_feature(space, one.number),
                     *([str(len(one.alike))] if joined else []),
                     f"{scale * one.slope:+.2f}", f"{scale * one.error:.2f}",
                     f"points per {'mm' if one.feature.is_length else '%'}"])
    hidden = len(found.effects) - len(shown)
    lines = [f"{space.part.part_id}: wanted {name_poses(found.wanted)}: "
             f"{_bounded(found.accepted)} by {found.method}, in brackets 90 % intervals",
             f"released {found.scene.drop_height:.3g} m above a frictionless plate, restitution "
             f"{found.scene.restitution:g}", "", describe.describe_order(found),
             *columns(heads, rows)]
    if hidden:
        lines.append(f"... and {several(hidden, 'smaller effect')}; --json lists all")
    return [*lines, *_checks(found), "", *found.warnings, f"computed in {found.seconds:.1f} s",
            describe.JUDGED]


def _checks(found: Sensitivity) -> list[str]:
    """The changes that were dropped, and those that lose a wanted pose."""
    from ...design import describe

    checked = sorted((one for one in found.effects if one.check is not None),
                     key=lambda one: -one.change)
    if not checked:
        return ["", "no change was checked by drops"]
    heads = [Column("step", left=True), Column("by estimate", "points"),
             Column("by drops", "points"), Column("90 % interval", "points"),
             Column("", left=True)]
    rows = [[describe.name_step(found.space, one.number, one.step), f"{100.0 * one.change:+.1f}",
             *_by_drops(one), _remark(one, describe.CONTRADICTED)]
            for one in checked]
    ended = describe.describe_time(found)
    return ["", f"the best of these, {found.drops} drops before and after from the same starts, "
            f"seed {found.seed}", *columns(heads, rows), *([ended] if ended else [])]


def _by_drops(one: Effect) -> tuple[str, str]:
    check = one.check
    if check is None or math.isnan(check.value):
        return "-", "-"
    return f"{100.0 * check.value:+.1f}", f"{100.0 * check.low:+.1f} to {100.0 * check.high:+.1f}"


def _remark(one: Effect, contradicted: str) -> str:
    told = [contradicted] if one.contradicted else []
    if one.lost:
        told.append(f"{name_poses(one.lost)} {'is' if len(one.lost) == 1 else 'are'} gone")
    return ", ".join(told)


def suggestion_table(found: Suggestion) -> list[str]:
    """Lines: the steps, and what they gain by estimate and by drops."""
    from ...design import describe

    steps = describe.suggested_steps(found)
    if not steps:
        return [f"suggestion: no change within {1e3 * found.within:g} mm raises the estimate"]
    gain = found.gain
    return [f"suggestion within {1e3 * found.within:g} mm; the outline moves by "
            f"{1e3 * found.outline:.2g} mm, the centre of mass by {1e3 * found.center_shift:.2g}:",
            *(f"  {line}" for line in steps),
            *([f"  gone: wanted {name_poses(found.lost)}"] if found.lost else []),
            f"by estimate: {100.0 * found.before:.1f} -> {100.0 * found.after:.1f} %; it chose "
            "these steps and so flatters them",
            f"by drops: {_bounded(found.dropped_before)} -> {_bounded(found.dropped_after)}; gain "
            f"{100.0 * gain.value:+.1f} points, 90 % interval {100.0 * gain.low:+.1f} to "
            f"{100.0 * gain.high:+.1f} ({found.drops} drops of both from the same starts, seed "
            f"{found.seed}, that had no say in the choice)",
            *([ended] if (ended := describe.describe_time(found)) else []), describe.JUDGED]


def _bounded(share: Bounded) -> str:
    return (f"{100.0 * share.value:.1f} % [{100.0 * share.low:.1f} to "
            f"{100.0 * share.high:.1f} %]")
