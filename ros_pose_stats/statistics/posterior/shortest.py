"""The shortest interval that holds a share of a Beta distribution."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaincinv, xlog1py, xlogy

Array = NDArray[np.float64]

HALVINGS: Final = 12
"""Of the probability below the interval: to a 40 000th."""


def shortest_interval(a: Array, b: Array, level: float) -> tuple[Array, Array]:
    """Bounds between which the density is nowhere lower than outside.

    Where the density falls from 0 on (a <= 1 < b) the lower bound is 0, where it rises up to 1
    the upper one is 1; where it does both, as much is left out at either end. An infinite a
    is a certain value: 0 where b is above 0, else 1.

    Parameters
    ----------
    a, b : (P,) array
        Of the Beta distributions, above 0; NaN marks a distribution that is one point.
    level : float
        0 < level < 1.
    """
    out = 1.0 - level
    below = np.where(a <= 1.0, np.where(b <= 1.0, 0.5 * out, 0.0), np.where(b <= 1.0, out, np.nan))
    inside = np.isnan(below)
    below[inside] = _balanced(a[inside], b[inside], out)
    low = np.where(below > 0.0, betaincinv(a, b, below), 0.0)
    high = np.where(below < out, betaincinv(a, b, below + level), 1.0)
    return low, high


def _balanced(a: Array, b: Array, out: float) -> Array:
    """Probability below the interval where the density is equal at both ends (a, b > 1)."""
    least, most = np.zeros_like(a), np.full_like(a, out)
    for _ in range(HALVINGS):
        middle = 0.5 * (least + most)
        low, high = betaincinv(a, b, middle), betaincinv(a, b, 1.0 - out + middle)
        too_low = _log_density(a, b, low) < _log_density(a, b, high)
        least, most = np.where(too_low, middle, least), np.where(too_low, most, middle)
    return np.asarray(0.5 * (least + most))


def _log_density(a: Array, b: Array, x: Array) -> Array:
    return np.asarray(xlogy(a - 1.0, x) + xlog1py(b - 1.0, -x))
