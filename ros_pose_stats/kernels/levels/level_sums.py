"""Sums of many bends at many levels, without evaluating each bend at each level.

A component that swallows small neighbours one by one is measured at every one of these
joins. Its area is a sum over its triangles, and the only costly term, the bend of
`cap_areas`, is an analytic function of the level away from its critical value q, where it
starts like |E - q|^(3/2). Hence a tree over the sorted levels: a bend is added to the
largest ranges of levels that lie at least their own width away from q, as its values at
Chebyshev points (order 16, error below 1e-13 of the bend); only next to q it is evaluated
level by level. n joins over n faces cost n log n instead of n².
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..compilation import kernel
from .cap_areas import bend_R, bend_r

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ORDER = 16
FLAT = 1e-12


@kernel
def tree_nodes(levels: int) -> int:
    """Number of tree nodes (numbered as in a heap) that this many levels may need."""
    count = 2
    while levels > ORDER:
        levels = (levels + 1) // 2
        count *= 2
    return 2 * count


@kernel
def chebyshev() -> tuple[Array, Array]:
    """Chebyshev points of the first kind on [-1, 1] and their barycentric weights."""
    points, weights = np.empty(ORDER), np.empty(ORDER)
    for i in range(ORDER):
        angle = (2 * i + 1) * math.pi / (2 * ORDER)
        points[i] = math.cos(angle)
        weights[i] = math.sin(angle) if i % 2 == 0 else -math.sin(angle)
    return points, weights


@kernel
def add_bend(levels: Array, begin: int, end: int, weight: float, leg: float, other: float,
             q: float, of_R: bool, points: Array, samples: Array, sums: Array,
             stack: Index) -> None:
    """Add `weight` times a bend to the sums at the levels `begin` to `end`.

    Parameters
    ----------
    levels : (n,) array
        Rising.
    weight, leg, other, q : float
        Of the bend; `other` is d for r and v for R. All levels in the range lie beyond q.
    points : (ORDER,) array
    samples : (nodes, ORDER) array
        Values at the Chebyshev points of each tree node, added to.
    sums : (n,) array
        Added to where the bend is evaluated level by level.
    stack : (k, 3) array
        Scratch for node number and range.
    """
    stack[0, 0], stack[0, 1], stack[0, 2] = 1, 0, levels.shape[0]
    size = 1
    while size > 0:
        size -= 1
        node, low, high = stack[size, 0], stack[size, 1], stack[size, 2]
        if high <= begin or end <= low:
            continue
        first, last = levels[low], levels[high - 1]
        width = last - first
        gap = q - last if of_R else first - q
        if begin <= low and high <= end and gap >= width and high - low > ORDER:
            if width <= FLAT * last:
                samples[node, 0] += weight * _bend(leg, other, q, first, of_R)
                continue
            for i in range(ORDER):
                level = 0.5 * (first + last) + 0.5 * width * points[i]
                samples[node, i] += weight * _bend(leg, other, q, level, of_R)
            continue
        if high - low <= ORDER:
            for k in range(max(low, begin), min(high, end)):
                sums[k] += weight * _bend(leg, other, q, levels[k], of_R)
            continue
        middle = (low + high) // 2
        stack[size, 0], stack[size, 1], stack[size, 2] = 2 * node, low, middle
        stack[size + 1, 0], stack[size + 1, 1], stack[size + 1, 2] = 2 * node + 1, middle, high
        size += 2


@kernel
def _bend(leg: float, other: float, q: float, level: float, of_R: bool) -> float:
    return bend_R(leg, other, q, level) if of_R else bend_r(leg, other, q, level)


@kernel
def collect(levels: Array, points: Array, weights: Array, samples: Array, sums: Array,
            stack: Index) -> None:
    """Add the interpolated samples of every tree node to the sums at its levels."""
    stack[0, 0], stack[0, 1], stack[0, 2] = 1, 0, levels.shape[0]
    size = 1
    while size > 0:
        size -= 1
        node, low, high = stack[size, 0], stack[size, 1], stack[size, 2]
        if high - low <= ORDER:
            continue
        first, last = levels[low], levels[high - 1]
        for k in range(low, high):
            if last - first <= FLAT * last:
                sums[k] += samples[node, 0]
            else:
                at = (2.0 * levels[k] - first - last) / (last - first)
                sums[k] += _interpolate(at, points, weights, samples, node)
        middle = (low + high) // 2
        stack[size, 0], stack[size, 1], stack[size, 2] = 2 * node, low, middle
        stack[size + 1, 0], stack[size + 1, 1], stack[size + 1, 2] = 2 * node + 1, middle, high
        size += 2


@kernel
def _interpolate(at: float, points: Array, weights: Array, samples: Array, node: int) -> float:
    """Barycentric interpolation, which is exact at the points."""
    above = below = 0.0
    for i in range(ORDER):
        if at == points[i]:
            return float(samples[node, i])
        part = weights[i] / (at - points[i])
        above += part * samples[node, i]
        below += part
    return above / below
