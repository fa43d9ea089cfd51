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

"""Results as values for JSON, as Markdown tables, and as whole pages."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats.base.files import write_whole
from ros_pose_stats.core.records.plain_values import plain_value

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_json(file: Path, values: Any) -> None:
    """Plain values as indented JSON; the folder is created. NaN and infinity are
    refused.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(
        json.dumps(values, indent=1, allow_nan=False) + "\n", encoding="utf-8"
    )


def plain(value: Any) -> Any:
    """Convert records to objects, sequences and arrays to lists, keys to text, NaN to
    null.

    A standard error is NaN where there is a single body; JSON has no such number.
    """
    if is_dataclass(value):
        value = vars(value)
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(member) for key, member in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(member) for member in value]
    return plain_value(value)


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with as wide columns as needed, the first flush left, the others flush
    right.
    """
    cells = [list(head), *(list(row) for row in rows)]
    widths = [
        max(3, *(len(cell) for cell in column)) for column in zip(*cells, strict=True)
    ]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    lines = [
        _line(cells[0], widths),
        "| " + " | ".join(rule) + " |",
        *(_line(row, widths) for row in cells[1:]),
    ]
    return "\n".join(lines)


def points(fraction: float, digits: int = 1) -> str:
    """A fraction in percentage points."""
    return f"{100.0 * fraction:.{digits}f}"


def with_error(fraction: float, error: float, digits: int = 2) -> str:
    """A fraction and its standard error, where that is known, in percentage points."""
    text = points(fraction, digits)
    return text if math.isnan(error) else f"{text} ± {points(error, digits)}"


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    padded = [
        row[0].ljust(widths[0]),
        *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)),
    ]
    return "| " + " | ".join(padded) + " |"


def save_figure(figure: Figure, file: Path) -> None:
    """Write a PNG or SVG file, as its suffix says; an equal figure gives equal
    bytes.
    """
    import matplotlib

    file.parent.mkdir(parents=True, exist_ok=True)
    metadata = {"Date": None} if file.suffix == ".svg" else None
    with matplotlib.rc_context(
        {"svg.hashsalt": "ros_pose_stats", "svg.fonttype": "none"}
    ):
        figure.savefig(file, dpi=160, metadata=metadata)


def write_page(
    folder: Path,
    page: str,
    text: str,
    figures: Mapping[str, Figure],
    numbers: Mapping[str, Any],
) -> list[Path]:
    """Write `measured/PAGE`, `figures/NAME.png` and `measured/numbers/NAME.json`: all
    or none.

    Parameters
    ----------
    folder : Path
        Created where it does not exist; other files in it stay.
    page, text : str
        Its name and what it says.
    figures, numbers : mapping
        By name.

    Returns
    -------
    list of Path
        What was written.
    """

    def write(staging: Path) -> None:
        measured = staging / "measured"
        measured.mkdir()
        for name, figure in figures.items():
            save_figure(figure, staging / "figures" / f"{name}.png")
        for name, values in numbers.items():
            write_json(measured / "numbers" / f"{name}.json", values)
        (measured / page).write_text(text, encoding="utf-8")

    return write_whole(folder, write)
