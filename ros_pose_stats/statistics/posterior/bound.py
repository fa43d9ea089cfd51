"""How large the root mean square error over the poses may be."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

Array = NDArray[np.float64]

SMALLEST: Final = 1e-300


class ErrorMoments(NamedTuple):
    """Mean and variance of the mean square error over the poses."""

    mean: float
    variance: float

    def quantile(self, level: float, away: float = 0.0) -> float:
        """Root of a quantile of the mean square error, with a known part of it added.

        The gamma distribution of equal moments stands for the true one (Satterthwaite).
        """
        if self.mean <= 0.0:
            return math.sqrt(away)
        shape = self.mean * self.mean / max(self.variance, SMALLEST)
        return math.sqrt(away + self.mean * float(gammaincinv(shape, level)) / shape)


def error_moments(weight: Array, mean: Array, variance: Array, away: Array,
                  size: NDArray[np.int64]) -> ErrorMoments:
    """Moments of the mean square error of the middle of a mixture.

    Within a component the units are taken as normal with the correlations of a multinomial
    distribution.

    Parameters
    ----------
    weight : (M,) array
        Of the components.
    mean, variance, away : (M, G) array
        Of the units: mean, variance, and mean less that of the mixture.
    size : (G,) array of int
        Poses of each unit, which share its error evenly.
    """
    each = 1.0 / (size * size.sum())  # a unit's square error to the poses' mean square
    squares = (variance + away * away) @ each
    odds = mean / np.maximum(1.0 - mean, SMALLEST)
    own = variance * each
    shared = np.square((own * odds).sum(axis=1)) - np.square(own * odds).sum(axis=1)
    scatter = 2.0 * (np.square(own).sum(axis=1) + np.maximum(shared, 0.0))
    expected = float(weight @ squares)
    return ErrorMoments(expected, float(weight @ (scatter + np.square(squares - expected))))


def error_quantile(probability: ArrayLike, drops: float, level: float) -> float:
    """Bound that the root mean square error of counted probabilities keeps.

    Parameters
    ----------
    probability : (P,) array
        As counted, or a little drawn in from 0 and 1.
    drops : float
        Settled ones, above 0.
    level : float
        Probability that the bound is kept, 0 < level < 1.
    """
    p = np.asarray(probability, dtype=np.float64)[None, :]
    one = np.ones(p.shape[1], dtype=np.int64)
    return error_moments(np.ones(1), p, p * (1.0 - p) / drops, np.zeros_like(p),
                         one).quantile(level)


def beta_like(mean: Array, variance: Array) -> tuple[Array, Array]:
    """Parameters (P,) of the Beta distributions of given moments; huge ones where certain."""
    total = mean * (1.0 - mean) / np.maximum(variance, SMALLEST) - 1.0
    return mean * total, (1.0 - mean) * total
