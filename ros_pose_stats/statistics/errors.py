"""Standard errors of counted probabilities, and the one number that sums them up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import RequestError

Array = NDArray[np.float64]


def standard_errors(counts: ArrayLike, settled: int) -> Array:
    """Binomial standard error of each pose's count / settled.

    sqrt(q (1 - q) / n) with q = (count + 1/2) / (n + K/2): the half keeps a pose that was
    never or always seen from looking certain. The only pose of a part (K = 1) has q = 1 and
    the error 0.

    `counts` (K,): drops that came to rest in each of all K poses, also those with 0; 0 <= count <=
    n; `settled`: n, the drops that came to rest at all. Returns (K,): as fractions, from 0 to 1/2;
    NaN where n = 0, for a single pose too. Raises RequestError if a count is below 0 or above
    `settled`.
    """
    counted = np.atleast_1d(np.asarray(counts, dtype=float))
    if counted.size and not (counted.min() >= 0.0 and counted.max() <= settled):
        raise RequestError(f"counts from 0 to {settled}, the settled drops",
                           f"{counted.min():g} to {counted.max():g}",
                           "count the settled drops alone")
    if settled == 0:
        return np.full(counted.shape, math.nan)
    return np.sqrt(error_variances(counted, settled, counted.size))


def error_variances(counts: ArrayLike, settled: ArrayLike, poses: ArrayLike) -> Array:
    """Squares of `standard_errors`, for poses of many parts at once.

    `counts, settled, poses`: of each pose: its count, the settled drops of its part, above 0, and
    the part's poses.
    """
    total = np.asarray(settled, dtype=float)
    q = (np.asarray(counts, dtype=float) + 0.5) / (total + 0.5 * np.asarray(poses, dtype=float))
    return np.asarray(q * (1.0 - q) / total)


def expected_error(errors: ArrayLike) -> float:
    """Root mean square over the poses of their standard errors (K,), as a fraction.

    NaN where one of them is, or without poses.
    """
    values = np.asarray(errors, dtype=float)
    return math.sqrt(float(np.mean(values * values))) if values.size else math.nan


def root_mean_square(differences: ArrayLike) -> float:
    """Root mean square over the poses: the paper's measure of two sets of probabilities (Eq. 1).

    NaN where one of them is, or without poses.
    """
    return expected_error(differences)
