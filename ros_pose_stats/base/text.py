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

"""Numbers, units, plurals, lists and tables as text."""

import csv
import io
import math
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime, timezone
from itertools import chain
from typing import Any, NamedTuple

SECOND = 1_000_000_000
GAP = "  "
FORMULAS = ("=", "+", "-", "@")
"""What a cell of a table begins with that spreadsheets compute."""

WIDTH = 100  # width of a report, in characters
MOST_POSES = 40  # poses that a table lists; the others are summed up in one line


class Column(NamedTuple):
    """Head of a column: title, unit below it, and whether text is flush left."""

    title: str
    unit: str = ""
    left: bool = False


def columns(heads: Sequence[Column], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table, indented; the line of units is left out where there is none."""
    cells = [
        [head.title for head in heads],
        [head.unit for head in heads],
        *([printable(cell) for cell in row] for row in rows),
    ]
    if not any(cells[1]):
        del cells[1]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        GAP
        + GAP.join(
            cell.ljust(width) if head.left else cell.rjust(width)
            for cell, width, head in zip(row, widths, heads, strict=True)
        ).rstrip()
        for row in cells
    ]


def printable(text: str) -> str:
    """Text from outside without what would disturb a terminal, as line ends."""
    return "".join(sign if sign.isprintable() else "?" for sign in text)


def shortened(text: str, width: int) -> str:
    """At most `width` characters of a text, cut at its end."""
    return text if len(text) <= width else text[: width - 3] + "..."


def ending(text: str, width: int) -> str:
    """At most `width` characters of a text, cut at its beginning."""
    return text if len(text) <= width else "..." + text[3 - width :]


def percent(fraction: float) -> str:
    """A fraction in percent or points with two decimals; a dash for NaN."""
    return "-" if math.isnan(fraction) else f"{100.0 * fraction:.2f}"


def points(fraction: float, digits: int = 1) -> str:
    """A signed difference in points; a dash where it is not known."""
    if math.isnan(fraction):
        return "-"
    rounded = round(100.0 * fraction, digits) + 0.0  # no negative zero
    return f"{rounded:+.{digits}f}"


def interval(low: float, high: float) -> str:
    """Two fractions in percent."""
    return "-" if math.isnan(low) else f"{100.0 * low:.2f} - {100.0 * high:.2f}"


def millimetres(metres: float) -> str:
    """A length; a dash where it is not known or has no bound."""
    return f"{metres * 1e3:.4g}" if math.isfinite(metres) else "-"


def length_in_words(metres: float) -> str:
    """A length with three digits and the unit that suits it."""
    for unit, size in (("m", 1.0), ("mm", 1e-3)):
        if metres >= 0.9995 * size or (unit == "mm" and metres >= 1e-5):
            return f"{metres / size:.3g} {unit}"
    return f"{metres * 1e6:.3g} µm"


def three_digits(value: float) -> str:
    """A number with three digits, zeros included; all of them where it has more."""
    return f"{value:#.3g}".rstrip(".") if value < 999.5 else f"{value:.0f}"


def bounded(number: tuple[float, float, float]) -> str:
    """A number and its bounds, with three digits; a dash where it is not known."""
    value, low, high = number
    if math.isnan(value):
        return "-"
    if math.isnan(low) or math.isnan(high):
        return "no bound" if math.isinf(value) else three_digits(value)
    return f"{three_digits(value)} ({three_digits(low)} to {three_digits(high)})"


def degrees(radians: float) -> str:
    """An angle; a dash where it is not known."""
    return f"{math.degrees(radians):.2f}" if math.isfinite(radians) else "-"


def several(count: int, noun: str) -> str:
    """A number and its noun."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def listed(names: Sequence[object]) -> str:
    """Names or numbers in words: 1, 2 and 3."""
    words = [str(name) for name in names]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def ranges(numbers: Sequence[int]) -> str:
    """Rising whole numbers, three and more in a row by their ends: 0-5, 8, 9."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(
        f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run))
        for run in runs
    )


def name_poses(poses: Sequence[int]) -> str:
    """Some poses: pose 4, poses 0-3."""
    return f"pose{'' if len(poses) == 1 else 's'} {ranges(poses)}"


def most_probable(poses: Sequence[Any]) -> str:
    """The three most probable groups, in per cent: 0-3: 90.1, 4+5: 9."""
    groups = {pose.group: pose.group_probability for pose in poses}
    return ", ".join(
        ranges(sorted(pose.index for pose in poses if pose.group == group)).replace(
            ", ", "+"
        )
        + f": {100 * share:.1f}"
        for group, share in sorted(groups.items(), key=lambda item: -item[1])[:3]
    )


def utc(nanoseconds: int) -> str:
    """A time since 1970 to the second; a dash for 0."""
    if not nanoseconds:
        return "-"
    time = datetime.fromtimestamp(nanoseconds // SECOND, timezone.utc)
    return f"{time:%Y-%m-%d %H:%M:%S}"


def csv_lines(heads: Iterable[str], rows: Iterable[Iterable[Any]]) -> Iterator[str]:
    """Lines for spreadsheets: all digits; formulas quoted, unknown numbers empty."""
    for row in chain([heads], rows):
        line = io.StringIO(newline="")
        # Only a writer that ends lines in both signs quotes both within cells.
        csv.writer(line, lineterminator="\r\n").writerow(map(_cell, row))
        yield line.getvalue().removesuffix("\r\n") + "\n"


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return repr(float(value)) if math.isfinite(value) else ""
    if isinstance(value, str) and is_formula(value):
        return f"'{value}"
    return value


def is_formula(text: str) -> bool:
    """Whether a spreadsheet may compute a text.

    It looks behind spaces, line ends and signs without a width, too.
    """
    start = 0
    while start < len(text) and (text[start] == " " or not text[start].isprintable()):
        start += 1
    return text.startswith(FORMULAS, start)
