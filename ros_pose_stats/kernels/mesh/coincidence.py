"""Vertices that coincide, found through a hashed grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed1, Fixed2
from ..compilation import entry_kernel, inlined
from ..grid import WIDTH, Slots, cube, insert, slot_of, slots_for
from .components import join, root

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@entry_kernel
def first_of_coincident(points: Fixed2, low: Fixed1, tolerance: float) -> tuple[bool, Index]:
    """For each point the lowest number among those that it coincides with.

    Parameters
    ----------
    points : (V, 3) array
    low : (3,) array
        Their lowest coordinates.
    tolerance : float
        Points that are no farther apart coincide, and those that a chain of such links.

    Returns
    -------
    any : bool
        Whether two points coincide.
    first : (V,) array
    """
    count = points.shape[0]
    head, chain = np.full(slots_for(count), -1, np.int32), np.empty(count, np.int32)
    first = np.arange(count)
    lx, ly, lz, width = low[0], low[1], low[2], WIDTH * tolerance
    for i in range(count):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        x, y, z = cube(px, lx, width), cube(py, ly, width), cube(pz, lz, width)
        # A point that repeats another has its neighbours, and need not stand beside it.
        if _meet(points, head, chain, first, i, x, y, z, tolerance):
            continue
        x0, x1 = cube(px - tolerance, lx, width), cube(px + tolerance, lx, width)
        y0, y1 = cube(py - tolerance, ly, width), cube(py + tolerance, ly, width)
        z0, z1 = cube(pz - tolerance, lz, width), cube(pz + tolerance, lz, width)
        if x0 < x1 or y0 < y1 or z0 < z1:
            for u in range(x0, x1 + 1):
                for v in range(y0, y1 + 1):
                    for w in range(z0, z1 + 1):
                        if u != x or v != y or w != z:
                            _meet(points, head, chain, first, i, u, v, w, tolerance)
        insert(head, chain, i, x, y, z)
    found = False
    for i in range(count):
        first[i] = root(first, i)
        found = found or first[i] != i
    return found, first


@inlined
def _meet(points: Array, head: Slots, chain: Slots, first: Index, i: int, x: int, y: int, z: int,
          tolerance: float) -> bool:
    """Join point `i` to those of a cube that it coincides with; tell whether it repeats one."""
    j = head[slot_of(x, y, z, head.shape[0])]
    while j >= 0:
        dx, dy, dz = (points[j, 0] - points[i, 0], points[j, 1] - points[i, 1],
                      points[j, 2] - points[i, 2])
        square = dx * dx + dy * dy + dz * dz
        if square <= tolerance * tolerance:
            join(first, i, j)
            if dx == 0.0 and dy == 0.0 and dz == 0.0:
                return True
        j = chain[j]
    return False
