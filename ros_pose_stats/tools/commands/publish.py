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

"""`publish PART`: a part sent to the node, and what the node answers."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from ...node.entry import ros_arguments
from .terminal import arguments, node_answers, running


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "publish",
        help="send a part to the node and print its answer",
        description="Publish a mesh file as PartMesh, latched, and print what the node "
        "answers. After five seconds without an answer it publishes on, for a node "
        "that starts later.",
        examples=(
            "ros_pose_stats publish demo/clamp.stl --unit mm",
            "ros_pose_stats publish demo/clamp.stl --unit mm --mass 0.06 --restitution "
            "0.3",
        ),
        run=run,
    )
    arguments.add_part(
        command,
        help="unit of the file, in any spelling; STL, OBJ, PLY and OFF files name none "
        "and need it (default: auto, what the file names)",
    )
    arguments.add_options(
        command,
        "--restitution",
        default=None,
        help="coefficient of restitution for this "
        "part, 0 to below 1 (default: the node's)",
    )
    arguments.add_options(
        command,
        "--drop-height",
        help="height of the centre of mass at release for this "
        "part, as 0.2 (metres) or 200mm (default: the node's)",
    )
    command.add_argument(
        "--part-id",
        default="",
        metavar="ID",
        help="name of the part (default: the file's name without its suffix)",
    )
    arguments.add_options(command, "--node")
    command.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help="give up after this long (default: at Ctrl-C)",
    )
    arguments.add_options(command, "--each", "--json")
    command.set_defaults(takes_ros_arguments=True)


def run(options: argparse.Namespace) -> int:
    """Publish until a node has answered, and print the answer."""
    words = ros_arguments("part_publisher", options.ros_arguments)
    node_answers.prepare_client()
    from ...node.client import publish_part, read_part

    part_id = options.part_id or Path(options.part).stem
    part, message = read_part(
        options.part,
        options.unit,
        options.com,
        part_id,
        options.mass,
        options.density,
        options.body,
    )
    # With --json the output is the node's answer alone.
    progress_stream = sys.stderr if options.json else sys.stdout
    status = running.INTERRUPTED
    for statistics in publish_part(
        part,
        message,
        options.restitution,
        options.drop_height,
        options.node,
        options.seconds,
        words,
        lambda line: print(line, file=progress_stream, end="\n\n", flush=True),
        lambda line: print(line, file=sys.stderr),
    ):
        warnings = tuple(dict.fromkeys((*part.warnings, *statistics.warnings)))
        node_answers.print_statistics(
            replace(statistics, warnings=warnings), part, options
        )
        sys.stdout.flush()
        status = 0
    return status
