"""Pose probabilities as they are known after drops: means, errors, intervals, a bound."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..intervals import DEFAULT_LEVEL
from .bound import SquareError, beta_like, square_error
from .shortest import shortest_interval

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Posterior:
    """Distribution of the pose probabilities of one part.

    Attributes
    ----------
    probability : (P,) array
        Means; they sum to 1, and poses of one group have equal ones.
    standard_error : (P,) array
        Standard deviations.
    """

    probability: Array
    standard_error: Array
    _unit: Index
    _size: Index
    _error: SquareError

    @classmethod
    def mixed(cls, weight: Array, mean: Array, variance: Array, unit: Index,
              size: Index) -> Posterior:
        """From the moments of the units at each of some strengths.

        Parameters
        ----------
        weight : (M,) array
            Of the strengths, summing to 1.
        mean, variance : (M, G) array
        unit : (P,) array of int
            The unit that each pose belongs to.
        size : (G,) array of int
            Poses of each unit.
        """
        # The weights' sum is rounded; it shows where all agree, as on a pose that is the only one.
        middle = np.where(np.ptp(mean, axis=0) == 0.0, mean[0], weight @ mean)
        away = mean - middle
        spread = weight @ (variance + away * away)
        share = 1.0 / size
        return cls((middle * share)[unit], (np.sqrt(spread) * share)[unit], unit, size,
                   square_error(weight, mean, variance, away, size))

    @property
    def expected_error(self) -> float:
        """Root mean square over the poses of their standard errors, as a fraction."""
        return math.sqrt(self._error.expected)

    def error_quantile(self, level: float = DEFAULT_LEVEL) -> float:
        """Bound that the root mean square error over the poses keeps with this probability.

        Parameters
        ----------
        level : float
            0 < level < 1.
        """
        return math.sqrt(self._error.quantile(level))

    def interval(self, level: float = DEFAULT_LEVEL) -> tuple[Array, Array]:
        """Bounds (P,), each pair the shortest that holds this share of a pose's distribution.

        A pose that is hardly ever met has a lower bound of 0. The distribution of a pose is
        taken as the Beta distribution of its mean and standard deviation.
        """
        whole = self._size[self._unit]
        unsure = self.standard_error > 0.0
        low, high = self.probability.copy(), self.probability.copy()
        a, b = beta_like((self.probability * whole)[unsure],
                         np.square(self.standard_error * whole)[unsure])
        found = shortest_interval(a, b, level)
        low[unsure], high[unsure] = (bound / whole[unsure] for bound in found)
        return low, high
