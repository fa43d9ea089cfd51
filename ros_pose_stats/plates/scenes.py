"""Restitutions and drop heights that a plate may stand for, as points and as grids of points."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LARGEST_RESTITUTION = 0.9
LOWEST_RADII, HIGHEST_RADII = 0.75, 100.0
"""Of the smallest part and of the largest: below, all parts touch the plate at release, and above
they forget the height."""


@dataclass(frozen=True)
class SceneRange:
    """Where a plate is looked for.

    A point is a restitution and the logarithm of a drop height in metres.
    """

    lowest: float  # drop heights, metres
    highest: float

    @classmethod
    def of_radii(cls, radii: Iterable[float]) -> "SceneRange":
        """The range for parts of some radii, metres."""
        known = list(radii)
        return cls(LOWEST_RADII * min(known), HIGHEST_RADII * max(known))

    @property
    def bounds(self) -> Array:
        """Lowest and highest point, (2, 2)."""
        return np.array([[0.0, np.log(self.lowest)],
                         [LARGEST_RESTITUTION, np.log(self.highest)]])

    def spread_points(self, count: int) -> Array:
        """Points (count, 2) that fill the range evenly (Halton 1960)."""
        low, high = self.bounds
        unit = np.array([[_radical_inverse(k, base) for base in (2, 3)]
                         for k in range(1, count + 1)])
        return np.asarray(low + unit * (high - low))


@dataclass(frozen=True, eq=False)
class SceneGrid:
    """Points on a grid that need not be even."""

    restitution: Array  # (n,)
    log_height: Array  # (m,); logarithms of metres

    @classmethod
    def over(cls, bounds: Array, count: int) -> "SceneGrid":
        """An even grid of `count` × `count` points over bounds (2, 2)."""
        return cls(*np.linspace(bounds[0], bounds[1], count).T)

    def refined(self, bounds: Array, count: int) -> "SceneGrid":
        """The same with `count` more values of each coordinate within bounds (2, 2)."""
        more = np.linspace(bounds[0], bounds[1], count).T
        return SceneGrid(np.union1d(self.restitution, more[0]),
                         np.union1d(self.log_height, more[1]))

    @property
    def points(self) -> Array:
        """All points (n m, 2), row by row of the restitution."""
        return np.stack(np.meshgrid(self.restitution, self.log_height, indexing="ij"),
                        axis=-1).reshape(-1, 2)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of restitutions and of heights."""
        return self.restitution.size, self.log_height.size


def _radical_inverse(number: int, base: int) -> float:
    weight, found = 1.0, 0.0
    while number:
        weight /= base
        found += weight * (number % base)
        number //= base
    return found
