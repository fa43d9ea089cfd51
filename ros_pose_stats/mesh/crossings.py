"""Crossings of a vertical line with a triangle mesh.

The line is tested against the triangles projected along z. A triangle counts by the winding
number of its projection around the point; each edge contributes by a half-open rule, from
numbers that are computed alike for both triangles that share it. So even a line through an
edge or a vertex crosses a closed surface as often upward as downward.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def crossings(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], x: float, y: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """Crossings of the line at (x, y) with triangles.

    Takes `vertices` (V, 3), `triangles` (T, 3). Returns `which` (k,): numbers of the triangles
    crossed; `height` (k,): z of each crossing; `sign` (k,): +1 where the triangle's normal points
    up, -1 where down.
    """
    across, along = vertices[:, 0], vertices[:, 1]
    begin, end = triangles, triangles[:, [1, 2, 0]]
    winding = np.zeros(len(triangles), dtype=np.int64)
    above_begin, above_end = along[begin] <= y, along[end] <= y
    spans = above_begin != above_end
    row, column = np.nonzero(spans)
    lower = np.minimum(begin[row, column], end[row, column])
    higher = np.maximum(begin[row, column], end[row, column])
    rises = along[lower] < along[higher]
    turn = ((across[higher] - across[lower]) * (y - along[lower])
            - (x - across[lower]) * (along[higher] - along[lower]))
    crosses = np.where(rises, turn, -turn) > 0.0
    direction = np.where(above_begin[row, column], 1, -1)
    np.add.at(winding, row[crosses], direction[crosses])
    which = np.flatnonzero(winding)
    return which, _heights(vertices[triangles[which]], x, y), winding[which]


def _heights(corners: NDArray[np.float64], x: float, y: float) -> NDArray[np.float64]:
    """Evaluate z at (x, y) on the planes of triangles (k, 3, 3), never beyond their corners."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    dx, dy = x - a[:, 0], y - a[:, 1]
    safe = np.where(area == 0.0, 1.0, area)
    s = (dx * v[:, 1] - dy * v[:, 0]) / safe
    t = (u[:, 0] * dy - u[:, 1] * dx) / safe
    height = a[:, 2] + s * u[:, 2] + t * v[:, 2]
    # A triangle that stands almost upright gives noise here; its corners bound it.
    bounded: NDArray[np.float64] = np.clip(height, corners[:, :, 2].min(axis=1),
                                           corners[:, :, 2].max(axis=1))
    return bounded
