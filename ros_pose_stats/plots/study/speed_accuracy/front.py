"""The points that no other point beats in both time and error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Timed(Protocol):
    """What the front looks at: a time and an error, in any unit."""

    @property
    def seconds(self) -> float:
        """Time of a part."""

    @property
    def error(self) -> float:
        """Error of its probabilities."""


def pareto_front(points: Sequence[Timed]) -> list[int]:
    """Find the points than which no other is both faster and more exact.

    Parameters
    ----------
    points : sequence
        Each with `seconds` and `error`, neither NaN.

    Returns
    -------
    list of int
        Places in `points`, the fastest first and of equally fast ones the least exact first,
        so that the errors never rise.
    """
    order = sorted(range(len(points)), key=lambda k: (points[k].seconds, -points[k].error))
    front: list[int] = []
    faster, seen, now = np.inf, np.inf, -np.inf  # smallest error before this time and up to it
    for place in order:
        if points[place].seconds > now:
            faster, now = seen, points[place].seconds
        if points[place].error <= faster:
            front.append(place)
        seen = min(seen, points[place].error)
    return front


def stair(points: Sequence[Timed], slowest: float, worst: float) -> tuple[Array, Array]:
    """Corners of the line below and left of which there is no point.

    Parameters
    ----------
    points : sequence
        As for `pareto_front`, at least one.
    slowest, worst : float
        Where the line ends to the right and at the top, in the units of the points.

    Returns
    -------
    seconds, error : (2 k + 1,) arrays
        From the top over the k points of the front to the right.
    """
    front = [points[place] for place in pareto_front(points)]
    seconds = np.repeat([point.seconds for point in front], 2)
    error = np.repeat([point.error for point in front], 2)
    return np.append(seconds, (slowest,)), np.concatenate(((worst,), error))
