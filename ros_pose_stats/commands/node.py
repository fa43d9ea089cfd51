"""`node` and `publish PART`: the ROS 2 node, and a CAD file that is sent to it."""

import argparse
import os
import sys
from importlib.util import find_spec
from pathlib import Path

from ..errors import PoseStatsError, RequestError
from . import arguments as given

INTERFACES = "ros_pose_stats_msgs"


class RosMissingError(PoseStatsError):
    """ROS or the interface package cannot be imported."""


def prepare_ros() -> None:
    """Check that ROS is there, and keep linear algebra off the cores that simulate.

    Raises RosMissingError if one cannot; the message has the command that helps.
    """
    if find_spec("rclpy") is None:
        raise RosMissingError("ROS 2 Jazzy to be importable", "no module rclpy",
                         "source /opt/ros/jazzy/setup.bash, or run `make setup` and use .venv")
    if find_spec(INTERFACES) is None:
        raise RosMissingError(
            f"the interface package {INTERFACES}", "none",
            "build it: `make setup`, or in a workspace `colcon build --base-paths . msg_defs`")
    if "numpy" not in sys.modules:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def ros_arguments(program: str, rest: list[str]) -> list[str]:
    """Arguments for rclpy.

    Raises RequestError if there is something before `--ros-args`.
    """
    files = [rest[k + 1] for k, word in enumerate(rest[:-1]) if word == "--params-file"]
    for file in files:
        if not Path(file).is_file():
            raise RequestError("a file after --params-file", f"'{file}', which is none",
                               "check the path")
    if rest and rest[0] != "--ros-args":
        raise RequestError("ROS arguments after --ros-args", " ".join(rest),
                         "for instance --ros-args -p log_directory:=/tmp/bags")
    return [program, *rest]


def register(commands: given.Commands) -> None:
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


def register_publish(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "publish", help="publish a part's mesh to the node",
        usage="%(prog)s [-h] [--unit U] [--com X Y Z] [--mass KG] [--density KG_M3] "
        "[--restitution R] [--drop-height H] [--part-id ID] [--topic T] [--seconds S] PART "
        "[--ros-args ...]",
        description="Publish a mesh file as PartMesh, latched, until Ctrl-C: a node that starts "
        "later gets it too.",
        examples=("ros_pose_stats publish demo/clamp.stl --unit mm",
                  "ros_pose_stats publish demo/clamp.stl --unit mm --mass 0.06 --restitution 0.3"))
    given.add_file_options(command)
    command.add_argument("--restitution", type=float, metavar="R",
                         help="coefficient of restitution for this part, 0 to below 1 "
                         "(default: the node's)")
    command.add_argument("--drop-height", type=given.read_length, metavar="H",
                         help="height of the centre of mass at release for this part, as 0.2 "
                         "(metres) or 200mm (default: the node's)")
    command.add_argument("--part-id", default="", metavar="ID",
                         help="name of the part (default: the file's name without its suffix)")
    command.add_argument("--topic", default="/pose_stats/part_mesh", metavar="T",
                         help="topic to publish on (default: %(default)s)")
    command.add_argument("--seconds", type=float, metavar="S",
                         help="end after this long (default: at Ctrl-C)")
    command.set_defaults(run=run_publish, takes_ros_arguments=True)


def run_publish(options: argparse.Namespace) -> int:
    """Publish until Ctrl-C."""
    arguments = ros_arguments("part_publisher", options.ros_arguments)
    prepare_ros()
    from ..ros.part_publisher import publish_part

    return publish_part(options.part, options.unit, options.com, options.part_id, options.topic,
                        options.seconds, arguments, mass=options.mass, density=options.density,
                        restitution=options.restitution, drop_height=options.drop_height)
