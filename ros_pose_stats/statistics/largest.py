"""A bound that the errors of all poses of a part keep together."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]

WIDEST: Final = 1e6
"""A standard deviation beyond which nothing is known either; far outside of what was fitted it may
be infinite."""

NODES: Final = np.geomspace(0.01, 12.0, 64)
"""Where a bound is looked for, in the largest standard deviation; between them it is straight."""


def largest_error(deviation: ArrayLike, level: float, *, weight: ArrayLike = (1.0,),
                  away: ArrayLike = 0.0, size: ArrayLike = 1) -> float:
    """Bound that no pose's error exceeds with this probability, a fraction.

    The errors are taken as normal in each of M cases, one of which holds. Probabilities have a
    sum, so of G errors only G - 1 are free: what each of them keeps is multiplied, and the product
    taken to the power (G - 1) / G. That is exact for two units and for many, and errs by some
    per cent between.

    `deviation`: standard deviations of the units, as fractions; `level`: 0 < level < 1; `weight`
    (M,): of the cases, summing to 1; `away` (M, G): how far the middle of a unit lies from what is
    told of it; `size` (G,) int: poses of each unit, which share its error evenly. Returns from 0
    to 1; NaN where a deviation is.
    """
    share = 1.0 / np.asarray(size, dtype=np.float64)
    spread = np.minimum(np.atleast_2d(deviation), WIDEST) * share
    middle = np.broadcast_to(np.asarray(away, dtype=np.float64) * share, spread.shape)
    if np.isnan(spread).any():
        return float(np.nan)
    keep = (spread > 0.0).any(axis=0) | (middle != 0.0).any(axis=0)
    spread, middle = spread[:, keep], np.abs(middle[:, keep])
    units = spread.shape[1]
    if not units:
        return 0.0
    free = (units - 1.0) / units if units > 1 else 1.0
    scale = np.maximum(spread, np.finfo(float).tiny)
    bounds = NODES * float((middle + spread).max())
    inside = (ndtr((bounds[:, None, None] - middle) / scale)
              - ndtr((-bounds[:, None, None] - middle) / scale))
    kept = inside.prod(axis=2) ** free @ np.asarray(weight, dtype=np.float64)
    return min(float(np.interp(level, kept, bounds)), 1.0)
