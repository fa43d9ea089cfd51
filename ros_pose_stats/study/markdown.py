"""Tables that read well on a terminal and as Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with as wide columns as needed, the first flush left, the others flush right."""
    cells = [list(head), *(list(row) for row in rows)]
    widths = [max(3, *(len(cell) for cell in column)) for column in zip(*cells, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    lines = [_line(cells[0], widths), "| " + " | ".join(rule) + " |",
             *(_line(row, widths) for row in cells[1:])]
    return "\n".join(lines)


def points(fraction: float, digits: int = 1) -> str:
    """A fraction in percentage points."""
    return f"{100.0 * fraction:.{digits}f}"


def with_error(fraction: float, error: float, digits: int = 2) -> str:
    """A fraction and its standard error in percentage points."""
    return plus_minus(100.0 * fraction, 100.0 * error, digits)


def plus_minus(value: float, error: float, digits: int) -> str:
    """A number and its standard error, where that is known."""
    return f"{value:.{digits}f}" + ("" if math.isnan(error) else f" ± {error:.{digits}f}")


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    padded = [row[0].ljust(widths[0]),
              *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
    return "| " + " | ".join(padded) + " |"
