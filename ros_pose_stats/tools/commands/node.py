"""`node`, `publish PART` and `show`: the ROS 2 node, a part sent to it, what it has latched."""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base import text
from ...base.errors import PoseStatsError, RequestError
from . import arguments as given, running

if TYPE_CHECKING:
    from ...core.records import PoseStatistics

INTERFACES = "ros_pose_stats_msgs"


def prepare_ros() -> None:
    """Check that ROS is there, and keep linear algebra off the cores that simulate."""
    if find_spec("rclpy") is None:
        raise RequestError(
            "ROS 2 Jazzy to be importable",
            "no module rclpy",
            "source /opt/ros/jazzy/setup.bash, or run `make setup` and use .venv",
        )
    if find_spec(INTERFACES) is None:
        raise RequestError(
            f"the interface package {INTERFACES}",
            "none",
            "build it: `make setup`, or in a workspace `colcon build --base-paths . msg_defs`",
        )
    if "numpy" not in sys.modules:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def prepare_answer() -> None:
    """The same for what prints an answer, which errors of DDS keep off: they go to stderr."""
    prepare_ros()
    if sys.__stdout__ is sys.stdout is not None and sys.__stderr__ is not None:
        sys.stdout = os.fdopen(
            os.dup(1), "w", 1, sys.stdout.encoding, "backslashreplace"
        )
        os.dup2(2, 1)


def ros_arguments(program: str, rest: list[str]) -> list[str]:
    """Arguments for rclpy, of which there is nothing before `--ros-args`."""
    for option, file in pairwise(rest):
        if option == "--params-file" and not Path(file).is_file():
            raise RequestError(
                "a file after --params-file",
                f"'{file}', which is none",
                "check the path",
            )
    if rest and rest[0] != "--ros-args":
        raise RequestError(
            "ROS arguments after --ros-args",
            " ".join(rest),
            "for instance --ros-args -p log_directory:=/tmp/bags",
        )
    return [program, *rest]


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "node",
        help="start the ROS 2 node",
        usage="%(prog)s [-h] [--ros-args ...]",
        description="Start the ROS 2 node pose_stats: part meshes in, stable poses with "
        "probabilities out, drop simulations in the background, all of it recorded.",
        epilog="Parameters go behind `--ros-args`, each as `-p NAME:=VALUE`, or all in a file: "
        "`--ros-args --params-file config/pose_stats.yaml`. docs/node.md lists them.",
        examples=(
            "ros_pose_stats node --ros-args -p restitution:=0.3 -p log_directory:=bags",
        ),
        run=run,
    )
    command.set_defaults(takes_ros_arguments=True)


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
    from ...node.stop_signals import StopSignals

    stop = StopSignals()
    from ...node.node import run_node

    return run_node(stop, arguments)


def register_publish(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "publish",
        help="send a part to the node and print its answer",
        description="Publish a mesh file as PartMesh, latched, and print what the node answers. "
        "After five seconds without an answer it publishes on, for a node that starts later.",
        examples=(
            "ros_pose_stats publish demo/clamp.stl --unit mm",
            "ros_pose_stats publish demo/clamp.stl --unit mm --mass 0.06 --restitution 0.3",
        ),
        run=run_publish,
    )
    given.add_part(command)
    given.add(
        command,
        "--restitution",
        default=None,
        help="coefficient of restitution for this "
        "part, 0 to below 1 (default: the node's)",
    )
    given.add(
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
    command.add_argument(
        "--topic",
        default="/pose_stats/part_mesh",
        metavar="T",
        help="topic to publish on (default: %(default)s)",
    )
    command.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help="give up after this long (default: at Ctrl-C)",
    )
    given.add(command, "--each", "--json")
    command.set_defaults(takes_ros_arguments=True)


def run_publish(options: argparse.Namespace) -> int:
    """Publish until a node has answered, and print the answer."""
    arguments = ros_arguments("part_publisher", options.ros_arguments)
    prepare_answer()
    from ...node.client import publish_part, read_part

    part_id = options.part_id or Path(options.part).stem
    part, message = read_part(
        options.part, options.unit, options.com, part_id, options.mass, options.density
    )
    status = running.INTERRUPTED
    for found in publish_part(
        part,
        message,
        options.restitution,
        options.drop_height,
        options.topic,
        options.seconds,
        arguments,
        lambda line: print(
            line,
            file=sys.stderr if options.json else sys.stdout,
            end="\n\n",
            flush=True,
        ),
        lambda line: print(line, file=sys.stderr),
    ):
        warnings = dict.fromkeys((*part.warnings, *found.warnings))
        _print_result(replace(found, warnings=tuple(warnings)), part, options)
        sys.stdout.flush()
        status = 0
    return status


def register_show(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "show",
        help="print what the node has latched",
        description="Print what a running node has latched: of one part the table of its poses, "
        "else a row for each part.",
        examples=("ros_pose_stats show", "ros_pose_stats show clamp --watch"),
        run=run_show,
    )
    command.add_argument(
        "part_id",
        nargs="?",
        default="",
        metavar="PART_ID",
        help="name of a part (default: list all parts)",
    )
    command.add_argument(
        "--node",
        default="/pose_stats",
        metavar="NAME",
        help="full name of the node (default: %(default)s)",
    )
    command.add_argument(
        "--watch", action="store_true", help="go on with every new result, until Ctrl-C"
    )
    given.add(command, "--each")
    given.add(
        command,
        "--json",
        help="print one JSON object, or of all parts a list of them, in "
        "SI units, which the key `units` names, and no table",
    )
    command.set_defaults(takes_ros_arguments=True)


def run_show(options: argparse.Namespace) -> int:
    """Print what is latched."""
    arguments = ros_arguments("pose_stats_show", options.ros_arguments)
    prepare_answer()
    from ...node.client import latched_results

    for results in latched_results(
        options.node, options.part_id, options.watch, arguments
    ):
        if options.part_id:
            for found in results:
                _print_result(found, None, options)
        elif options.json:
            running.print_json([found.as_dict() for found in results])
        else:
            print(_parts_table(results))
        sys.stdout.flush()
    return 0


def _parts_table(results: "Sequence[PoseStatistics]") -> str:
    """A row for each part: its most probable poses, by which method, and the error."""
    if not results:
        return "no parts; send one: ros_pose_stats publish PART"
    heads = [
        text.Column("part", left=True),
        text.Column("poses"),
        text.Column("most probable", "pose: %", left=True),
        text.Column("method", left=True),
        text.Column("drops"),
        text.Column("error", "points"),
    ]
    rows = [
        (
            statistics.part_id,
            str(len(statistics.poses)),
            text.most_probable(statistics.poses) or "forgotten",
            statistics.method,
            str(statistics.observed or statistics.drops),
            text.percent(statistics.expected_error),
        )
        for statistics in results
    ]
    return "\n".join(text.columns(heads, rows))


def _print_result(found: Any, part: Any, options: argparse.Namespace) -> None:
    if options.json:
        running.print_json(found.as_dict())
    elif found.poses:
        print(running.report_table(found, part, options.each))
    else:
        print(*found.warnings, sep="\n")
