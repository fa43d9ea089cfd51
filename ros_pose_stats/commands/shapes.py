"""`shapes DIR`: the demo parts as STL files."""

from __future__ import annotations

import argparse


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser("shapes", help="write the demo parts as STL files",
                                  description="Write the demo parts (clamp, bracket, hex bolt, "
                                  "gear, prism, cylinder) as STL files in millimetres.",
                                  examples=("ros_pose_stats shapes demo",))
    command.add_argument("directory", metavar="DIR",
                         help="directory for the files; created if it is missing")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the files and name them."""
    from ..shapes.demo_parts import write_demo_parts

    for path in write_demo_parts(options.directory):
        print(path)
    return 0
