"""Points in a hashed grid of cubes, so that near ones are found without sorting.

Points whose cubes share a slot of the table form a chain: `head[slot]` is the latest, and
`chain[i]` the one before point i, -1 where there is none. The cubes are wide beside the
distance asked for, so that most questions touch one cube only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .array_types import Slots
from .compilation import inlined, kernel
from .vectors import Vec3

WIDTH = 16.0
"""Side of a cube in units of the distance asked for."""


class Cube(NamedTuple):
    """A cube by its integer coordinates (below 2^31)."""

    x: int
    y: int
    z: int


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
    # Primes keep neighbouring cubes apart; the product's upper bits depend on all of them.
    mixed = (cube.x * 73856093 ^ cube.y * 19349663 ^ cube.z * 83492791) & 0x7FFFFFFF
    return (mixed * 0x9E3779B1 >> 31) & (slots - 1)


@inlined
def cube_at(point: Vec3, offset: float, low: Vec3, width: float) -> Cube:
    """Cube that holds a point moved by `offset` along every axis; the grid begins at `low`."""
    return Cube(math.floor((point.x + offset - low.x) / width),
                math.floor((point.y + offset - low.y) / width),
                math.floor((point.z + offset - low.z) / width))


@inlined
def insert(head: Slots, chain: Slots, i: int, cube: Cube) -> None:
    """Put point `i` into a cube."""
    slot = slot_of(cube, head.shape[0])
    chain[i] = head[slot]
    head[slot] = i
