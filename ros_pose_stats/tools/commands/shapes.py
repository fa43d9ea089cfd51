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
