# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What is close: vertices that coincide.

Points are put into a hashed grid of cubes, so that near ones are found without sorting.
Those whose cubes share a slot of the table form a chain: `head[slot]` is the latest,
and `chain[i]` the one before point i, -1 where there is none. The cubes are wide beside
the distance asked for, so that most questions touch one cube only.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import (
    Array,
    Fixed1,
    Fixed2,
    Index,
    Slots1,
)
from ..compilation import entry_kernel, inlined, kernel
from ..vectors import (
    Vec3,
    dot,
    point_at,
    read_vector,
    subtract,
)
from .connections import find_representative, join_sets

WIDTH = 16.0
"""Side of a cube in units of the distance asked for."""


class Cube(NamedTuple):
    """A cube by its integer coordinates (below 2^31)."""

    x: int
    y: int
    z: int


class Cubes(NamedTuple):
    """Points in a hashed grid of cubes, as in the docstring above."""

    head: Slots1  # a power of two
    chain: Slots1  # (N,)


@kernel
def new_cubes(count: int) -> Cubes:
    """Grid for that many points, still empty."""
    return Cubes(np.full(slots_for(count), -1, np.int32), np.empty(count, np.int32))


@kernel
def slots_for(count: int) -> int:
    """Size of the table for this many points: a power of two."""
    slots = 64
    while slots < count:
        slots *= 2
    return slots


@inlined
def slot_of(cube: Cube, slots: int) -> int:
    """Slot of a cube."""
    # Primes keep neighbouring cubes apart; the product's upper bits depend on all of
    # them.
    mixed = (cube.x * 73856093 ^ cube.y * 19349663 ^ cube.z * 83492791) & 0x7FFFFFFF
    return (mixed * 0x9E3779B1 >> 31) & (slots - 1)


@inlined
def cube_at(point: Vec3, offset: float, low: Vec3, width: float) -> Cube:
    """Cube of a point moved by `offset` along every axis; the grid begins at `low`."""
    return Cube(
        math.floor((point.x + offset - low.x) / width),
        math.floor((point.y + offset - low.y) / width),
        math.floor((point.z + offset - low.z) / width),
    )


@inlined
def insert_point(cubes: Cubes, i: int, cube: Cube) -> None:
    """Put point `i` into a cube."""
    slot = slot_of(cube, cubes.head.shape[0])
    cubes.chain[i] = cubes.head[slot]
    cubes.head[slot] = i


@inlined
def latest_point(cubes: Cubes, cube: Cube) -> int:
    """Point from which the chain of a cube's slot runs, -1 for none."""
    return int(cubes.head[slot_of(cube, cubes.head.shape[0])])


@entry_kernel
def first_of_coincident(points: Fixed2, low: Fixed1, tolerance: float) -> Index:
    """Lowest number of the points that each point coincides with: its own, or less."""
    count = points.shape[0]
    cubes = new_cubes(count)
    first = np.arange(count)
    corner = read_vector(low, 0)
    width = WIDTH * tolerance
    for i in range(count):
        point = point_at(points, i)
        own_cube = cube_at(point, 0.0, corner, width)
        # A point that repeats another has its neighbours, and need not stand beside it.
        if _join_coincident(points, cubes, first, i, own_cube, tolerance):
            continue
        nearest = cube_at(point, -tolerance, corner, width)
        farthest = cube_at(point, tolerance, corner, width)
        if nearest.x < farthest.x or nearest.y < farthest.y or nearest.z < farthest.z:
            _join_in_cubes(
                points, cubes, first, i, own_cube, nearest, farthest, tolerance
            )
        insert_point(cubes, i, own_cube)
    for i in range(count):
        first[i] = find_representative(first, i)
    return first


@inlined
def _join_in_cubes(
    points: Array,
    cubes: Cubes,
    first: Index,
    i: int,
    own_cube: Cube,
    nearest: Cube,
    farthest: Cube,
    tolerance: float,
) -> None:
    """Join point `i` to those that coincide with it in the other cubes close by."""
    for x in range(nearest.x, farthest.x + 1):
        for y in range(nearest.y, farthest.y + 1):
            for z in range(nearest.z, farthest.z + 1):
                if x != own_cube.x or y != own_cube.y or z != own_cube.z:
                    _join_coincident(points, cubes, first, i, Cube(x, y, z), tolerance)


@inlined
def _join_coincident(
    points: Array,
    cubes: Cubes,
    first: Index,
    i: int,
    cube: Cube,
    tolerance: float,
) -> bool:
    """Join point `i` to those of a cube close to it; tell whether it repeats one."""
    j = latest_point(cubes, cube)
    while j >= 0:
        offset = subtract(point_at(points, j), point_at(points, i))
        if dot(offset, offset) <= tolerance * tolerance:
            join_sets(first, i, j)
            if offset.x == 0.0 and offset.y == 0.0 and offset.z == 0.0:
                return True
        j = cubes.chain[j]
    return False
