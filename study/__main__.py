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
