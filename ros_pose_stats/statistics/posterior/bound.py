"""How large the root mean square error over the poses may be."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammainc

Array = NDArray[np.float64]

SMALLEST: Final = 1e-300


HALVINGS: Final = 16
"""Of the logarithm of the bound, from a factor of `FARTHEST` each way: to a hundredth of a per
cent."""
FARTHEST: Final = 8.0


class SquareError(NamedTuple):
    """Distribution of the mean square error over the poses: a mixture of gamma distributions.

    Each has the moments of its component of the posterior (Satterthwaite).

    Attributes
    ----------
    weight, mean, variance : (M,) array
    """

    weight: Array
    mean: Array
    variance: Array

    @property
    def expected(self) -> float:
        """Its mean."""
        return float(self.weight @ self.mean)

    def quantile(self, level: float) -> float:
        """Below which it is with this probability."""
        expected = self.expected
        if expected <= SMALLEST:
            return 0.0
        shape = self.mean * self.mean / np.maximum(self.variance, SMALLEST)
        scaled = shape / np.maximum(self.mean, SMALLEST)
        least, most = -math.log(FARTHEST), math.log(FARTHEST)
        for _ in range(HALVINGS):
            middle = 0.5 * (least + most)
            below = self.weight @ gammainc(shape, scaled * expected * math.exp(middle))
            least, most = (middle, most) if below < level else (least, middle)
        return expected * math.exp(0.5 * (least + most))


def square_error(weight: Array, mean: Array, variance: Array, away: Array,
                 size: NDArray[np.int64]) -> SquareError:
    """Distribution of the mean square error of the middle of a mixture.

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
    return SquareError(weight, squares, scatter)


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
    found = square_error(np.ones(1), p, p * (1.0 - p) / drops, np.zeros_like(p), one)
    return math.sqrt(found.quantile(level))


def beta_like(mean: Array, variance: Array) -> tuple[Array, Array]:
    """Parameters (P,) of the Beta distributions of given moments; huge ones where certain."""
    total = mean * (1.0 - mean) / np.maximum(variance, SMALLEST) - 1.0
    return mean * total, (1.0 - mean) * total
