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

"""Results of a benchmark: sections of rows, and their JSON."""

import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from .documents import write_json

Cell = float | int | str


@dataclass(frozen=True)
class Target:
    """A target: `value` below `limit`, or at least `limit`.

    Attributes
    ----------
    name : str
        What the value is, with its unit.
    value, limit : float
    at_least : bool
        Whether the value must reach the limit rather than stay below it.
    """

    name: str
    value: float
    limit: float
    at_least: bool = False

    @property
    def is_met(self) -> bool:
        """Whether the value is on the right side of the limit."""
        return self.value >= self.limit if self.at_least else self.value < self.limit

    def __str__(self) -> str:
        demand = "at least" if self.at_least else "limit"
        return f"{self.name} {format_cell(self.value)}, {demand} {self.limit:g}"


@dataclass(frozen=True)
class Row:
    """A line of a table: a name, a cell for each column, and targets."""

    name: str
    cells: dict[str, Cell]
    targets: tuple[Target, ...] = ()


@dataclass(frozen=True)
class Section:
    """A table.

    Attributes
    ----------
    name : str
        Key.
    title : str
    timed : str
        Says exactly what the figures are times of.
    rows : tuple of Row
        All with the same columns.
    """

    name: str
    title: str
    timed: str
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Results:
    """A run: its machine, and its sections."""

    machine: dict[str, str]
    sections: tuple[Section, ...]

    @property
    def rows(self) -> Iterator[Row]:
        """Rows of all sections."""
        for section in self.sections:
            yield from section.rows


SMALLEST = 1e-4  # below it a number has an exponent


def format_cell(value: Cell) -> str:
    """Format a cell: three significant digits, thousands apart."""
    if isinstance(value, str):
        return value
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    if not math.isfinite(value) or value == 0.0:
        return f"{value:g}"
    if abs(value) < SMALLEST:
        return f"{value:.1e}"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:,.{digits}f}".replace(",", " ")


def save(results: Results, file: Path) -> None:
    """Write as JSON."""
    write_json(file, asdict(results))


def load(file: Path) -> Results:
    """Read what `save` wrote."""
    stored: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return Results(stored["machine"], tuple(map(_section, stored["sections"])))


def _section(stored: dict[str, Any]) -> Section:
    rows = [
        Row(
            row["name"],
            row["cells"],
            tuple(Target(**target) for target in row["targets"]),
        )
        for row in stored["rows"]
    ]
    return Section(stored["name"], stored["title"], stored["timed"], tuple(rows))
