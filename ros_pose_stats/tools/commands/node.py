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
