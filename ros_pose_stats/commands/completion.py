"""`completion SHELL`: a script that completes commands, options and their values on Tab."""

import argparse
import shlex
from functools import partial

from . import arguments as given

SHELLS = ("bash", "zsh")

PATHS = ("DIR", "FILE", "PART", "STEM")
"""Metavars that stand for the name of a file or directory."""

WHOLE_WORDS = """

# bash makes three words of --unit=mm; without the sign they are what --unit mm is.
_ros_pose_stats() {
    local word words=() current=$COMP_CWORD k
    for ((k = 0; k <= COMP_CWORD; k++)); do
        word=${COMP_WORDS[k]}
        if [[ $word == = && k -lt COMP_CWORD ]]; then
            current=$((current - 1))
        else
            words+=("${word#=}")
        fi
    done
    local COMP_WORDS=("${words[@]}") COMP_CWORD=$current
    _shtab_ros_pose_stats
}

complete -o bashdefault -F _ros_pose_stats ros_pose_stats
"""
"""Behind the script for bash."""

SOURCED = """\
#compdef ros_pose_stats

# Sourced, it is to be registered, which it is where it is evaluated.
if [[ $zsh_eval_context[-1] == file ]]; then
    eval {quoted}
    return
fi
{script}"""
"""The script for zsh, which by itself takes being sourced for being asked what to offer."""

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


def register(commands: given.Commands,
             top: argparse.ArgumentParser) -> None:
    """Add the command, which reads all parsers below `top` when it runs."""
    command = commands.add_parser(
        "completion", help="print a script that completes commands and options on Tab",
        description="Print a script for the shell that completes commands, options, their "
        "choices and file names when Tab is pressed. For bash, add the line "
        "`source <(ros_pose_stats completion bash)` to `~/.bashrc`. For zsh, write the script to "
        "a file `_ros_pose_stats` in a directory of `$fpath`, or add the line "
        "`source <(ros_pose_stats completion zsh)` to `~/.zshrc` behind `compinit`.",
        examples=("ros_pose_stats completion bash",))
    command.add_argument("shell", choices=SHELLS, help="the shell: bash or zsh")
    command.set_defaults(run=partial(run, top))


def run(top: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    """Print the script."""
    import shtab  # which no other command wants

    _mark_files(top)
    script = shtab.complete(top, options.shell)
    print(script + WHOLE_WORDS if options.shell == "bash" else
          SOURCED.format(quoted=shlex.quote(script), script=script), end="")
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
