"""The paper's study done again, from a checkout: `python -m study KIND`."""

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from ros_pose_stats.tools.cli import run_parsed
from ros_pose_stats.tools.commands.terminal.arguments import CommandParser

from .commands import benchmark, dataset


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a study; the exit status is as of `ros_pose_stats`."""
    parser = CommandParser(
        prog="study",
        description="Measure estimators and simulation on the paper's random "
        "polyhedra, on square prisms, on dice that were rolled and on fitted plates.",
        examples=(
            "python -m study dataset --bodies 40 --drops 200 -o small.npz",
            "python -m study table --dataset small.npz",
        ),
    )
    kinds: argparse._SubParsersAction[Any] = parser.add_subparsers(
        dest="kind", required=True, metavar="KIND", parser_class=CommandParser
    )
    benchmark.register(kinds)
    dataset.register(kinds)
    return run_parsed(parser.parse_args(arguments))


if __name__ == "__main__":
    sys.exit(main())
