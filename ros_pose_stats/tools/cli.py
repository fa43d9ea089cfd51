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

"""The command `ros_pose_stats`: parses, runs, and turns refusals into statuses."""

import argparse
import atexit
import gc
import io
import os
import pkgutil
import sys
import traceback
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from types import ModuleType

from ..base import errors, extras, text, version
from . import commands
from .commands.terminal.arguments import REFUSED, CommandParser
from .commands.terminal.running import INTERRUPTED

FAILED = 1

HELP_ORDER = (
    "estimate",
    "simulate",
    "catalogue",
    "feeding",
    "flips",
    "fit",
    "compare",
    "sensitivity",
    "report",
    "animate",
    "shapes",
    "compile",
    "bag",
    "node",
    "publish",
    "show",
    "completion",
)
"""Commands as the help lists them; others follow by the alphabet."""


def command_modules() -> list[ModuleType]:
    """The modules in the folder of the commands, each named as its command."""
    names = [
        module.name
        for module in pkgutil.iter_modules(commands.__path__)
        if not module.ispkg
    ]
    order = [*HELP_ORDER, *sorted(set(names) - set(HELP_ORDER))]
    return [
        import_module(f"{commands.__name__}.{name}")
        for name in sorted(names, key=order.index)
    ]


@cache
def parser() -> CommandParser:
    """The whole command line, made once for all commands of a process."""
    top = CommandParser(
        prog="ros_pose_stats",
        description=(
            "Stable poses of a part on a feeder plate, and how probably it comes to "
            "rest in each."
        ),
        examples=(
            "ros_pose_stats shapes demo",
            "ros_pose_stats estimate demo/clamp.stl --unit mm",
        ),
    )
    top.add_argument(
        "--version",
        action="version",
        version=version.VERSION,
        help="print the version and exit",
    )
    parsers = top.add_subparsers(
        dest="command", metavar="COMMAND", parser_class=CommandParser
    )
    for module in command_modules():
        module.register(parsers)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after `ros_pose_stats`; default: those of the process.

    Returns
    -------
    int
        Exit status: 0; 2 for a refused input; 130 after Ctrl-C; 1 for an internal
        failure. Where a command has spoken DDS, the process ends with it at once.
    """
    prepare_streams()
    if arguments is None:
        extras.keep_algebra_to_one_thread()
        # The last collection of a process would look through all that numba and scipy
        # have made, which takes as long as to import one of them.
        atexit.register(gc.freeze)
    words = sys.argv[1:] if arguments is None else list(arguments)
    words, ros_arguments = split_ros_arguments(words)
    top = parser()
    try:
        options = top.parse_args(words)
    except ImportError as error:  # of what reads an option
        return complain_of_import(error)
    if options.command is None:
        top.print_help()
        return 0
    if ros_arguments and not getattr(options, "takes_ros_arguments", False):
        top.error(
            "--ros-args goes with node, publish and show, not with " + options.command
        )
    options.ros_arguments = ros_arguments
    options.parser = top
    status = run_parsed(options)
    if getattr(options, "takes_ros_arguments", False):
        from ..node.participant import finish

        status = finish(status)
    return status


def prepare_streams() -> None:
    """Have streams to write to, also where they are closed or know few letters."""
    sys.stdout = sys.stdout or io.StringIO()
    sys.stderr = sys.stderr or io.StringIO()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Names of files need not be text.
            stream.reconfigure(errors="backslashreplace")


def split_ros_arguments(words: list[str]) -> tuple[list[str], list[str]]:
    """Divide words into those of the command and those from --ros-args on."""
    if "--ros-args" in words:
        position = words.index("--ros-args")
        return words[:position], words[position:]
    if words[:1] == ["node"] and {"-p", "-r", "--params-file"} & set(words):
        print(
            "ros_pose_stats node: ROS arguments go behind --ros-args, for instance "
            "`ros_pose_stats node --ros-args -p restitution:=0.3`",
            file=sys.stderr,
        )
        raise SystemExit(REFUSED)
    return words, []


def run_parsed(options: argparse.Namespace) -> int:
    """Run what a parser chose; what stops it becomes an exit status and a line."""
    try:
        status: int = options.run(options)
        sys.stdout.flush()
    except errors.PoseStatsError as refusal:
        # It names files.
        complain(text.printable(str(refusal)))
        return REFUSED
    except ImportError as error:
        return complain_of_import(error)
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        # The reader (head, less) has gone.
        discard_output()
        return 0
    except OSError as error:
        complain(describe_failed_write(error))
        discard_output()
        return FAILED
    except Exception:
        return complain_of_failure()
    return status


def complain_of_import(error: ImportError) -> int:
    """Print which module this Python lacks."""
    refusal = extras.failed_import(error)
    if refusal is None:
        return complain_of_failure()
    complain(str(refusal))
    return REFUSED


def complain_of_failure() -> int:
    """Print what has failed in here."""
    traceback.print_exc()
    complain("internal failure, please report it with the lines above")
    return FAILED


def complain(line: str) -> None:
    """Print a line to standard error."""
    print(f"ros_pose_stats: {line}", file=sys.stderr)


def describe_failed_write(error: OSError) -> str:
    """Which file could not be written, and why."""
    file = "" if error.filename is None else f" {text.printable(str(error.filename))}"
    return f"cannot write{file}: {error.strerror or error}"


def discard_output() -> None:
    """Write nothing to standard output any more, at exit neither."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
