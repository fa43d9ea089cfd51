"""Counts whose probabilities scatter themselves: the Dirichlet-multinomial distribution."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln

LEAST_DISPERSION = 1e-9
"""Below it the counts are multinomial to all digits that matter."""

LEAST_SHARE = 1e-12
"""A share that was never met may still occur."""


def log_likelihood(counts: ArrayLike, shares: ArrayLike,
                   dispersion: ArrayLike) -> NDArray[np.float64]:
    """Logarithm of the probability of counts, less what depends on the counts alone.

    The shares p that the counts follow scatter around those expected with the variance
    p (1 - p) × dispersion; at dispersion 0 the counts are multinomial.

    `counts` (G,): at least 0; `shares` (..., G): expected, summing to 1; `dispersion` (...): 0 to
    below 1. Returns (...).
    """
    of = np.asarray(counts, dtype=np.float64)
    expected = np.maximum(np.asarray(shares, dtype=np.float64), LEAST_SHARE)
    spread = np.asarray(dispersion, dtype=np.float64)
    # Below this dispersion the differences of log-gammas lose more digits than they gain.
    total = 1.0 / np.maximum(spread, LEAST_DISPERSION) - 1.0
    alpha = expected * total[..., None]
    met = of > 0.0
    found = (gammaln(alpha[..., met] + of[met]) - gammaln(alpha[..., met])).sum(axis=-1)
    found -= gammaln(total + of.sum()) - gammaln(total)
    plain = (of[met] * np.log(expected[..., met])).sum(axis=-1)
    return np.asarray(np.where(spread <= LEAST_DISPERSION, plain, found))
