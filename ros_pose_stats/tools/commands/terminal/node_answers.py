"""What a node answers, printed: the output kept for it, and one part's statistics."""

import argparse
import os
import sys
from typing import TYPE_CHECKING

from ....core.records.notes import note_lines
from ....node.entry import prepare_ros
from . import running

if TYPE_CHECKING:
    from ....core.records import Part, PoseStatistics


def prepare_client() -> None:
    """Refuse to go on without ROS; errors of DDS go to stderr instead of the output."""
    prepare_ros()
    if sys.__stdout__ is sys.stdout is not None and sys.__stderr__ is not None:
        sys.stdout = os.fdopen(
            os.dup(1), "w", 1, sys.stdout.encoding, "backslashreplace"
        )
        os.dup2(2, 1)


def print_statistics(
    statistics: "PoseStatistics", part: "Part | None", options: argparse.Namespace
) -> None:
    """Print what a node says of a part: statistics, or why there are none."""
    if options.json:
        running.print_json(statistics.as_dict())
    elif statistics.poses:
        print(running.report_table(statistics, part, options.each))
    else:
        print(*note_lines(statistics.warnings), sep="\n")
