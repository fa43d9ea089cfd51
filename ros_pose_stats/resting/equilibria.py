"""Equilibria of a part on a horizontal plate (sections 2.B, 2.C).

Stable faces are numbered by rising height, ties by the components of `down`; nothing here
depends on a method, a scene or a seed.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..kernels.body.equilibria import EquilibriumArrays, find_equilibria
from ..kernels.sorting import number_ties
from ..records import Array, Index, Part
from ..tolerances import SAME_DOWN, SAME_HEIGHT
from .convex_body import ConvexBody, convex_body


@dataclass(frozen=True, eq=False)
class Equilibria:
    """Stable, saddle and unstable equilibria of a convex body."""

    body: ConvexBody
    arrays: EquilibriumArrays  # from the kernel; `arrays.stable` is in the order of face numbers
    # (S,); positions in `arrays.stable` by rising height: the numbering of the stable faces
    order: Index

    @cached_property
    def faces(self) -> Index:
        """Face (S,) of each stable face, by rising height."""
        return self.arrays.stable[self.order]

    @cached_property
    def heights(self) -> Array:
        """Height (S,) of the centre of mass on each stable face, in radii."""
        return self.body.arrays.distance[self.faces]

    @cached_property
    def downs(self) -> Array:
        """Direction (S, 3) that points down on each stable face."""
        return self.body.arrays.normal[self.faces]

    @cached_property
    def rank(self) -> Index:
        """Number (S,) of each entry of `arrays.stable`: the inverse of `order`."""
        rank = np.empty_like(self.order)
        rank[self.order] = np.arange(self.order.shape[0])
        return rank

    @property
    def unstable(self) -> Index:
        """Hull points (U,) at a maximum of r and R."""
        return self.arrays.unstable

    @property
    def poincare_hopf(self) -> int:
        """S - H + U, which is 2 for a body without degenerate equilibria."""
        return len(self.arrays.stable) - len(self.arrays.saddle) + len(self.unstable)


def equilibria(part: Part, round_sides: int) -> Equilibria:
    """Equilibria of a part, found once and kept as long as the part lives."""
    return part.prepare(_find, round_sides)


def _find(part: Part, round_sides: int) -> Equilibria:
    body = convex_body(part, round_sides)
    arrays = find_equilibria(body.points, body.arrays)
    heights = body.arrays.distance[arrays.stable]
    return Equilibria(body, arrays, pose_order(heights, body.arrays.normal[arrays.stable]))


def pose_order(heights: Array, downs: Array) -> Index:
    """Order (S,) of poses by rising height in radii, ties by the components of `down`."""
    group = ties((heights, SAME_HEIGHT), *((down, SAME_DOWN) for down in downs.T))
    return np.argsort(group, kind="stable")


def ties(*keys: tuple[Array, float], within: Index | None = None) -> Index:
    """Number ties (S,) by rising value of the first key, then of the next, and so on.

    Keys are values with their tolerance. A tie holds all within the tolerance of its smallest
    value, so that a dense sequence is not one long tie. `within`: groups that come before all
    keys.
    """
    size = keys[0][0].shape[0]
    group = np.zeros(size, dtype=np.int64) if within is None else within
    count = 1 if within is None else int(within.max()) + 1
    for values, tolerance in keys:
        if count == size:  # no two values are tied any more
            break
        plain = np.ascontiguousarray(values)
        group, count = number_ties(plain, tolerance, group, np.lexsort((plain, group)))
    return group
