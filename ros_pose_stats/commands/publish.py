"""`publish PART`: a CAD file on ~/part_mesh, latched."""

from __future__ import annotations

import argparse

from .arguments import add_file_options
from .node import prepare_ros, ros_arguments


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
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
    add_file_options(command)
    command.add_argument("--restitution", type=float, metavar="R",
                         help="coefficient of restitution for this part, 0 to below 1 "
                         "(default: the node's)")
    command.add_argument("--drop-height", type=float, metavar="H",
                         help="height of the centre of mass at release for this part, in metres "
                         "whatever the unit of the file (default: the node's)")
    command.add_argument("--part-id", default="", metavar="ID",
                         help="name of the part (default: the file's name without its suffix)")
    command.add_argument("--topic", default="/pose_stats/part_mesh", metavar="T",
                         help="topic to publish on (default: %(default)s)")
    command.add_argument("--seconds", type=float, metavar="S",
                         help="end after this long (default: at Ctrl-C)")
    command.set_defaults(run=run, takes_ros_arguments=True)


def run(options: argparse.Namespace) -> int:
    """Publish until Ctrl-C."""
    arguments = ros_arguments("part_publisher", options.ros_arguments)
    prepare_ros()
    from ..ros.part_publisher import publish_part

    return publish_part(options.part, options.unit, options.com, options.part_id, options.topic,
                        options.seconds, arguments, mass=options.mass, density=options.density,
                        restitution=options.restitution, drop_height=options.drop_height)
