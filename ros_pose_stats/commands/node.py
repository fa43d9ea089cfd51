"""`node`: the ROS 2 node `pose_stats`."""

from __future__ import annotations

import argparse
import sys

from ..errors import PoseStatsError
from .ros_start import prepare_ros, ros_arguments


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "node", help="start the ROS 2 node", usage="%(prog)s [-h] [--ros-args ...]",
        description="Start the ROS 2 node pose_stats: part meshes in, stable poses with "
        "probabilities out, drop simulations in the background, all of it recorded.",
        epilog="Parameters go behind `--ros-args`, each as `-p NAME:=VALUE`, or all in a file: "
        "`--ros-args --params-file config/pose_stats.yaml`. docs/node.md lists them.",
        examples=("ros_pose_stats node --ros-args -p restitution:=0.3 -p log_directory:=bags",))
    command.set_defaults(run=run, takes_ros_arguments=True)


def run(options: argparse.Namespace) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return _run(options.ros_arguments)


def main() -> int:
    """The executable `pose_stats_node`."""
    try:
        return _run(sys.argv[1:])
    except PoseStatsError as refusal:
        print(f"pose_stats_node: {refusal}", file=sys.stderr)
        return 2


def _run(rest: list[str]) -> int:
    arguments = ros_arguments("pose_stats_node", rest)
    prepare_ros()
    from ..ros.stop_signals import StopSignals

    stop = StopSignals()
    from ..ros.main import run_node

    return run_node(stop, arguments)
