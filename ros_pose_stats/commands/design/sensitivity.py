"""`sensitivity PART --wanted I...`: which change of a part feeds better, and by how much."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from ...errors import RequestError
from ..arguments import (
    JoinIndices,
    add_part_options,
    add_scene_options,
    read_count,
    read_indices,
)
from ..drop_runs import load_part_and_kernels
from ..progress_bar import ProgressBar
from ..running import (
    INTERRUPTED,
    announce_slow_start,
    end_on_interrupt,
    output_file,
    print_json,
    stop_on_interrupt,
)

if TYPE_CHECKING:
    from ...design.effects import Sensitivity
    from ...design.suggest import Suggestion
    from ...records import Part


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "sensitivity", help="which change of a part feeds better, and by how much",
        description="Estimate how the share of the wanted poses changes with the centre of mass, "
        "with stretching, with each resting face moved in or out, and with each edge of the hull "
        "chamfered, and check the best changes by drops of the part before and after from the "
        "same starts. With --suggest it combines changes within a bound.",
        examples=("ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 "
                  "--png sensitivity.png",
                  "ros_pose_stats sensitivity demo/clamp.stl --unit mm --wanted 0 --suggest "
                  "--within 1 --stl changed.stl"))
    add_part_options(command)
    command.add_argument("--wanted", type=read_indices, nargs="+", action=JoinIndices,
                         required=True, metavar="I",
                         help="indices of the poses that are accepted, for instance 0 1 or 0-3")
    command.add_argument("--step", type=float, metavar="MM",
                         help="the change that is meant, in millimetres whatever the unit of the "
                         "file (default: a twentieth of the part's radius)")
    command.add_argument("--checks", type=read_count, default=5, metavar="N",
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
    add_scene_options(command)
    command.add_argument("--drops", type=read_count, metavar="N",
                         help="drops of each part, and no bound of time (default: 2000 for a "
                         "check and 4000 for a suggestion, fewer where they take long)")
    command.add_argument("--seed", type=read_count, metavar="S",
                         help="the same seed and number of drops give the same counts (default: "
                         "a fresh one, which is printed)")
    command.add_argument("--workers", type=read_count, metavar="W",
                         help="number of threads (default: all cores)")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Estimate, check, suggest and print."""
    if not options.suggest and (options.within is not None or options.stl is not None):
        raise RequestError("--suggest with --within and --stl", "none of it", "add --suggest")
    if options.suggest and options.within is None:
        raise RequestError("--within with --suggest", "no bound",
                           "give how far the outline may move, for instance --within 1")
    files = {kind: None if name is None else output_file(name, (f".{kind}",))
             for kind, name in (("png", options.png), ("stl", options.stl))}
    with announce_slow_start(), end_on_interrupt():
        from ...design import sensitivity, suggest  # noqa: F401 - imported for their kernels
        from ...design.tied_steps import check_within

        part = load_part_and_kernels(options)
        if options.suggest:
            from ...resting.poses import resting_poses

            check_within(1e-3 * options.within, resting_poses(
                part, options.cluster_tolerance, options.round_sides).body.radius)
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found, proposed = _compute(part, options, bar, interrupted)
        stopped = interrupted()
    with end_on_interrupt():
        written = _write_files(files, found, proposed)
    if options.json:
        from ...design.describe import sensitivity_as_dict, suggestion_as_dict

        extra: dict[str, Any] = {"interrupted": True} if stopped else {}
        if proposed is not None:
            extra["suggestion"] = suggestion_as_dict(proposed)
        print_json({**sensitivity_as_dict(found), **extra})
    else:
        from .sensitivity_table import sensitivity_table, suggestion_table

        lines = sensitivity_table(found)
        if proposed is not None:
            lines += ["", *suggestion_table(proposed)]
        lines += [*(f"wrote {file}" for file in written),
                  *(["interrupted"] if stopped else [])]
        print("\n".join(lines))
    return INTERRUPTED if stopped else 0


def _compute(part: Part, options: argparse.Namespace, bar: ProgressBar, interrupted: Any
             ) -> tuple[Sensitivity, Suggestion | None]:
    from ...design.sensitivity import sensitivity
    from ...design.suggest import suggest

    scene = {"restitution": options.restitution, "drop_height": options.drop_height,
             "cluster_tolerance": options.cluster_tolerance, "round_sides": options.round_sides,
             "workers": options.workers, "drops": options.drops, "should_stop": interrupted}
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
