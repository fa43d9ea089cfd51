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

"""A feeder's cell: its options, and its plan in lines for people."""

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....base.text import (
    Column,
    bounded,
    columns,
    listed,
    millimetres,
    name_poses,
    three_digits,
)
from . import arguments, flip_counts

if TYPE_CHECKING:
    from ....core.planning.feeder_cell import FeederCell, KickPlan
    from ....core.planning.feeding_plan import FeedingPlan
    from ....core.records import Part, PoseStatistics

TIMES = {
    "pick-time": (1.0, "seconds to pick a part"),
    "camera-time": (0.2, "seconds of a picture"),
    "drop-time": (0.5, "seconds until dropped or kicked parts lie still"),
}


def add_cell(command: arguments.CommandParser, **rate: object) -> None:
    """Add the options of a cell; `rate`: what this command has otherwise of that."""
    command.add_argument(
        "--plate",
        nargs=2,
        type=arguments.read_length,
        metavar=("L", "W"),
        help="sides of the area over which the centres of the parts spread, as 0.3 "
        "(metres) or 300mm; a robot picks one part at a time there, and all others "
        "are kicked together (default: parts come singly, without a plate)",
    )
    command.add_argument(
        "--clearance",
        type=arguments.read_length,
        default=0.0,
        metavar="C",
        help="room that the gripper needs around a part on a plate, as 0.002 or 2mm "
        "(default: 0)",
    )
    arguments.add_options(command, "--rate", **rate)
    arguments.add_options(command, "--cycle-time", "--pixel")
    for name, (seconds, about) in TIMES.items():
        command.add_argument(
            f"--{name}",
            type=float,
            default=seconds,
            metavar="S",
            help=f"{about}, with --plate (default: %(default)s)",
        )


CELL_OPTIONS = (
    "plate",
    "clearance",
    "rate",
    "cycle_time",
    *(name.replace("-", "_") for name in TIMES),
)
"""By the names of their values."""


def read_cell(options: argparse.Namespace) -> "FeederCell":
    """The cell that the options describe."""
    from ....core.planning.feeder_cell import FeederCell

    plate = None if options.plate is None else tuple(options.plate)
    return FeederCell(
        options.rate,
        plate,
        options.clearance,
        options.cycle_time,
        options.pick_time,
        options.camera_time,
        options.drop_time,
    )


def drop_into(
    cell: "FeederCell", part: "Part", options: argparse.Namespace
) -> "PoseStatistics":
    """How parts lie that are dropped in a cell, as its camera sees them.

    By the default answer, and what `--counts` has of parts as they lie after a drop.
    Raises RequestError at once where no plan can be made.
    """
    from ....core.planning import auto, feeding_plan
    from ....core.resting.silhouettes import find_lookalikes

    statistics = auto.auto(part, seed=options.seed, **arguments.scene_keywords(options))
    if flip_counts.is_of_landings(options.counts):
        statistics = flip_counts.learn_landings(statistics, part, options)
    feeding_plan.check_feeding(statistics, options.wanted, cell)
    return find_lookalikes(statistics, part, options.pixel)


def plan_lines(
    statistics: "PoseStatistics", plan: "FeedingPlan", wanted: Sequence[int]
) -> list[str]:
    """A plan for people: the cell, what it gets, actions, and a row for each kick."""
    from ....core.planning.feeder_cell import FLIPS_ERROR

    pickable = []
    if plan.best.parts > 0:
        pickable = [f"the first picture has {plan.best.pickable:.3g} to pick"]
    flips_error = ""
    if len(plan.options) > 1:
        flips_error = f" and {100.0 * FLIPS_ERROR:g} of flips that nobody counted"
    return [
        f"{statistics.part_id}: {plan.cell}",
        plan.describe_gain(),
        f"{statistics.scene}, method {statistics.method}",
        *action_lines(plan, wanted),
        *pickable,
        "",
        *options_table(plan),
        f"in brackets: 90 % intervals, with {100.0 * statistics.plate_error:.2g} "
        f"points of error of the plate{flips_error}",
    ]


def action_lines(plan: "FeedingPlan", wanted: Sequence[int]) -> list[str]:
    """What to do with parts in which poses, a line for each action."""
    actions = {
        "pick": "pick",
        "flip": "flip",
        "leave": "leave" if plan.best.parts > 0 else "drop again",
    }
    poses_by_action = {
        action: [k for k, planned in enumerate(plan.actions) if planned == action]
        for action in actions
    }
    mistakes = ""
    mistaken_poses = [k for k in poses_by_action["pick"] if k not in wanted]
    if mistaken_poses:
        mistakes = f"; {name_poses(mistaken_poses)} by mistake, only wanted ones count"
    return [
        f"{actions[action]}: {listed(poses)}{mistakes if action == 'pick' else ''}"
        for action, poses in poses_by_action.items()
        if poses
    ]


def options_table(plan: "FeedingPlan") -> list[str]:
    """A row for each kick: what it takes, what it gains, and how good it is."""
    plate_heads = []
    if plan.best.parts:
        plate_heads = [
            Column("parts on the plate"),
            Column("kicks until it is emptied"),
        ]
    heads = [
        Column("kick height", "mm"),
        *plate_heads,
        Column("drops a part"),
        Column("flips a part"),
        Column("picked a minute"),
        Column("", left=True),
    ]
    return columns(heads, [option_cells(option, plan.best) for option in plan.options])


def option_cells(option: "KickPlan", best: "KickPlan") -> list[str]:
    """The cells of a row; drops and flips are those of a picked part."""
    from ....core.planning.plate import MOST_KICKS

    plate_cells = []
    if option.parts:
        is_endless = option.kicks >= MOST_KICKS
        kicks = f"{MOST_KICKS} or more" if is_endless else f"{option.kicks}"
        plate_cells = [f"{option.parts}", kicks]
    mark = ""
    if option is best:
        mark = "best"
    elif option.kick_height and not option.is_kicking:
        mark = "gains nothing"
    elif option.per_minute.high >= best.per_minute.value:
        mark = "as good, within its error"
    return [
        millimetres(option.kick_height),
        *plate_cells,
        three_digits(option.passes.value),
        three_digits(option.flips.value),
        bounded(option.per_minute),
        f"{option.feeder_setting} {mark}".strip(),
    ]
