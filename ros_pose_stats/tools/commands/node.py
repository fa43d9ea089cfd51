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

"""`node`: the ROS 2 node."""

import argparse

from ...node.entry import start_node
from .terminal import arguments


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "node",
        help="start the ROS 2 node",
        usage="%(prog)s [-h] [--ros-args ...]",
        description="Start the ROS 2 node pose_stats: part meshes in, stable poses "
        "with probabilities out, drop simulations in the background, all of it "
        "recorded.",
        epilog="Parameters go behind `--ros-args`, each as `-p NAME:=VALUE`, or all in "
        "a file: `--ros-args --params-file config/pose_stats.yaml`. docs/node.md lists "
        "them.",
        examples=(
            "ros_pose_stats node --ros-args -p restitution:=0.3 -p log_directory:=bags",
        ),
        run=run,
    )
    command.set_defaults(takes_ros_arguments=True)


def run(options: argparse.Namespace) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return start_node(options.ros_arguments)
