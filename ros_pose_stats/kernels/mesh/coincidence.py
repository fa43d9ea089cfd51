"""Vertices that coincide, found through a hashed grid."""

from __future__ import annotations

import numpy as np

from ..array_types import Array, Fixed1, Fixed2, Index, Slots
from ..compilation import entry_kernel, inlined
from ..grid import WIDTH, Cube, cube_at, insert, slot_of, slots_for
from ..vectors import dot, minus, point_at, read_vector
from .components import join, root


@entry_kernel
def first_of_coincident(points: Fixed2, low: Fixed1, tolerance: float) -> tuple[bool, Index]:
    """For each point the lowest number among those that it coincides with.

    `points` (V, 3); `low` (3,): their lowest coordinates; `tolerance`: points that are no farther
    apart coincide, and those that a chain of such links. Returns `any`: whether two points
    coincide; `first` (V,).
    """
    count = points.shape[0]
    head, chain = np.full(slots_for(count), -1, np.int32), np.empty(count, np.int32)
    first = np.arange(count)
    corner, width = read_vector(low, 0), WIDTH * tolerance
    for i in range(count):
        point = point_at(points, i)
        home = cube_at(point, 0.0, corner, width)
        # A point that repeats another has its neighbours, and need not stand beside it.
        if _meet(points, head, chain, first, i, home, tolerance):
            continue
        nearest = cube_at(point, -tolerance, corner, width)
        farthest = cube_at(point, tolerance, corner, width)
        if nearest.x < farthest.x or nearest.y < farthest.y or nearest.z < farthest.z:
            _meet_around(points, head, chain, first, i, home, nearest, farthest, tolerance)
        insert(head, chain, i, home)
    found = False
    for i in range(count):
        first[i] = root(first, i)
        found = found or first[i] != i
    return found, first


@inlined
def _meet_around(points: Array, head: Slots, chain: Slots, first: Index, i: int, home: Cube,
                 nearest: Cube, farthest: Cube, tolerance: float) -> None:
    """Join point `i` to those that it coincides with in the other cubes that it is close to."""
    for x in range(nearest.x, farthest.x + 1):
        for y in range(nearest.y, farthest.y + 1):
            for z in range(nearest.z, farthest.z + 1):
                if x != home.x or y != home.y or z != home.z:
                    _meet(points, head, chain, first, i, Cube(x, y, z), tolerance)


@inlined
def _meet(points: Array, head: Slots, chain: Slots, first: Index, i: int, cube: Cube,
          tolerance: float) -> bool:
    """Join point `i` to those of a cube that it coincides with; tell whether it repeats one."""
    j = head[slot_of(cube, head.shape[0])]
    while j >= 0:
        apart = minus(point_at(points, j), point_at(points, i))
        if dot(apart, apart) <= tolerance * tolerance:
            join(first, i, j)
            if apart.x == 0.0 and apart.y == 0.0 and apart.z == 0.0:
                return True
        j = chain[j]
    return False
