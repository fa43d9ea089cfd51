"""The command `ros_pose_stats`: parses, dispatches, and turns refusals into exit statuses."""

import argparse
import io
import os
import sys
import traceback
from collections.abc import Sequence

from ..base import errors, text, version
from .commands import (
    catalogue,
    compare,
    compile,
    estimate,
    node,
    running,
    sensitivity,
    show,
)
from .commands.arguments import REFUSED, CommandParser, Commands
from .commands.bags import bag
from .commands.feeding import feeding, fit, flips

FAILED = 1


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    top = CommandParser(
        prog="ros_pose_stats",
        description=(
            "Stable poses of a part on a feeder plate, and how probably it comes to rest in "
            "each."
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
    commands: Commands = top.add_subparsers(
        dest="command", metavar="COMMAND", parser_class=CommandParser
    )
    for register in (
        estimate.register,
        estimate.register_simulate,
        catalogue.register,
        feeding.register,
        flips.register,
        fit.register,
        compare.register,
        sensitivity.register,
        show.register,
        show.register_animate,
        compile.register_shapes,
        compile.register,
        bag.register,
        node.register,
        node.register_publish,
        node.register_show,
    ):
        register(commands)
    compile.register_completion(commands, top)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command: 0; 2 for a refused input; 130 after Ctrl-C; 1 for an internal failure."""
    sys.stdout = sys.stdout or io.StringIO()  # where it is closed
    sys.stderr = sys.stderr or io.StringIO()
    for stream in (sys.stdout, sys.stderr):  # names of files need not be text
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    ours, rest = _split(sys.argv[1:] if arguments is None else list(arguments))
    reader = parser()
    parsed = reader.parse_args(ours)
    if parsed.command is None:
        reader.print_help()
        return 0
    if rest and not getattr(parsed, "takes_ros_arguments", False):
        reader.error(
            f"--ros-args goes with node, publish and show, not with {parsed.command}"
        )
    parsed.ros_arguments = rest
    return run_parsed(parsed)


def run_parsed(parsed: argparse.Namespace) -> int:
    """Run what a parser chose, and turn what stops it into an exit status and a line."""
    try:
        status: int = parsed.run(parsed)
        sys.stdout.flush()
    except errors.PoseStatsError as refusal:
        print(
            f"ros_pose_stats: {text.printable(str(refusal))}", file=sys.stderr
        )  # it names files
        return REFUSED
    except KeyboardInterrupt:
        print("ros_pose_stats: interrupted", file=sys.stderr)
        return running.INTERRUPTED
    except BrokenPipeError:
        # The reader (head, less) has gone; nothing may be written at exit any more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        what = (
            "" if error.filename is None else f" {text.printable(str(error.filename))}"
        )
        print(
            f"ros_pose_stats: cannot write{what}: {error.strerror or error}",
            file=sys.stderr,
        )
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception:
        traceback.print_exc()
        print(
            "ros_pose_stats: internal failure, please report it with the lines above",
            file=sys.stderr,
        )
        return FAILED
    return status


def _split(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Divide the arguments into those of the command and those from --ros-args on."""
    if "--ros-args" not in arguments:
        if arguments[:1] == ["node"] and {"-p", "-r", "--params-file"} & set(arguments):
            print(
                "ros_pose_stats node: ROS arguments go behind --ros-args, for instance "
                "`ros_pose_stats node --ros-args -p restitution:=0.3`",
                file=sys.stderr,
            )
            raise SystemExit(REFUSED)
        return arguments, []
    place = arguments.index("--ros-args")
    return arguments[:place], arguments[place:]
