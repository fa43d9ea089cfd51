"""Labels: heights at which they do not lie on each other, and lengths that stay short."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def apart(heights: Array, gap: float, low: float = -math.inf, high: float = math.inf) -> Array:
    """Move heights as little as it takes to lie `gap` apart, in the same order.

    Parameters
    ----------
    heights : (k,) array
    gap : float
        In the same unit.
    low, high : float
        Bounds of the moved heights. Where they leave too little room, `high` gives way.

    Returns
    -------
    (k,) array
        Smallest sum of squared moves; equal heights keep their order.
    """
    order = np.argsort(heights, kind="stable")
    steps = gap * np.arange(len(heights))
    rising = _nearest_rising(heights[order] - steps)
    highest = high - gap * (len(heights) - 1)
    placed = np.empty_like(heights)
    placed[order] = np.maximum(np.minimum(rising, highest), low) + steps
    return placed


def _nearest_rising(values: Array) -> Array:
    """Nearest sequence that never falls: neighbours that fall are pooled into their mean."""
    pools: list[tuple[float, int]] = []
    for value in values:
        mean, size = float(value), 1
        while pools and pools[-1][0] > mean:
            before, count = pools.pop()
            mean, size = (before * count + mean * size) / (count + size), count + size
        pools.append((mean, size))
    return np.array([mean for mean, size in pools for _ in range(size)])


def in_digits(value: float, digits: int) -> str:
    """A length with so many digits, never with an exponent where it is large."""
    return f"{value:.{digits}g}" if value < 10.0 ** digits else f"{value:.0f}"
