"""How far points reach: bounding boxes, and how thin a cloud of points is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .array_types import Fixed1, Fixed2, FixedCorners2
from .compilation import entry_kernel

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flag = NDArray[np.bool_]


@entry_kernel
def bounds(points: Fixed2) -> tuple[Array, Array]:
    """Lowest and highest coordinates (3,) of points (N, 3), N at least 1."""
    low, high = np.empty(3), np.empty(3)
    for c in range(3):
        least = most = points[0, c]
        for i in range(points.shape[0]):
            least, most = min(least, points[i, c]), max(most, points[i, c])
        low[c], high[c] = least, most
    return low, high


@entry_kernel
def largest_used_extent(points: Fixed2, triangles: FixedCorners2) -> float:
    """Largest extent along an axis of those points (V, 3) that triangles (T, 3) use."""
    used = np.zeros(points.shape[0], np.bool_)
    for t in range(triangles.shape[0]):
        used[triangles[t, 0]] = used[triangles[t, 1]] = used[triangles[t, 2]] = True
    extent = 0.0
    for c in range(3):
        least, most = math.inf, -math.inf
        for i in range(points.shape[0]):
            if used[i]:
                least, most = min(least, points[i, c]), max(most, points[i, c])
        extent = max(extent, most - least)
    return extent


@entry_kernel
def boxes_around(low: Fixed2, high: Fixed2, inner: int, slack: float) -> Index:
    """Boxes (k,), among those numbered below `inner`, that box `inner` lies in.

    Parameters
    ----------
    low, high : (B, 3) arrays
        Corners of the boxes.
    inner : int
    slack : float
        By how much it may stick out.
    """
    x, y, z = low[inner, 0] + slack, low[inner, 1] + slack, low[inner, 2] + slack
    u, v, w = high[inner, 0] - slack, high[inner, 1] - slack, high[inner, 2] - slack
    found = np.empty(inner, np.int64)
    count = 0
    for i in range(inner):
        if (low[i, 0] <= x and low[i, 1] <= y and low[i, 2] <= z
                and high[i, 0] >= u and high[i, 1] >= v and high[i, 2] >= w):
            found[count] = i
            count += 1
    return found[:count].copy()


@entry_kernel
def thinness(points: Fixed2, low: Fixed1, high: Fixed1) -> float:
    """Smallest extent of points over the length of their longest line; 0 for flat points.

    The thickness is measured across the plane of the longest line and the point farthest
    from it, so that it does not depend on how the points lie in their frame.

    Parameters
    ----------
    points : (N, 3) array
        Not all equal.
    low, high : (3,) arrays
        Their bounds.
    """
    axis = 0
    for c in range(1, 3):
        if high[c] - low[c] > high[axis] - low[axis]:
            axis = c
    size = high[axis] - low[axis]
    mx, my = low[0] + 0.5 * (high[0] - low[0]), low[1] + 0.5 * (high[1] - low[1])
    mz = low[2] + 0.5 * (high[2] - low[2])
    first, last = 0, 0
    for i in range(points.shape[0]):
        if points[i, axis] < points[first, axis]:
            first = i
        if points[i, axis] > points[last, axis]:
            last = i
    bx, by, bz = ((points[first, 0] - mx) / size, (points[first, 1] - my) / size,
                  (points[first, 2] - mz) / size)
    lx, ly, lz = ((points[last, 0] - mx) / size - bx, (points[last, 1] - my) / size - by,
                  (points[last, 2] - mz) / size - bz)
    longest = math.sqrt(lx * lx + ly * ly + lz * lz)
    lx, ly, lz = lx / longest, ly / longest, lz / longest
    fx = fy = fz = 0.0
    widest = 0.0
    for i in range(points.shape[0]):
        x, y, z = ((points[i, 0] - mx) / size - bx, (points[i, 1] - my) / size - by,
                   (points[i, 2] - mz) / size - bz)
        along = x * lx + y * ly + z * lz
        x, y, z = x - along * lx, y - along * ly, z - along * lz
        aside = x * x + y * y + z * z
        if aside > widest:
            widest, fx, fy, fz = aside, x, y, z
    width = math.sqrt(widest)
    if width == 0.0:
        return 0.0
    nx, ny, nz = ((ly * fz - lz * fy) / width, (lz * fx - lx * fz) / width,
                  (lx * fy - ly * fx) / width)
    least, most = math.inf, -math.inf
    for i in range(points.shape[0]):
        off = ((points[i, 0] - mx) / size * nx + (points[i, 1] - my) / size * ny
               + (points[i, 2] - mz) / size * nz)
        least, most = min(least, off), max(most, off)
    return min(width, most - least) / longest
