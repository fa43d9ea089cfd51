"""Counts from a table: a row has a part's file, the index of a pose, and the parts seen in it."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

from ..errors import RequestError
from ..files import read_file

COLUMNS = 3
MOST = 1 << 48
"""Parts that nobody counts."""


def read_count_rows(file: Path) -> dict[Path, Counter[int]]:
    """Read a CSV file of counts.

    Columns part, pose and count, separated by commas, semicolons or tabs; a first row that holds
    no numbers is taken for a head. Rows of the same pose add up. The files of parts are looked
    for beside the table, then in the working directory.

    Returns from the file of each part, in order of appearance, to the counts by pose. Raises
    RequestError if the file cannot be read, or a row is none of counts, with its number.
    """
    try:
        text = read_file(file).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        said = error.strerror if isinstance(error, OSError) else "not UTF-8"
        raise RequestError("a CSV file with the columns part, pose, count", f"{file} ({said})",
                           "check the path") from error
    found: dict[Path, Counter[int]] = {}
    try:
        rows = list(csv.reader(text.splitlines(), delimiter=_delimiter(text), strict=True))
    except csv.Error as error:
        raise RequestError("a CSV file with the columns part, pose, count",
                           f"{file} ({error})", "quote names that hold a separator") from error
    filled = [(number, [cell.strip() for cell in row]) for number, row in enumerate(rows, 1)
              if any(cell.strip() for cell in row)]
    for place, (number, row) in enumerate(filled):
        if place == 0 and len(row) == COLUMNS and not row[1].isdecimal() \
                and not row[2].isdecimal():
            continue
        if len(row) != COLUMNS or not row[0]:
            raise _refusal(file, number, row)
        part = _beside(file, row[0])
        found.setdefault(part, Counter())[_whole(file, number, row, 1)] += _whole(
            file, number, row, 2)
    if not found:
        raise RequestError("rows of part, pose, count", f"none in {file}",
                           "for instance clamp.stl,0,117")
    return found


def _delimiter(text: str) -> str:
    first = next((line for line in text.splitlines() if line.strip()), "")
    return max(",;\t", key=first.count)


def _beside(file: Path, name: str) -> Path:
    beside = file.parent / name
    return Path(name) if not beside.exists() and Path(name).exists() else beside


def _whole(file: Path, number: int, row: list[str], column: int) -> int:
    if not row[column].isdecimal() or len(row[column]) > 15 or int(row[column]) > MOST:
        raise _refusal(file, number, row)
    return int(row[column])


def _refusal(file: Path, number: int, row: list[str]) -> RequestError:
    return RequestError("a row of part, pose, count with whole numbers from 0 on",
                        f"{','.join(row)!r} in line {number} of {file}",
                        "for instance clamp.stl,0,117")
