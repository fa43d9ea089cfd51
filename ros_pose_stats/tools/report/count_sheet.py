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

"""A sheet to count by hand: pictures to tell poses by, boxes to tick, and a table."""

import csv
import io
import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...base import text
from ...core.planning.confidence import observe_counts
from ...core.plates import read_count_rows
from ...core.records import Part, PoseStatistics
from ...core.records.statistics import listed_groups
from ...core.statistics.pose_groups import pose_groups
from ..plots import figures, poses
from . import words

TABLE = "counts.csv"
COLUMNS = ("part", "pose", "count")

MOST_DRAWN = 12
"""Groups of like poses that have a row; parts in another one are not counted."""

THROWS = (50, 100, 200, 500, 1000)


def sheet_page(
    part: Part, statistics: PoseStatistics, commands: Sequence[str] = ()
) -> str:
    """The sheet as HTML, for paper of A4.

    `commands`: what to do with the counts, each with what it is for.
    """
    groups = listed_groups(pose_groups(statistics))[:MOST_DRAWN]
    pictures = poses.pose_pictures(
        part, [group.first for group in groups], statistics.radius
    )
    return words.template("count_sheet.html", numbered=text.name_poses).render(
        part=part,
        statistics=statistics,
        table=TABLE,
        commands=commands,
        rows=[
            (group, figures.address("png", figures.png_bytes(picture)))
            for group, picture in zip(groups, pictures, strict=True)
        ],
        plate_error=statistics.plate_error,
        errors=[(throws, *count_errors(statistics, throws)) for throws in THROWS],
    )


def count_errors(statistics: PoseStatistics, throws: int) -> tuple[float, float]:
    """Errors over the groups after throws: of the counts, and beside the model."""
    group_poses = list(statistics.by_index.values())
    group = np.unique([pose.group for pose in group_poses], return_inverse=True)[1]
    share = np.bincount(group, [pose.probability for pose in group_poses])
    alone = math.sqrt(float(np.mean(share * (1.0 - share))) / throws)
    counts = [round(throws * pose.probability) for pose in group_poses]
    observed = observe_counts(statistics, np.array(counts))
    # Poses of a group share its error evenly.
    error = np.bincount(
        group, [pose.standard_error for pose in observed.by_index.values()]
    )
    return alone, math.sqrt(float(np.mean(np.square(error))))


def table_with(file: Path, part_file: Path, statistics: PoseStatistics) -> bytes | None:
    """A table of counts with rows for a part, 0 each; None where it has the part.

    Of poses that look alike the first has the row, and the counts of all. Rows that
    are there stay as they are. Raises RequestError if the file holds no such table.
    """
    content = b""
    delimiter = ","
    head = [COLUMNS]
    if file.exists():
        if part_file.resolve() in {path.resolve() for path in read_count_rows(file)}:
            return None
        content = file.read_bytes().rstrip() + b"\n"
        first_line = content.decode("utf-8-sig").lstrip().partition("\n")[0]
        delimiter = max(",;\t", key=first_line.count)
        head = []
    name = os.path.relpath(part_file, file.parent)
    if text.is_formula(name):
        name = f"./{name}"
    groups = listed_groups(pose_groups(statistics))[:MOST_DRAWN]
    lines = io.StringIO(newline="")
    writer = csv.writer(lines, delimiter=delimiter, lineterminator="\n")
    writer.writerows(head)
    writer.writerows(
        (name, index, 0) for index in sorted(group.first.index for group in groups)
    )
    return content + lines.getvalue().encode(errors="surrogateescape")
