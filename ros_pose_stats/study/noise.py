"""How much a number of drops scatters: the simulation's own error."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .errors.bootstrap import body_bootstrap
from .errors.partition import INTERVAL_LEVEL
from .errors.simulated_poses import SimulatedPoses


class Noise(NamedTuple):
    """sigma(p, s) of a number of independent drops, Eq. 3, as a fraction.

    Attributes
    ----------
    error : float
    standard_error : float
        By a bootstrap over bodies; 0 for a single body.
    low, high : float
        Percentile interval at the level 0.95, by the same.
    """

    error: float
    standard_error: float
    low: float
    high: float


def noise_of(simulated: SimulatedPoses, drops: int) -> Noise:
    """Noise of so many drops of the bodies whose probabilities these drops tell.

    Parameters
    ----------
    simulated : SimulatedPoses
        Two settled drops of each at least. How many there are does not bias the result.
    drops : int
        n.
    """
    # noise_variance is s (1 - s) / (m - 1) for the m drops there are: p (1 - p) / m unbiased.
    variance = simulated.noise_variance(unbiased=True) * simulated.settled / drops
    terms = np.column_stack((variance, np.ones_like(variance)))
    spread = np.sqrt(body_bootstrap(simulated.body, terms, lambda sums: sums[0] / sums[1]))
    low, high = np.quantile(spread, (0.5 - INTERVAL_LEVEL / 2, 0.5 + INTERVAL_LEVEL / 2)).tolist()
    return Noise(math.sqrt(float(variance.mean())), float(spread.std(ddof=1)), low, high)
