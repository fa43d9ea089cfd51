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

"""`completion SHELL`: what Tab completes."""

import argparse
import copy

from ...base.extras import require_modules
from .terminal import arguments

SHELLS = ("bash", "zsh")
FILE_METAVARS = ("DIR", "FILE", "PART", "STEM")

FILE_COMPLETION = {
    "bash": "_ros_pose_stats_files",
    "zsh": "_files",
    "preamble": {
        "bash": """\
# Names of files, also those begun with an escaped space.
_ros_pose_stats_files() {
    compgen -f -- "$1"
}"""
    },
}

ROS_COMPLETION = {
    "bash": "_ros_pose_stats_ros_words",
    "zsh": "_files",
    "preamble": {
        "bash": """\
# What goes behind --ros-args.
_ros_pose_stats_ros_words() {
    compgen -W "-p -r --params-file" -- "${COMP_WORDS[COMP_CWORD]}"
    compgen -f -- "${COMP_WORDS[COMP_CWORD]}"
}"""
    },
}


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "completion",
        help="print a script that completes commands and options on Tab",
        description="Print a script for the shell that completes commands, options, "
        "their choices and file names when Tab is pressed: add the line "
        '`eval "$(ros_pose_stats completion bash)"` to `~/.bashrc`, or the same with '
        "`zsh` to `~/.zshrc` behind `compinit`.",
        examples=("ros_pose_stats completion bash",),
        run=run,
    )
    command.add_argument("shell", choices=SHELLS, help="the shell: bash or zsh")


def run(options: argparse.Namespace) -> int:
    """Print the script for the whole command line, which is in the options."""
    require_modules("shtab")
    import shtab

    command_line = copy.deepcopy(options.parser)
    mark_arguments(command_line)
    print(shtab.complete(command_line, options.shell))
    return 0


def mark_arguments(parser: argparse.ArgumentParser) -> None:
    """Say of the arguments of a parser and those below it which are names of files."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                mark_arguments(command)
        elif action.metavar in FILE_METAVARS:
            action.complete = FILE_COMPLETION  # type: ignore[attr-defined]
    if parser.get_default("takes_ros_arguments"):
        # argparse is never told: `main` has divided the words before it parses.
        ros_arguments = parser.add_argument(
            "--ros-args", nargs=argparse.REMAINDER, help="arguments for ROS follow"
        )
        ros_arguments.complete = ROS_COMPLETION  # type: ignore[attr-defined]
