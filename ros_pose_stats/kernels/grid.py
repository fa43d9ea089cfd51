"""Points in a hashed grid of cubes, so that near ones are found without sorting.

Points whose cubes share a slot of the table form a chain: `head[slot]` is the latest, and
`chain[i]` the one before point i, -1 where there is none. The cubes are wide beside the
distance asked for, so that most questions touch one cube only.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .compilation import inlined, kernel

Array = NDArray[np.float64]
Slots = NDArray[np.int32]

WIDTH = 16.0
"""Side of a cube in units of the distance asked for."""


@kernel
def slots_for(count: int) -> int:
    """Size of the table for this many points: a power of two."""
    slots = 64
    while slots < count:
        slots *= 2
    return slots


@inlined
def slot_of(x: int, y: int, z: int, slots: int) -> int:
    """Slot of a cube given by its integer coordinates (below 2^31)."""
    # Primes keep neighbouring cubes apart; the product's upper bits depend on all of them.
    mixed = (x * 73856093 ^ y * 19349663 ^ z * 83492791) & 0x7FFFFFFF
    return (mixed * 0x9E3779B1 >> 31) & (slots - 1)


@inlined
def cube(x: float, low: float, width: float) -> int:
    """Integer coordinate of the cube that holds a coordinate."""
    return math.floor((x - low) / width)


@inlined
def insert(head: Slots, chain: Slots, i: int, x: int, y: int, z: int) -> None:
    """Put point `i` into the cube x y z."""
    slot = slot_of(x, y, z, head.shape[0])
    chain[i] = head[slot]
    head[slot] = i
