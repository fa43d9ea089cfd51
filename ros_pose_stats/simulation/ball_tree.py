"""Corners of a body gathered in nested balls, so that a drop can pass over most of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh.vectors import lengths

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LEAF = 16
"""Corners that are looked at one by one; most parts of the paper's size need no tree."""

ROUNDING = 1e-12
"""Balls are this much larger than their corners ask for, relative to the radius of the part."""


def ball_tree(points: Array) -> tuple[Index, Array, Index]:
    """Binary tree of balls, in the order in which it is walked.

    Parameters
    ----------
    points : (C, 3) array

    Returns
    -------
    order : (C,) array
        Points as the leaves hold them, from the first leaf to the last.
    ball : (B, 5) array
        Centre, radius, and distance of the centre from the origin.
    ball_range : (B, 3) array
        First and last + 1 place in `order`, and the node that follows the subtree: the next
        one for a leaf.
    """
    order: list[Index] = []
    balls: list[tuple[float, ...]] = []
    ranges: list[list[int]] = []
    # Nodes are numbered as they are first seen, a left child right after its parent.
    waiting: list[Index] = [np.arange(points.shape[0])]
    ancestors: list[tuple[int, int]] = []  # node and where its corners end
    placed = 0
    while waiting:
        inside = waiting.pop()
        node = len(balls)
        balls.append(_ball(points[inside]))
        ranges.append([placed, placed + inside.shape[0], node + 1])
        ancestors.append((node, placed + inside.shape[0]))
        if inside.shape[0] <= LEAF:
            order.append(inside)
            placed += inside.shape[0]
        else:
            near, far = _halves(points, inside)
            waiting += [far, near]
        while ancestors and ancestors[-1][1] == placed:
            done, _ = ancestors.pop()
            ranges[done][2] = len(balls)
    return np.concatenate(order), np.array(balls), np.array(ranges, dtype=np.int64)


def _ball(points: Array) -> tuple[float, ...]:
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = float(lengths(points - center).max()) + ROUNDING
    return (*center.tolist(), radius, float(lengths(center[None])[0]))


def _halves(points: Array, inside: Index) -> tuple[Index, Index]:
    axis = int(np.argmax(np.ptp(points[inside], axis=0)))
    middle = inside.shape[0] // 2
    # Stable, for a partition leaves its halves in an order that depends on the processor.
    ranked = inside[np.argsort(points[inside, axis], kind="stable")]
    return ranked[:middle], ranked[middle:]
