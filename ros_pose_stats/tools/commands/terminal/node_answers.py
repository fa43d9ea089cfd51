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
