"""`shapes DIR`: the demo parts as files."""

import argparse

from .terminal import arguments


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "shapes",
        help="write the demo parts as STL files",
        description="Write the demo parts (clamp, bracket, hex bolt, "
        "gear, prism, cylinder) as STL files in millimetres.",
        examples=("ros_pose_stats shapes demo",),
        run=run,
    )
    command.add_argument(
        "directory",
        metavar="DIR",
        help="directory for the files; created if it is missing",
    )


def run(options: argparse.Namespace) -> int:
    """Write the files and name them."""
    from ...core.shapes.demo_parts import write_demo_parts

    for path in write_demo_parts(options.directory):
        print(path)
    return 0
