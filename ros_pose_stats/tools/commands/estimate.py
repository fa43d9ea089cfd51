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

"""`estimate PART`: poses and probabilities of a part at once."""

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base.errors import RequestError
from ...base.files import write_file
from ...base.methods import AUTO, BESIDE_DROPS, DEFAULT_METHOD, METHODS
from ...base.text import Column, listed, percent, printable
from ...core.records.scene import DEFAULT_DROPS
from .terminal import arguments, running

if TYPE_CHECKING:
    from ...core.records import Part, PoseStatistics

CHOICES = {method.name: method for method in METHODS if method.drops != "all"}
ALL = "all"


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    scene_methods = [
        f"`{name}`" for name, method in CHOICES.items() if method.knows_scene
    ]
    drop_methods = [f"`{name}` is {CHOICES[name].about}" for name in BESIDE_DROPS]
    command = commands.add_parser(
        "estimate",
        help="estimate the pose statistics of a part at once",
        description="Estimate the stable poses of a part and the probability of coming "
        f"to rest in each. {listed(scene_methods)} take the restitution and the drop "
        f"height into account; the others ignore them. {'; '.join(drop_methods)}; "
        "`choice` in the JSON says what it did and why. These two alone take the "
        "number of drops, the target error, the seed and the workers. `alike` are "
        "poses with the same silhouette from above, which a camera may take for each "
        "other; with all methods they are not looked for.",
        examples=(
            "ros_pose_stats estimate demo/clamp.stl --unit mm",
            "ros_pose_stats estimate demo/clamp.stl --unit auto --density 7850",
            "ros_pose_stats estimate demo/clamp.stl --unit mm --target-error 0.02 "
            "--json",
            "ros_pose_stats estimate demo/gear.stl --unit mm --method hybrid "
            "--drops 500",
            "ros_pose_stats estimate demo/clamp.stl --unit mm --pixel 0.1mm",
            "ros_pose_stats estimate demo/hex_bolt.stl --unit mm --method all --each",
            "ros_pose_stats estimate demo/bracket.stl --unit mm --upright lying.stl",
        ),
        run=run,
    )
    arguments.add_part(command, "--accept-open", *arguments.POSE_OPTIONS)
    command.add_argument(
        "--method",
        choices=(*CHOICES, ALL),
        default=DEFAULT_METHOD,
        metavar="NAME",
        help=f"one of {', '.join(CHOICES)}, or {ALL}, which sets "
        "every estimator beside the others (default: %(default)s)",
    )
    arguments.add_options(command, *arguments.SCENE_OPTIONS, "--pixel", "--each")
    arguments.add_drop_options(command, None)
    command.add_argument(
        "--upright",
        metavar="FILE",
        help="write the mesh as the part most probably lies, resting on z = 0 with its "
        "centre of mass above the origin, as FILE.stl, in millimetres",
    )
    arguments.add_options(
        command,
        "--json",
        help="print one JSON object, or with all methods a list "
        "of them, in SI units, which the key `units` names, and no table",
    )


def run(options: argparse.Namespace) -> int:
    """Estimate and print, and write the part as it lies where that is asked for."""
    file = None
    if options.upright is not None:
        file = running.output_file(options.upright, (".stl",))
    if options.method in BESIDE_DROPS:
        status = estimate_with_drops(options, file)
    else:
        status = estimate_at_once(options, file)
    if file is not None and not options.json:
        print(f"wrote {printable(str(file))}")
    return status


def estimate_at_once(options: argparse.Namespace, file: Path | None) -> int:
    """Estimate by methods without drops, and print; the exit status."""
    refuse_other_options(options)
    with running.announce_slow_start():
        from ...core.estimators import ESTIMATORS
        from ...core.estimators.estimate import estimates_in
        from ...core.resting.silhouettes import find_lookalikes

        part = running.load_named_part(options)
        scene = arguments.drop_scene(options)
        methods = ESTIMATORS if options.method == ALL else [options.method]
        estimates = estimates_in(part, scene, methods)
        if options.method != ALL:
            estimates = [find_lookalikes(estimates[0], part, options.pixel)]
        if file is not None:
            write_upright(file, part, estimates[0])
    print_estimates(estimates, part, options)
    return 0


def estimate_with_drops(options: argparse.Namespace, file: Path | None) -> int:
    """Estimate by a method that drops the part, too, and print; the exit status."""
    part = running.load_part_and_kernels(options)
    from ...core.planning import auto, hybrid
    from ...core.resting.silhouettes import find_lookalikes

    method: Callable[..., PoseStatistics] = hybrid.hybrid
    bound = DEFAULT_DROPS
    if options.method == AUTO:
        method = auto.auto
        bound = auto.MOST_DROPS
    if options.drops is not None:
        bound = options.drops

    def drop_and_look(part: "Part", **keywords: Any) -> "PoseStatistics":
        statistics = find_lookalikes(method(part, **keywords), part, options.pixel)
        if file is not None:
            write_upright(file, part, statistics)
        return statistics

    return running.run_and_report(part, drop_and_look, bound, options)


def write_upright(file: Path, part: "Part", statistics: "PoseStatistics") -> None:
    """Write the mesh as the part most probably lies, in millimetres."""
    from ...core.mesh.files import stl_bytes
    from ...core.mesh.vectors import turn_vectors
    from ...core.planning.upright import upright

    motion = upright(part, statistics)
    vertices = turn_vectors(part.vertices, motion[:3, :3].T) + motion[:3, 3]
    write_file(file, stl_bytes(1e3 * vertices, part.triangles))


def refuse_other_options(options: argparse.Namespace) -> None:
    """Refuse options that only other methods take."""
    for name in ("pixel", "upright"):
        if getattr(options, name) is not None and options.method == ALL:
            raise RequestError(
                f"--{name} with one method", "all methods", "leave --method out"
            )
    for name in ("drops", "target_error", "seed", "workers"):
        if getattr(options, name) is not None:
            raise RequestError(
                f"--{name.replace('_', '-')} with a method that drops the part",
                f"the method {options.method}",
                f"give --method {' or '.join(BESIDE_DROPS)}, or `simulate` the part",
            )


def print_estimates(
    estimates: "Sequence[PoseStatistics]", part: "Part", options: argparse.Namespace
) -> None:
    """Print the answer of one method, or of all side by side."""
    if options.json:
        objects = [statistics.as_dict() for statistics in estimates]
        running.print_json(objects if options.method == ALL else objects[0])
    elif options.method == ALL:
        print("\n".join(methods_table(estimates, part, options.each)))
    else:
        print(running.report_table(estimates[0], part, options.each))


def methods_table(
    estimates: "Sequence[PoseStatistics]", part: "Part", each_pose: bool
) -> list[str]:
    """Lines: all methods' answers side by side, in the order of the last one's rows."""
    from ...core.records.statistics import (
        FilledColumn,
        heading,
        listed_groups,
        pose_table,
        remarks,
    )
    from ...core.statistics.pose_groups import list_poses

    last = estimates[-1]
    rows = list_poses(last, each_pose)
    columns = []
    for statistics in estimates:
        probabilities = {
            group.first.index: group.probability
            for group in list_poses(statistics, each_pose)
        }
        cells = [percent(probabilities[row.first.index]) for row in listed_groups(rows)]
        columns.append(FilledColumn(Column(statistics.method), cells))
    # Methods that ignore the drop height have none; the scene has one all the same.
    in_scene = [
        statistics for statistics in estimates if math.isfinite(statistics.drop_height)
    ]
    return [
        heading(in_scene[0] if in_scene else last, part),
        "",
        f"probability in %, ordered by {last.method}, "
        f"cluster tolerance {last.cluster_tolerance:g}",
        "",
        *pose_table(rows, columns),
        *remarks(estimates),
    ]
