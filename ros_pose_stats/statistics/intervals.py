"""Bounds of a probability that was counted."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv

from ..errors import RequestError

Array = NDArray[np.float64]

DEFAULT_LEVEL: Final = 0.9
"""Chance that `probability_low` and `probability_high` of the contract enclose the truth."""


def jeffreys_interval(count: ArrayLike, total: ArrayLike,
                      level: float = DEFAULT_LEVEL) -> tuple[Array, Array]:
    """Equal-tailed Jeffreys interval of a binomial probability.

    The quantiles of Beta(count + 1/2, total - count + 1/2), with 0 as the lower bound where
    nothing was counted and 1 as the upper bound where everything was: Brown, Cai and
    DasGupta, "Interval estimation for a binomial proportion", Statistical Science 16 (2001),
    section 4.1. Without these ends the interval would miss every probability near 0 or 1.

    `count`: 0 <= count <= total. Broadcast against `total`; `total`: need not be whole: an
    effective number of drops is (count and total divided alike). Where it is 0 the interval is (0,
    1); `level`: 0 < level < 1. Returns 0 <= low <= high <= 1. Raises RequestError if a count or
    the level is out of its range.
    """
    counted, totals = np.broadcast_arrays(np.asarray(count, float), np.asarray(total, float))
    if not 0.0 < level < 1.0:
        raise RequestError("a level between 0 and 1", f"{level}", "0.9 is the contract's")
    bad = ~((counted >= 0.0) & (counted <= totals) & np.isfinite(totals))
    if bad.any():
        raise RequestError("counts from 0 to their total",
                           f"{counted[bad][0]:g} of {totals[bad][0]:g}",
                           "divide both by the same variance factor")
    a, b, tail = counted + 0.5, totals - counted + 0.5, (1.0 - level) / 2.0
    low = np.where(counted == 0.0, 0.0, betaincinv(a, b, tail))
    high = np.where(counted == totals, 1.0, betaincinv(a, b, 1.0 - tail))
    return low, high
