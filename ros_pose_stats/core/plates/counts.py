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

"""Parts that were counted on a plate, by pose, and tables of such counts."""

import csv
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import RequestError, reason
from ...base.files import read_file
from ..mesh.parts import load_part
from ..records import Index, Part
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_ROUND_SIDES,
    Numbering,
    is_whole_number,
)
from ..resting.poses import RestingPoses, resting_poses

LARGEST_COUNT = 2.0**48  # parts that nobody counts


@dataclass(frozen=True, eq=False)
class CountedPart:
    """Counts of one part."""

    part: Part
    counts: Index  # (P,) int; parts seen in each pose, by `index`
    numbering: Numbering  # of the poses

    @property
    def resting(self) -> RestingPoses:
        """Its stable poses."""
        return resting_poses(self.part, *self.numbering)

    def with_round_sides(self, sides: int) -> "CountedPart":
        """The same counts of a part whose round surfaces have so many sides a turn."""
        return replace(self, numbering=self.numbering._replace(round_sides=sides))

    @property
    def total(self) -> int:
        """Parts seen in all poses together."""
        return int(self.counts.sum())

    @property
    def by_group(self) -> Index:
        """Parts (G,) in each group of poses that look alike, which tell of a plate."""
        return np.bincount(self.resting.group, self.counts).astype(np.int64)


def shared_out(counted_part: CountedPart) -> Index:
    """Counts (P,) with those of poses that look alike shared out evenly among them.

    Who counts by hand gives all of them to one.
    """
    group = counted_part.resting.group
    counts = np.empty_like(counted_part.counts)
    for number, total in enumerate(counted_part.by_group.tolist()):
        members = np.flatnonzero(group == number)
        counts[members] = total // members.size
        counts[members[: total % members.size]] += 1
    return counts


def count_part(
    part: Part,
    counts: Mapping[int, int],
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> CountedPart:
    """Join a part and its counts, from the `index` of a pose to the parts seen.

    `cluster_tolerance, round_sides`: as of the statistics that numbered the poses.
    Raises RequestError if the part has no such pose, or a count is negative.
    """
    numbering = Numbering(cluster_tolerance, round_sides)
    poses = len(resting_poses(part, *numbering).poses)
    count = np.zeros(poses, dtype=np.int64)
    for index, number in dict[Any, Any](counts).items():
        if not is_whole_number(index) or not 0 <= index < poses:
            raise RequestError(
                f"poses 0 to {poses - 1} of {part.part_id}",
                f"{index!r}",
                "count with the numbers that estimate shows, at the same cluster "
                "tolerance and round sides",
            )
        if not isinstance(number, Integral) or not 0 <= int(number) <= LARGEST_COUNT:
            raise RequestError(
                "whole counts from 0 on",
                f"{number} of {part.part_id} in pose {index}",
                "give the parts seen in each pose",
            )
        count[index] = number
    return CountedPart(part, count, numbering)


COUNT_COLUMNS = "part, pose, count"


def is_count_table(file: Path) -> bool:
    """Whether a table's first row is as wide as one of counts by pose."""
    rows = _read_rows(file, COUNT_COLUMNS)
    return bool(rows) and len(rows[0][1]) == COUNT_COLUMNS.count(",") + 1


def read_count_rows(file: Path) -> dict[Path, Counter[int]]:
    """Read a CSV file with the columns part, pose and count.

    The files of parts are looked for beside the table, then in the working directory.
    """
    counts_by_part: dict[Path, Counter[int]] = {}
    for name, (pose, count) in read_table(file, COUNT_COLUMNS, "clamp.stl,0,117"):
        neighbour = file.parent / name
        part = (
            Path(name) if not neighbour.exists() and Path(name).exists() else neighbour
        )
        counts_by_part.setdefault(part, Counter())[pose] += count
    return counts_by_part


def read_counted_parts(
    file: Path,
    unit: str,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> list[CountedPart]:
    """Read a table as `read_count_rows` does, and the parts that it names.

    `unit`: of files of parts that name none; the rest as for `count_part`.
    """
    return [
        count_part(
            load_part(part, unit, unless_declared=True),
            counts,
            cluster_tolerance=cluster_tolerance,
            round_sides=round_sides,
        )
        for part, counts in read_count_rows(file).items()
    ]


def read_table(file: Path, columns: str, example: str) -> list[tuple[str, list[int]]]:
    """Read a CSV file whose rows are a name and whole numbers.

    A first row without numbers is a head.

    Raises RequestError if the file cannot be read, or for a row of another kind, with
    its number.
    """
    filled_rows = _read_rows(file, columns)
    table = []
    width = columns.count(",") + 1
    for position, (number, row) in enumerate(filled_rows):
        if position == 0 and len(row) == width and not any(map(str.isdecimal, row[1:])):
            continue
        if (
            len(row) != width
            or not row[0]
            or not all(
                cell.isdecimal() and float(cell) <= LARGEST_COUNT for cell in row[1:]
            )
        ):
            raise RequestError(
                f"a row of {columns} with whole numbers from 0 on",
                f"{','.join(row)!r} in line {number} of {file}",
                f"for instance {example}",
            )
        table.append((row[0], [int(float(cell)) for cell in row[1:]]))
    if not table:
        raise RequestError(
            f"rows of {columns}", f"none in {file}", f"for instance {example}"
        )
    return table


def _read_rows(file: Path, columns: str) -> list[tuple[int, list[str]]]:
    """Rows that are not empty, each with its number."""
    try:
        lines = read_file(file).decode("utf-8-sig").splitlines()
        first = next((line for line in lines if line.strip()), "")
        rows = list(
            csv.reader(lines, delimiter=max(",;\t", key=first.count), strict=True)
        )
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RequestError(
            f"a CSV file in UTF-8 with the columns {columns}",
            f"{file} ({reason(error)})",
            "check the path, and that names which hold a separator are quoted",
        ) from error
    return [
        (number, [cell.strip() for cell in row])
        for number, row in enumerate(rows, 1)
        if any(cell.strip() for cell in row)
    ]
