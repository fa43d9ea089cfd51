"""Two variants of a part dropped from the same starts: the difference of their shares.

The drops of one start form a pair. Where both parts of a pair come to rest alike it says nothing
about a difference, so only pairs that part count, and the chance that both have in common is gone.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr, ndtri

from ..records import Array, Mask
from .errors import DEFAULT_LEVEL


class PairedDifference(NamedTuple):
    """How much more often one thing happened than another in the same trials."""

    value: float  # share of the second less that of the first; NaN without trials
    standard_error: float  # of the value
    low: float  # 90 % interval of the difference, for this one by itself
    high: float
    gained: int  # trials in which only the second happened, and only the first
    lost: int
    trials: int
    # chance of trials that differ this much if none is more frequent, exact: `gained` of `gained +
    # lost` as in the tosses of a fair coin (McNemar's test)
    p_value: float


def paired_difference(first: Mask, second: Mask) -> PairedDifference:
    """Compare how often two things happened in the same trials (n,).

    The 90 % interval is that of Agresti and Min, "Simple improved confidence intervals for
    comparing matched proportions", Statistics in Medicine 24 (2005): half a trial of each kind is
    added.
    """
    gained, lost = int((second & ~first).sum()), int((first & ~second).sum())
    if first.size == 0:
        return PairedDifference(math.nan, math.nan, -1.0, 1.0, 0, 0, 0, 1.0)
    z = -float(ndtri(0.5 * (1.0 - DEFAULT_LEVEL)))
    value, error = _normal(gained, lost, first.size)
    middle, spread = _normal(gained + 0.5, lost + 0.5, first.size + 2.0)
    return PairedDifference(value, error, max(-1.0, middle - z * spread),
                            min(1.0, middle + z * spread), gained, lost, first.size,
                            chance_of_split(gained, lost))


def _normal(gained: float, lost: float, trials: float) -> tuple[float, float]:
    """Difference of the shares and its standard error."""
    value = (gained - lost) / trials
    return value, math.sqrt(max(0.0, (gained + lost) / trials - value * value) / trials)


def chance_of_split(gained: int, lost: int) -> float:
    """Two-sided chance that a fair coin splits its tosses at least as unevenly."""
    if gained + lost == 0:
        return 1.0
    return min(1.0, 2.0 * float(bdtr(min(gained, lost), gained + lost, 0.5)))


def adjust_together(p_values: ArrayLike) -> Array:
    """Chances (K,) of tests, adjusted so that all are wrong as seldom as one (Holm 1979)."""
    chances = np.asarray(p_values, dtype=np.float64)
    order = np.argsort(chances, kind="stable")
    steps = np.maximum.accumulate(chances[order] * (chances.size - np.arange(chances.size)))
    adjusted = np.empty_like(chances)
    adjusted[order] = np.minimum(steps, 1.0)
    return adjusted
