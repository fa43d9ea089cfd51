"""What two simulations of the same probabilities should find, given what they found together."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from ...statistics.errors import error_variances
from ...statistics.intervals import jeffreys_interval
from .simulated_poses import SimulatedPoses

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_CELLS: Final = 1 << 18
"""Possible counts held at a time."""

_REACH: Final = 9.0
"""Standard deviations to each side of the mean; what lies beyond is below 1e-12."""


def outcomes(first: Index, first_settled: Index, second: Index, second_settled: Index,
             poses: Index, level: float) -> tuple[Array, Array]:
    """z², and whether the interval of the first count holds the second's proportion.

    z = (s1 - s2) / sqrt(se1² + se2²), with the standard errors that `standard_errors` gives and
    the interval of `jeffreys_interval`. z = 0 for the only pose of a body, which has no error.

    Parameters
    ----------
    first, first_settled, second, second_settled, poses : arrays of one shape
        Counts, settled drops and the number of poses K of the body.
    level : float

    Returns
    -------
    squares, held : arrays of that shape
        `held` is 0 or 1.
    """
    other = second / second_settled
    variance = (error_variances(first, first_settled, poses)
                + error_variances(second, second_settled, poses))
    squares = np.square(first / first_settled - other)
    low, high = _intervals(first, first_settled, level)
    return (np.divide(squares, variance, out=np.zeros_like(squares), where=variance > 0.0),
            ((low <= other) & (other <= high)).astype(np.float64))


def means_of_equal_chances(first: SimulatedPoses, second: SimulatedPoses, poses: Index,
                           level: float) -> tuple[Array, Array]:
    """Means of what `outcomes` gives, over all ways to share the total between the runs.

    If both runs have the same probability, the first count is hypergeometric given the total:
    the argument of Fisher's exact test (Lehmann and Romano, "Testing Statistical Hypotheses",
    section 4.5). The time grows as the root of the first run's drops.

    Returns
    -------
    squares, held : (N,) arrays
    """
    total = first.count + second.count
    share = total / (first.settled + second.settled)
    deviation = np.sqrt(first.settled * share * (1.0 - share))
    begin = np.floor(first.settled * share - _REACH * deviation - 20.0).astype(np.int64)
    begin = np.maximum(np.maximum(begin, total - second.settled), 0)
    top = np.minimum(first.settled, total)
    width = int(np.minimum(top - begin, np.ceil(2.0 * _REACH * deviation) + 40.0).max()) + 1
    found = np.empty((2, total.size))
    step = max(1, _CELLS // width)
    for at in range(0, total.size, step):
        rows = np.s_[at:at + step, None]
        count = np.minimum(begin[rows] + np.arange(width), top[rows])
        drops = first.settled[rows], second.settled[rows]
        weight = _weights(count, total[rows] - count, *drops)
        # Beyond the end of the row its last count is repeated.
        weight[:, 1:][np.diff(count, axis=1) == 0] = 0.0
        weight /= weight.sum(axis=1, keepdims=True)
        n1, n2, k = (np.broadcast_to(one, count.shape) for one in (*drops, poses[rows]))
        pair = outcomes(count, n1, total[rows] - count, n2, k, level)
        found[:, at:at + step] = [(weight * one).sum(axis=1) for one in pair]
    return found[0], found[1]


def _weights(first: Index, second: Index, first_settled: Index, second_settled: Index) -> Array:
    """Hypergeometric probabilities of each row, but for a factor."""
    logs = -(gammaln(first + 1) + gammaln(first_settled - first + 1)
             + gammaln(second + 1) + gammaln(second_settled - second + 1))
    return np.asarray(np.exp(logs - logs.max(axis=1, keepdims=True)))


def _intervals(count: Index, settled: Index, level: float) -> tuple[Array, Array]:
    """Bounds by `jeffreys_interval`, each distinct one computed once."""
    base = int(settled.max()) + 1
    distinct, at = np.unique(settled * base + count, return_inverse=True)
    low, high = jeffreys_interval(distinct % base, distinct // base, level)
    at = at.reshape(count.shape)
    return low[at], high[at]
