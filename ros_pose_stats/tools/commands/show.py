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

"""`show`: what a running node has latched."""

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...base import text
from ...node.entry import ros_arguments
from .terminal import arguments, node_answers, running

if TYPE_CHECKING:
    from ...core.records import PoseStatistics


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "show",
        help="print what the node has latched",
        description="Print what a running node has latched: of one part the table of "
        "its poses, else a row for each part.",
        examples=("ros_pose_stats show", "ros_pose_stats show clamp --watch"),
        run=run,
    )
    command.add_argument(
        "part_id",
        nargs="?",
        default="",
        metavar="PART_ID",
        help="name of a part (default: list all parts)",
    )
    arguments.add_options(command, "--node")
    command.add_argument(
        "--watch", action="store_true", help="go on with every new result, until Ctrl-C"
    )
    arguments.add_options(command, "--each")
    arguments.add_options(
        command,
        "--json",
        help="print one JSON object, or of all parts a list of them, in "
        "SI units, which the key `units` names, and no table",
    )
    command.set_defaults(takes_ros_arguments=True)


def run(options: argparse.Namespace) -> int:
    """Print what is latched."""
    words = ros_arguments("pose_stats_show", options.ros_arguments)
    node_answers.prepare_client()
    from ...node.client import latched_results

    for results in latched_results(options.node, options.part_id, options.watch, words):
        if options.part_id:
            for statistics in results:
                node_answers.print_statistics(statistics, None, options)
        elif options.json:
            running.print_json([statistics.as_dict() for statistics in results])
        else:
            print(*parts_table(results), sep="\n")
        sys.stdout.flush()
    return 0


def parts_table(results: "Sequence[PoseStatistics]") -> list[str]:
    """Lines: a row a part: its most probable poses, by which method, and the error."""
    if not results:
        return ["no parts; send one: ros_pose_stats publish PART"]
    heads = [
        text.Column("part", left=True),
        text.Column("poses"),
        text.Column("most probable", "pose: %", left=True),
        text.Column("method", left=True),
        text.Column("drops"),
        text.Column("counted"),
        text.Column("error", "points"),
        text.Column("against", left=True),
    ]
    rows = [
        (
            statistics.part_id,
            str(len(statistics.poses)),
            text.most_probable(statistics.poses) or "forgotten",
            statistics.method,
            str(statistics.drops or "-"),
            str(statistics.counted_parts or "-"),
            text.percent(statistics.expected_error),
            "the plate" if statistics.counted_parts else "drops",
        )
        for statistics in results
    ]
    return text.columns(heads, rows)
