"""How far points reach: bounding boxes, and how thin a cloud of points is."""

from __future__ import annotations

import math

import numpy as np

from .array_types import Array, Fixed1, Fixed2, FixedCorners2, Index
from .compilation import entry_kernel, inlined
from .vectors import (
    Vec3,
    cross,
    divided,
    dot,
    length,
    minus,
    plus,
    point_at,
    read_vector,
    scaled,
)


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

    `low, high` (B, 3): corners of the boxes; `slack`: by how much it may stick out.
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

    `points` (N, 3): not all equal; `low, high` (3,): their bounds.
    """
    axis = 0
    for c in range(1, 3):
        if high[c] - low[c] > high[axis] - low[axis]:
            axis = c
    size = high[axis] - low[axis]
    lowest = read_vector(low, 0)
    middle = plus(lowest, scaled(minus(read_vector(high, 0), lowest), 0.5))
    first, last = 0, 0
    for i in range(points.shape[0]):
        if points[i, axis] < points[first, axis]:
            first = i
        if points[i, axis] > points[last, axis]:
            last = i
    begin = _placed(points, first, middle, size)
    line = minus(_placed(points, last, middle, size), begin)
    longest = length(line)
    line = divided(line, longest)
    farthest, widest = Vec3(0.0, 0.0, 0.0), 0.0
    for i in range(points.shape[0]):
        there = minus(_placed(points, i, middle, size), begin)
        there = minus(there, scaled(line, dot(there, line)))
        aside = dot(there, there)
        if aside > widest:
            farthest, widest = there, aside
    width = math.sqrt(widest)
    if width == 0.0:
        return 0.0
    normal = divided(cross(line, farthest), width)
    least, most = math.inf, -math.inf
    for i in range(points.shape[0]):
        off = dot(_placed(points, i, middle, size), normal)
        least, most = min(least, off), max(most, off)
    return min(width, most - least) / longest


@inlined
def _placed(points: Array, i: int, middle: Vec3, size: float) -> Vec3:
    """A point about the middle of all, in units of their size."""
    return divided(minus(point_at(points, i), middle), size)
