"""`compile`, `shapes DIR`, `completion SHELL`: kernels, demo parts, and what Tab completes."""

import argparse
import time
from functools import partial

from . import arguments as given, running


def register(commands: given.Commands) -> None:
    """Add the command."""
    commands.add_parser(
        "compile",
        help="compile all kernels, once for this user",
        description="Compile all kernels, on all cores, and keep their machine code in "
        "`ros_pose_stats/` below `$NUMBA_CACHE_DIR`, else `$XDG_CACHE_HOME`, else `~/.cache`. "
        "Without it, the first command that needs one compiles all. `make setup` does it, too.",
        examples=("ros_pose_stats compile",),
        run=run,
    )


def run(_: argparse.Namespace) -> int:
    """Compile the missing kernels and print where all of them are."""
    from ...core.kernels import compilation, machine_code

    kernels = compilation.all_kernels()
    begin = time.monotonic()
    if running.compile_missing():
        print(f"compiled in {time.monotonic() - begin:.0f} s")
    lost = [one for one in kernels if not one.is_stored()]
    if lost:
        raise OSError(f"{len(lost)} kernels into {machine_code.cache_directory()}")
    print(f"all {len(kernels)} kernels are in {machine_code.cache_directory()}")
    return 0


def register_shapes(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "shapes",
        help="write the demo parts as STL files",
        description="Write the demo parts (clamp, bracket, hex bolt, "
        "gear, prism, cylinder) as STL files in millimetres.",
        examples=("ros_pose_stats shapes demo",),
        run=run_shapes,
    )
    command.add_argument(
        "directory",
        metavar="DIR",
        help="directory for the files; created if it is missing",
    )


def run_shapes(options: argparse.Namespace) -> int:
    """Write the files and name them."""
    from ...core.shapes.demo_parts import write_demo_parts

    for path in write_demo_parts(options.directory):
        print(path)
    return 0


SHELLS = ("bash", "zsh")
PATHS = (
    "DIR",
    "FILE",
    "PART",
    "STEM",
)  # metavars that stand for the name of a file or directory

FILE = {
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

ROS = {
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


def register_completion(commands: given.Commands, top: argparse.ArgumentParser) -> None:
    """Add the command, which reads all parsers below `top` when it runs."""
    command = commands.add_parser(
        "completion",
        help="print a script that completes commands and options on Tab",
        description="Print a script for the shell that completes commands, options, their "
        "choices and file names when Tab is pressed: add the line "
        '`eval "$(ros_pose_stats completion bash)"` to `~/.bashrc`, or the same with `zsh` to '
        "`~/.zshrc` behind `compinit`.",
        examples=("ros_pose_stats completion bash",),
        run=partial(print_completion, top),
    )
    command.add_argument("shell", choices=SHELLS, help="the shell: bash or zsh")


def print_completion(top: argparse.ArgumentParser, options: argparse.Namespace) -> int:
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
        behind = parser.add_argument(
            "--ros-args", nargs=argparse.REMAINDER, help="arguments for ROS follow"
        )
        behind.complete = ROS  # type: ignore[attr-defined]
