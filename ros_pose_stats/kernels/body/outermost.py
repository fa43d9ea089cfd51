"""Corners of a convex hull that lie farthest out in some direction of a grid."""

from __future__ import annotations

import math

import numpy as np

from ..array_types import Array, Fixed2, FixedIndex1, Flags, Index
from ..compilation import entry_kernel, inlined
from ..elementary import sine_cosine
from ..vectors import Vec3, dot, plus, point_at, scaled


@entry_kernel
def outermost_corners(points: Fixed2, first: FixedIndex1, beside: FixedIndex1, axes: Fixed2,
                      sides: int, tie: float) -> Flags:
    """Which corners (H,) lie farthest out in a direction of a grid over the sphere.

    The rows of the grid are circles of latitude, mirrored at the equator, their directions as
    far apart as those of a circle of `sides` or half as far; a row has a fraction 2^-k of the
    directions of the equator.

    `points` (H, 3): corners of a convex hull; `first` (H + 1,); `beside` (2E,): neighbours of each
    corner: `beside[first[i]:first[i + 1]]`; `axes` (3, 3): the rows span the grid; the last goes
    through its poles; `tie`: what lies this little behind the farthest counts as well.
    """
    found = np.zeros(points.shape[0], np.bool_)
    here = 0
    rows = (sides + 3) // 4
    for row in range(-rows, rows + 1):
        z, ring = sine_cosine(0.5 * math.pi * row / rows)
        around = sides
        while around % 2 == 0 and 2.0 * ring * sides <= around:
            around //= 2
        if abs(row) == rows:
            around, ring = 1, 0.0
        for k in range(around):
            y, x = sine_cosine(2.0 * math.pi * k / around)
            direction = plus(plus(scaled(point_at(axes, 0), ring * x),
                                  scaled(point_at(axes, 1), ring * y)),
                             scaled(point_at(axes, 2), z))
            here = _climb(points, first, beside, direction, here)
            _mark_ties(points, first, beside, direction, here, tie, found)
    return found


@inlined
def _climb(points: Array, first: Index, beside: Index, direction: Vec3, here: int) -> int:
    """Corner farthest along a direction, over neighbours that lie farther each time."""
    most, rising = dot(direction, point_at(points, here)), True
    while rising:
        rising, start = False, here
        for k in range(first[start], first[start + 1]):
            value = dot(direction, point_at(points, beside[k]))
            if value > most:
                most, here, rising = value, beside[k], True
    return here


@inlined
def _mark_ties(points: Array, first: Index, beside: Index, direction: Vec3, top: int, tie: float,
               found: Flags) -> None:
    """Mark the farthest corner, or both ends of an edge that are as far but for `tie`.

    Nothing is marked where a whole face is as far: it says nothing about its corners.
    """
    least = dot(direction, point_at(points, top)) - tie
    ties, other = 0, top
    for k in range(first[top], first[top + 1]):
        if dot(direction, point_at(points, beside[k])) >= least:
            ties, other = ties + 1, beside[k]
    if ties < 2:
        found[top] = found[other] = True
