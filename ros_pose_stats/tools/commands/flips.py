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

"""`flips PART`: where a kicked part comes to rest, and what kicking gains a feeder."""

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...base.text import Column, columns, length_in_words, percent, several
from ...core.records.notes import note_paragraph
from .terminal import arguments, cells, flip_counts, running

if TYPE_CHECKING:
    from ...core.records import FlipStatistics, Index, Part
    from ...core.simulation.request import DropRequest


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "flips",
        help="kick a part out of each of its poses and count where it comes to rest",
        description="Kick a part, lying in each of its poses, from below at a point of "
        "its contact polygon, and count where it comes to rest. With the wanted poses "
        "it says what a cell gets with this kick, and whether it should kick, as "
        "`feeding` does for many kicks. With flips that a "
        "cell has counted it gives the matrix of each of the feeder's settings: what "
        "was counted, with the model's kick that explains it best where little was.",
        examples=(
            "ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",
        ),
        run=run,
    )
    arguments.add_part(command, *arguments.POSE_OPTIONS)
    kicks = command.add_mutually_exclusive_group(required=True)
    kicks.add_argument("--kick", **arguments.OPTIONS["--kick"])
    flip_counts.add_counts_option(kicks)
    flip_counts.add_flips(command)
    arguments.add_options(command, *arguments.SCENE_OPTIONS, "--wanted")
    cells.add_cell(command)
    arguments.add_options(command, "--workers", "--json")


def run(options: argparse.Namespace) -> int:
    """Kick, plan where poses are wanted, and print."""
    part = running.load_part_and_kernels(options)
    from ...core.planning.feeding_plan import plan_feeding
    from ...core.resting.poses import poses_in

    resting_poses = poses_in(part, arguments.drop_scene(options))
    pose_count = len(resting_poses.poses)
    counted_flips = flip_counts.read_flips(options.counts, pose_count)
    request = flip_counts.flip_request(options, pose_count)
    dropped = None
    if options.wanted is not None:
        cell = cells.read_cell(options)
        dropped = cells.drop_into(cell, part, options)
    with running.stop_on_interrupt() as is_interrupted, running.ProgressBar() as bar:
        radius = resting_poses.body.radius
        flips = kick_part(
            part, radius, counted_flips, request, is_interrupted, bar, options
        )
    interruption = ""
    if is_interrupted():
        flip_count = sum(statistics.flips for statistics in flips)
        interruption = f"interrupted after {flip_count} flips"
    planned: dict[str, Any] = {}
    tables = []
    if dropped is not None and not interruption:
        plan = plan_feeding(dropped, options.wanted, cell, flips, part)
        planned["feeding"] = plan.as_dict()
        tables.append("\n".join(cells.plan_lines(dropped, plan, options.wanted)))
        flips = [
            replace(
                statistics,
                warnings=tuple(dict.fromkeys([*statistics.warnings, *plan.warnings])),
            )
            for statistics in flips
        ]
    tables += ["\n".join(flips_table(part, statistics)) for statistics in flips]
    settings = [statistics.as_dict() for statistics in flips]
    values: dict[str, Any] = {"settings": settings} if options.counts else settings[0]
    values |= planned
    return running.print_answer(options, values, ["\n\n".join(tables)], interruption)


def kick_part(
    part: "Part",
    radius: float,
    counted_flips: "dict[str, Index]",
    request: "DropRequest",
    should_stop: "Callable[[], bool]",
    bar: running.ProgressBar,
    options: argparse.Namespace,
) -> "list[FlipStatistics]":
    """Flips by the kick of the options, or what explains the counts of each setting."""
    from ...core.simulation import flips
    from ...core.simulation.request import Watch

    if not counted_flips:
        statistics = flips.count_flips(
            part,
            arguments.drop_scene(options),
            options.kick,
            request,
            Watch(should_stop=should_stop),
            lambda count, total: bar.draw(count / total, f"{count} of {total} flips"),
        )
        return [statistics]
    simulated_flips = flip_counts.kick_from_heights(
        part, flips.usual_kicks(radius), request, should_stop, bar, options
    )
    if should_stop():
        return []
    return flip_counts.learn_settings(simulated_flips, counted_flips)


def flips_table(part: "Part", flips: "FlipStatistics") -> list[str]:
    """Lines: the kick, and shares of poses out of each pose."""
    heads = [
        Column("out of"),
        *(Column(f"{pose.index}") for pose in flips.poses),
        Column("error"),
    ]
    rows = [
        [str(i), *(percent(share) for share in shares), percent(max(errors))]
        for i, (shares, errors) in enumerate(
            zip(flips.transition.tolist(), flips.standard_error.tolist(), strict=True)
        )
    ]
    return [
        *describe_flips(part, flips),
        "",
        "into pose, %; the error is the largest standard error of a row",
        *columns(heads, rows),
        *note_paragraph(flips.warnings),
    ]


def describe_flips(part: "Part", flips: "FlipStatistics") -> list[str]:
    """How the part was kicked, and how often, or which counts the kick explains."""
    kick = (
        f"kicked by {length_in_words(flips.kick_height)} on a frictionless plate, "
        f"restitution {flips.restitution:g}"
    )
    if flips.feeder_setting:
        return [
            f"{part.part_id}: {several(flips.counted_flips, 'flip')} counted at "
            f"setting {flips.feeder_setting}; the model's kick that explains them "
            "best:",
            kick,
        ]
    return [
        f"{part.part_id}: {kick}",
        f"{int(flips.counts.sum())} flips, {int(flips.unsettled.sum())} unsettled, "
        f"seed {flips.seed}",
    ]
