"""Test of the standard errors and intervals of one simulation by an independent second
one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.statistics.errors import (
    DEFAULT_LEVEL,
    error_variances,
    jeffreys_interval,
)

from .bootstrap import body_bootstrap
from .simulated_poses import SimulatedPoses

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Calibration:
    """Agreement of two independent simulations of the same poses, beside the expected
    one.

    The expected figures hold where both runs count independent drops of the same
    probabilities. They are exact, given the drops that both runs together counted in a
    pose: then the first run's share of them is hypergeometric, whatever the
    probability.

    Attributes
    ----------
    z_rms : float
        Root mean square of z = (s1 - s2) / sqrt(se1² + se2²). Errors that are too small make
        it larger than expected.
    expected_z_rms : float
        Near 1. Poses of a few counts raise it, as the standard error is small whenever the
        count is; poses rarer than that, mostly with z near 0, lower it.
    z_rms_error : float
        Standard error of `z_rms`, from a bootstrap over bodies; NaN for a single body.
    coverage : float
        Share of the values whose interval from the first run holds the second's proportion.
    expected_coverage : float
        Below the level by the noise of the second run, and above it where many poses are
        rare or certain.
    coverage_error : float
        Standard error of `coverage`, likewise.
    values : int
        N.
    certain : int
        Poses that no drop or every drop of both runs came to. They count as z = 0 and as held, in
        the expected figures too, so that they dilute a misfit but do not make one.
    """

    z_rms: float
    expected_z_rms: float
    z_rms_error: float
    coverage: float
    expected_coverage: float
    coverage_error: float
    values: int
    certain: int


def calibration(
    first: SimulatedPoses,
    second: SimulatedPoses,
    level: float = DEFAULT_LEVEL,
) -> Calibration:
    """Test `standard_errors` and `jeffreys_interval` of a run on an independent second
    one.

    Parameters
    ----------
    first, second : SimulatedPoses
        Of the same poses in the same order. All poses of a body at one restitution, also those
        never seen, must follow each other: the standard error depends on how many they are.
        The first may be small, the second should be larger.
    level : float
        Of the interval; 0 < level < 1.

    Raises
    ------
    RequestError
        If the bodies differ, the counts of a body do not add up to its settled drops, or the
        level is out of its range.
    """
    if not np.array_equal(first.body, second.body):
        raise RequestError(
            "two simulations of the same poses in the same order",
            f"{first.body.size} and {second.body.size} values of unlike bodies",
            "number the bodies of both alike",
        )
    poses = _poses(first)
    _poses(second)
    pair = outcomes(
        first.count, first.settled, second.count, second.settled, poses, level
    )
    foreseen = means_of_equal_chances(first, second, poses, level)
    terms = np.stack([*pair, np.ones_like(pair[0])], axis=1)
    resampled = [
        body_bootstrap(first.body, terms, statistic) for statistic in (_z_rms, _share)
    ]
    factor = 1.0 if np.ptp(first.body) else math.nan
    total = first.count + second.count
    return Calibration(
        z_rms=math.sqrt(pair[0].mean()),
        expected_z_rms=math.sqrt(foreseen[0].mean()),
        z_rms_error=factor * float(resampled[0].std(ddof=1)),
        coverage=float(pair[1].mean()),
        expected_coverage=float(foreseen[1].mean()),
        coverage_error=factor * float(resampled[1].std(ddof=1)),
        values=total.size,
        certain=int(
            np.count_nonzero((total == 0) | (total == first.settled + second.settled))
        ),
    )


def _poses(simulated: SimulatedPoses) -> Index:
    """K of the body at its restitution, for each value (N,)."""
    starts = np.flatnonzero(np.diff(simulated.body, prepend=-1))
    poses = np.diff(starts, append=simulated.body.size)
    drops = np.add.reduceat(simulated.count, starts).repeat(poses)
    wrong = drops != simulated.settled
    if wrong.any():
        raise RequestError(
            "all poses of a body at one restitution in a row, their counts adding "
            "up to its settled drops",
            f"{drops[wrong][0]} of {simulated.settled[wrong][0]} for body "
            f"{simulated.body[wrong][0]}",
            "list the poses never seen too",
        )
    return poses.repeat(poses)


def _z_rms(sums: Array) -> Array:
    return np.asarray(np.sqrt(sums[0] / sums[2]))


def _share(sums: Array) -> Array:
    return np.asarray(sums[1] / sums[2])


_CELLS: Final = 1 << 18
"""Most possible counts in memory at a time."""

_REACH: Final = 9.0
"""Standard deviations to each side of the mean; what lies beyond is below 1e-12."""


def outcomes(
    first: Index,
    first_settled: Index,
    second: Index,
    second_settled: Index,
    poses: Index,
    level: float,
) -> tuple[Array, Array]:
    """z², and whether the interval of the first count holds the second's proportion.

    z = (s1 - s2) / sqrt(se1² + se2²), with the standard errors that `standard_errors`
    gives and the interval of `jeffreys_interval`. z = 0 for the only pose of a body,
    which has no error.

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
    proportion = second / second_settled
    variance = error_variances(first, first_settled, poses) + error_variances(
        second, second_settled, poses
    )
    squares = np.square(first / first_settled - proportion)
    low, high = _intervals(first, first_settled, level)
    return (
        np.divide(squares, variance, out=np.zeros_like(squares), where=variance > 0.0),
        ((low <= proportion) & (proportion <= high)).astype(np.float64),
    )


def means_of_equal_chances(
    first: SimulatedPoses, second: SimulatedPoses, poses: Index, level: float
) -> tuple[Array, Array]:
    """Means of what `outcomes` gives, over all ways to share the total between the
    runs.

    If both runs have the same probability, the first count is hypergeometric given the
    total: the argument of Fisher's exact test (Lehmann and Romano, "Testing Statistical
    Hypotheses", section 4.5). The time grows as the root of the first run's drops.

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
    width = (
        int(np.minimum(top - begin, np.ceil(2.0 * _REACH * deviation) + 40.0).max()) + 1
    )
    means = np.empty((2, total.size))
    step = max(1, _CELLS // width)
    for start in range(0, total.size, step):
        rows = np.s_[start : start + step, None]
        count = np.minimum(begin[rows] + np.arange(width), top[rows])
        drops = first.settled[rows], second.settled[rows]
        weight = _weights(count, total[rows] - count, *drops)
        # Beyond the end of the row its last count is repeated.
        weight[:, 1:][np.diff(count, axis=1) == 0] = 0.0
        weight /= weight.sum(axis=1, keepdims=True)
        n1, n2, k = (
            np.broadcast_to(column, count.shape) for column in (*drops, poses[rows])
        )
        pair = outcomes(count, n1, total[rows] - count, n2, k, level)
        means[:, start : start + step] = [
            (weight * column).sum(axis=1) for column in pair
        ]
    return means[0], means[1]


def _weights(
    first: Index, second: Index, first_settled: Index, second_settled: Index
) -> Array:
    """Hypergeometric probabilities of each row, but for a factor."""
    logs = -(
        gammaln(first + 1)
        + gammaln(first_settled - first + 1)
        + gammaln(second + 1)
        + gammaln(second_settled - second + 1)
    )
    return np.asarray(np.exp(logs - logs.max(axis=1, keepdims=True)))


def _intervals(count: Index, settled: Index, level: float) -> tuple[Array, Array]:
    """Bounds by `jeffreys_interval`, each distinct one computed once."""
    base = int(settled.max()) + 1
    distinct, index = np.unique(settled * base + count, return_inverse=True)
    low, high = jeffreys_interval(distinct % base, distinct // base, level)
    index = index.reshape(count.shape)
    return low[index], high[index]
