"""Triangles as pixels: for each pixel the triangle that is nearest to the viewer.

The stretches of pixels that all triangles cover are found first, row by row; then all of their
pixels are compared at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

AT_ONCE = 3_000_000
"""Pixels of triangles held in memory."""


def nearest_triangles(corners: Array, wide: int, high: int) -> tuple[Index, Array]:
    """Find which triangle is seen in every pixel.

    Parameters
    ----------
    corners : (t, 3, 3) array
        Across and down the picture in pixels, and towards the viewer.
    wide, high : int
        Pixels.

    Returns
    -------
    number : (high, wide) array of int
        -1 where there is none.
    depth : (high, wide) array
        Of the triangle at the pixel's middle, towards the viewer; minus infinity where there
        is none.
    """
    found = np.full(wide * high, -1, dtype=np.int64)
    depth = np.full(wide * high, -np.inf)
    owner, y, begin, end = _spans(corners, wide, high)
    span = end - begin
    slope = _slopes(corners)
    least, most = corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    for some in _batches(span):
        row = np.repeat(some, span[some])
        first = np.repeat(np.cumsum(span[some]) - span[some], span[some])
        x = begin[row] + np.arange(len(row)) - first
        mine, pixel = owner[row], y[row] * wide + x
        origin = corners[mine, 0]
        far = (origin[:, 2] + (x + 0.5 - origin[:, 0]) * slope[mine, 0]
               + (y[row] + 0.5 - origin[:, 1]) * slope[mine, 1])
        far = np.clip(far, least[mine], most[mine])
        np.maximum.at(depth, pixel, far)
        kept = far >= depth[pixel]
        found[pixel[kept]] = mine[kept]
    return found.reshape(high, wide), depth.reshape(high, wide)


def _spans(corners: Array, wide: int, high: int) -> tuple[Index, Index, Index, Index]:
    """Triangle, row, first column and end of every stretch of pixels that is covered."""
    low = np.clip(np.ceil(corners[:, :, 1].min(axis=1) - 0.5), 0, high).astype(np.int64)
    top = np.clip(np.ceil(corners[:, :, 1].max(axis=1) - 0.5), 0, high).astype(np.int64)
    rows = top - low
    owner = np.repeat(np.arange(len(corners)), rows)
    y = low[owner] + np.arange(len(owner)) - np.repeat(np.cumsum(rows) - rows, rows)
    left, right = np.full(len(owner), np.inf), np.full(len(owner), -np.inf)
    for k in range(3):
        p, q = corners[owner, k, :2], corners[owner, (k + 1) % 3, :2]
        crosses = (p[:, 1] <= y + 0.5) != (q[:, 1] <= y + 0.5)
        share = (y + 0.5 - p[:, 1])[crosses] / (q[:, 1] - p[:, 1])[crosses]
        x = p[crosses, 0] + share * (q[:, 0] - p[:, 0])[crosses]
        left[crosses] = np.minimum(left[crosses], x)
        right[crosses] = np.maximum(right[crosses], x)
    begin = np.clip(np.ceil(np.clip(left, -1.0, wide + 1.0) - 0.5), 0, wide).astype(np.int64)
    end = np.clip(np.ceil(np.clip(right, -1.0, wide + 1.0) - 0.5), 0, wide).astype(np.int64)
    return owner, y, begin, np.maximum(end, begin)


def _slopes(corners: Array) -> Array:
    """Rise (t, 2) of the depth across and down each triangle; 0 where it is seen edge-on."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(one, two)
    edge_on = np.abs(normal[:, 2]) < 1e-9
    flat = np.where(edge_on, 1.0, normal[:, 2])
    return np.where(edge_on[:, None], 0.0, -normal[:, :2] / flat[:, None])


def _batches(counts: Index) -> list[Index]:
    """Numbers of what has any fragments, in portions of so many."""
    some = np.flatnonzero(counts)
    portion = np.cumsum(counts[some]) // AT_ONCE
    return np.split(some, np.flatnonzero(np.diff(portion)) + 1) if len(some) else []
