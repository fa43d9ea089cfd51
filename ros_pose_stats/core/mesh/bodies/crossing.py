"""How much of a volume a surface that runs through itself encloses twice.

An outline that crosses itself leaves such a surface. Vertical lines through it show how
often each of their pieces is enclosed.
"""

import math

import numpy as np

from ...records import Array, Index
from ...tolerances import OVERLAP
from ..winding import heights_at

_LINES = 64
"""Lines along each side of the part: several of 64 x 64 meet the thousandth of a volume
that matters."""

_MOST_PAIRS = 400_000  # of lines and triangles: where all are slivers, fewer lines

# Off the simple fractions of the size where edges are drawn.
_ASIDE = np.array([math.sqrt(2.0) - 1.0, math.sqrt(3.0) - 1.0])


def share_enclosed_twice(points: Array, triangles: Index, lines: int = _LINES) -> float:
    """Share of the volume of points of size one that is enclosed twice, or inside out.

    Normals point out of the material. Less than some thousandth may be missed.
    """
    on_grid = np.column_stack(((points[:, :2] + 0.5) * lines + _ASIDE, points[:, 2]))
    first_x, count_x = _lines_across(on_grid[:, 0], triangles)
    first_y, count_y = _lines_across(on_grid[:, 1], triangles)
    pairs = count_x * count_y
    if pairs.sum() > _MOST_PAIRS and lines > 1:
        return share_enclosed_twice(points, triangles, lines // 2)
    triangle = np.repeat(np.arange(len(triangles)), pairs)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(pairs) - pairs, pairs)
    x = first_x[triangle] + number // count_y[triangle]
    y = first_y[triangle] + number % count_y[triangle]
    line = np.column_stack((x, y))
    sense = _senses(on_grid, triangles[triangle], line)
    is_crossed = sense != 0
    line = line[is_crossed]
    height = heights_at(on_grid[triangles[triangle[is_crossed]]], *line.T)
    order = np.lexsort((height, line[:, 1], line[:, 0]))
    line = line[order]
    # A line that rises leaves the material where the surface faces up.
    enclosed = np.cumsum(-sense[is_crossed][order])[:-1]
    is_same_line = (line[1:] == line[:-1]).all(axis=1)
    length = np.where(is_same_line, np.diff(height[order]), 0.0)
    length = np.where(length > OVERLAP, length, 0.0)
    total = float((np.abs(enclosed) * length).sum())
    wrong = float((np.abs(enclosed - (enclosed != 0)) * length).sum())
    return min(wrong / total, 1.0) if total > 0.0 else 0.0


def _lines_across(level: Array, triangles: Index) -> tuple[Index, Index]:
    """First line, at a whole number, that reaches each triangle's width, and how many.

    `level` (N,): of each point. Column by column, for there may be a million triangles.
    """
    a, b, c = (level[triangles[:, k]] for k in range(3))
    first = np.ceil(np.minimum(np.minimum(a, b), c)).astype(np.int64)
    last = np.floor(np.maximum(np.maximum(a, b), c)).astype(np.int64)
    return first, last + 1 - first


def _senses(on_grid: Array, triangles: Index, line: Index) -> Index:
    """Whether each line (n, 2) passes a triangle that faces up (1), down (-1), or none.

    Both triangles at an edge are told the same side of it, so that no line passes
    between them.
    """
    sides = np.zeros(len(line), dtype=np.int64)
    for k in range(3):
        begin = triangles[:, k]
        end = triangles[:, (k + 1) % 3]
        lower = on_grid[np.minimum(begin, end)]
        edge = on_grid[np.maximum(begin, end)] - lower
        x, y = (line - lower[:, :2]).T
        is_left = edge[:, 0] * y - edge[:, 1] * x > 0.0
        sides += is_left ^ (begin > end)
    return np.where(sides == 3, 1, np.where(sides == 0, -1, 0))
