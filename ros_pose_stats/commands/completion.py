"""`completion SHELL`: a script that completes commands, options and their values on Tab."""

import argparse
from functools import partial

from . import arguments as given

SHELLS = ("bash", "zsh")
PATHS = ("DIR", "FILE", "PART", "STEM")  # metavars that stand for the name of a file or directory

FILE = {"bash": "_ros_pose_stats_files", "zsh": "_files", "preamble": {"bash": """\
# Names of files, also those begun with an escaped space.
_ros_pose_stats_files() {
    compgen -f -- "$1"
}"""}}

ROS = {"bash": "_ros_pose_stats_ros_words", "zsh": "_files", "preamble": {"bash": """\
# What goes behind --ros-args.
_ros_pose_stats_ros_words() {
    compgen -W "-p -r --params-file" -- "${COMP_WORDS[COMP_CWORD]}"
    compgen -f -- "${COMP_WORDS[COMP_CWORD]}"
}"""}}


def register(commands: given.Commands, top: argparse.ArgumentParser) -> None:
    """Add the command, which reads all parsers below `top` when it runs."""
    command = commands.add_parser(
        "completion", help="print a script that completes commands and options on Tab",
        description="Print a script for the shell that completes commands, options, their "
        "choices and file names when Tab is pressed: add the line "
        "`eval \"$(ros_pose_stats completion bash)\"` to `~/.bashrc`, or the same with `zsh` to "
        "`~/.zshrc` behind `compinit`.",
        examples=("ros_pose_stats completion bash",))
    command.add_argument("shell", choices=SHELLS, help="the shell: bash or zsh")
    command.set_defaults(run=partial(run, top))


def run(top: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    """Print the script."""
    import shtab  # which no other command wants

    _mark_files(top)
    print(shtab.complete(top, options.shell))
    return 0


def _mark_files(parser: argparse.ArgumentParser) -> None:
    """Say of the arguments of a parser and those below it which are names of files."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _mark_files(command)
        elif action.metavar in PATHS:
            action.complete = FILE  # type: ignore[attr-defined]
    if parser.get_default("takes_ros_arguments"):
        behind = parser.add_argument("--ros-args", nargs=argparse.REMAINDER,
                                     help="arguments for ROS follow")
        behind.complete = ROS  # type: ignore[attr-defined]
