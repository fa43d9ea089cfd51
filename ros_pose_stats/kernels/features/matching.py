"""Whether a rotation carries features into each other, one to one.

A feature is a row of numbers: a place, then perhaps a vector and a number that does not
depend on direction. Two features are alike when their rows are close to each other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..array_types import Array, Array2, Fixed2, FixedIndex1, Index1, Slots, Slots1
from ..compilation import entry_kernel, inlined
from ..grid import WIDTH, Cube, cube_at, insert, slot_of, slots_for
from ..vectors import Vec3, point_at, read_row, read_vector, turned, write_vector


class FeatureGrid(NamedTuple):
    """Features in a grid of cubes by their places."""

    rows: Array2   # (N, 3) or (N, 7)
    head: Slots1   # see `grid`
    chain: Slots1  # (N,)
    reach: float   # largest distance of like features
    taken: Index1  # (N,) scratch: the last trial in which a feature was matched
    trials: Index1  # (1,) number of trials so far


@entry_kernel
def feature_grid(rows: Fixed2, reach: float) -> FeatureGrid:
    """Put features (N, 3) or (N, 7) into a grid that serves distances up to `reach`."""
    count = rows.shape[0]
    head, chain = np.full(slots_for(count), -1, np.int32), np.empty(count, np.int32)
    width = WIDTH * reach
    # From the last, so that chains run from the first.
    for i in range(count - 1, -1, -1):
        insert(head, chain, i, cube_at(point_at(rows, i), 0.0, Vec3(0.0, 0.0, 0.0), width))
    return FeatureGrid(rows, head, chain, reach, np.zeros(count, np.int64),
                       np.zeros(1, np.int64))


@entry_kernel
def first_unmatched(grid: FeatureGrid, rotation: Fixed2, chosen: FixedIndex1) -> int:
    """First of the chosen features with no feature of its own where the rotation puts it.

    `rotation` (3, 3); `chosen` (M,): numbers of features; an empty array chooses all. Returns
    number of a feature; -1 when all find one.
    """
    rows, head, chain, taken = grid.rows, grid.head, grid.chain, grid.taken
    grid.trials[0] += 1
    trial = grid.trials[0]
    image = np.empty(rows.shape[1])
    for m in range(chosen.shape[0] if chosen.shape[0] > 0 else rows.shape[0]):
        i = chosen[m] if chosen.shape[0] > 0 else m
        _turn(rows, i, rotation, image)
        partner = _nearest(rows, head, chain, image, grid.reach)
        if partner < 0 or taken[partner] == trial:
            return i
        taken[partner] = trial
    return -1


@inlined
def _turn(rows: Array, i: int, rotation: Array, image: Array) -> None:
    """Image of a feature: its place and its vector are turned, the rest stays."""
    vectors = 3 * (rows.shape[1] // 3)
    for first in range(0, vectors, 3):
        write_vector(image, first, turned(rotation, read_row(rows, i, first)))
    for k in range(vectors, rows.shape[1]):
        image[k] = rows[i, k]


@inlined
def _nearest(rows: Array, head: Slots, chain: Slots, image: Array, reach: float) -> int:
    """Feature closest to a row, -1 when none is closer than `reach`."""
    place, origin, width = read_vector(image, 0), Vec3(0.0, 0.0, 0.0), WIDTH * reach
    low = cube_at(place, -reach, origin, width)
    high = cube_at(place, reach, origin, width)
    best, partner = reach * reach, -1
    for x in range(low.x, high.x + 1):
        for y in range(low.y, high.y + 1):
            for z in range(low.z, high.z + 1):
                j = head[slot_of(Cube(x, y, z), head.shape[0])]
                while j >= 0:
                    square = 0.0
                    for k in range(rows.shape[1]):
                        step = rows[j, k] - image[k]
                        square += step * step
                    if square < best:
                        best, partner = square, j
                    j = chain[j]
    return partner
