# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""How sure probabilities are: standard errors, intervals, and bounds that errors keep.

A target error is kept where the root mean square error over the poses is within it with
90 % confidence. A run stops at the first look that finds the bound low enough, by luck
at times; so a little more than 90 % is asked for wherever a run may stop
(`CHECKPOINT_LEVEL`).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import betaincinv

from ...base.errors import RequestError
from ..records import Array, Index


def standard_errors(counts: ArrayLike, settled_drops: int) -> Array:
    """Binomial standard error (K,) of each pose's share of the settled drops.

    It is NaN where nothing settled.

    sqrt(q (1 - q) / n) with q = (count + 1/2) / (n + K/2): the half keeps a pose that
    was never or always seen from looking certain. The only pose of a part has q = 1 and
    the error 0.
    """
    count = np.atleast_1d(np.asarray(counts, dtype=float))
    if count.size and not (count.min() >= 0.0 and count.max() <= settled_drops):
        raise RequestError(
            f"counts from 0 to {settled_drops}, the settled drops",
            f"{count.min():g} to {count.max():g}",
            "count the settled drops alone",
        )
    if settled_drops == 0:
        return np.full(count.shape, math.nan)
    return np.sqrt(error_variances(count, settled_drops, count.size))


def error_variances(
    counts: ArrayLike, settled_drops: ArrayLike, pose_counts: ArrayLike
) -> Array:
    """Squares of `standard_errors`, for poses of many parts at once."""
    drops = np.asarray(settled_drops, dtype=float)
    q = (np.asarray(counts, dtype=float) + 0.5) / (
        drops + 0.5 * np.asarray(pose_counts, dtype=float)
    )
    return np.asarray(q * (1.0 - q) / drops)


def root_mean_square(errors: ArrayLike) -> float:
    """Root mean square over the poses (K,), Eq. 1 of the paper; NaN without poses."""
    values = np.asarray(errors, dtype=float)
    return math.sqrt(float(np.mean(values * values))) if values.size else math.nan


DEFAULT_LEVEL = 0.9
"""Chance that `probability_low` and `probability_high` of the contract enclose the
truth."""


def jeffreys_interval(
    count: ArrayLike, total: ArrayLike, level: float = DEFAULT_LEVEL
) -> tuple[Array, Array]:
    """Equal-tailed Jeffreys interval of a binomial probability.

    The quantiles of Beta(count + 1/2, total - count + 1/2), with 0 as the lower bound
    where nothing was counted and 1 as the upper bound where everything was: Brown, Cai
    and DasGupta, "Interval estimation for a binomial proportion", Statistical Science
    16 (2001), section 4.1. `total` need not be whole: an effective number of drops is.
    """
    successes, trials = np.broadcast_arrays(
        np.asarray(count, float), np.asarray(total, float)
    )
    if not 0.0 < level < 1.0:
        raise RequestError(
            "a level between 0 and 1", f"{level}", "0.9 is the contract's"
        )
    is_impossible = ~((successes >= 0.0) & (successes <= trials) & np.isfinite(trials))
    if is_impossible.any():
        raise RequestError(
            "counts from 0 to their total",
            f"{successes[is_impossible][0]:g} of {trials[is_impossible][0]:g}",
            "divide both by the same variance factor",
        )
    alpha = successes + 0.5
    beta = trials - successes + 0.5
    tail = (1.0 - level) / 2.0
    low = np.where(successes == 0.0, 0.0, betaincinv(alpha, beta, tail))
    high = np.where(successes == trials, 1.0, betaincinv(alpha, beta, 1.0 - tail))
    return low, high


WIDEST_DEVIATION = 1e6
"""A standard deviation beyond which nothing is known either; far outside of what was
fitted it may be infinite."""

BOUND_NODES = np.geomspace(0.01, 12.0, 64)
"""Where a bound is looked for, in the largest standard deviation; between them it is
straight."""


def largest_error(
    deviation: ArrayLike,
    level: float,
    *,
    weight: ArrayLike = (1.0,),
    offset: ArrayLike = 0.0,
    size: ArrayLike = 1,
) -> float:
    """Bound that no pose's error exceeds with this probability, a fraction.

    Errors are normal in each of M cases of a `weight` (M,), off by `offset` (M, G); a
    unit's is shared by its `size` (G,) poses. Of G errors with a sum G - 1 are free, so
    the chances that each is within the bound are multiplied, but for the largest: exact
    for two units, and for many.
    """
    deviations = np.atleast_2d(deviation)[None]
    return largest_errors(deviations, level, weight=weight, offset=offset, size=size)[0]


def largest_errors(
    deviation: Array,
    level: float,
    *,
    weight: ArrayLike = (1.0,),
    offset: ArrayLike = 0.0,
    size: ArrayLike = 1,
) -> list[float]:
    """The same of several estimates, from their deviations (N, M, G)."""
    # numba takes longer to load than all else, and intervals do not need it.
    from ..kernels.error_bounds import bound_errors

    share = 1.0 / np.asarray(size, dtype=np.float64)
    spread = np.minimum(deviation, WIDEST_DEVIATION) * share
    center = np.broadcast_to(np.abs(np.asarray(offset) * share), spread.shape)
    widest = (center + spread).max(axis=(1, 2), initial=0.0)
    bounds = bound_errors(
        BOUND_NODES * widest[:, None],
        np.ascontiguousarray(spread),
        np.ascontiguousarray(center),
        np.asarray(weight, dtype=np.float64),
        level,
    )
    return [min(bound, 1.0) for bound in bounds.tolist()]


CHECKPOINT_LEVEL = 0.92  # confidence asked for at each look, so that 90 % are left
CHECKPOINT_DEVIATE = 1.4050715603096329
"""The normal deviate below which a share of `CHECKPOINT_LEVEL` lies."""


class Judgement(NamedTuple):
    """What drops so far are worth."""

    # root mean square of the poses' standard errors; NaN before a drop has settled
    expected_error: float
    bound: float  # of that error; infinite before a drop has settled


def judge_counts(counts: Index) -> Judgement:
    """Judge counts (K,) of independent drops by themselves."""
    return Judgement(
        root_mean_square(standard_errors(counts, int(counts.sum()))),
        counted_bound(counts),
    )


def counted_bound(counts: Index) -> float:
    """Bound that the error of counts keeps, a fraction; infinite without drops.

    The squared error of shares is a sum of squares of normal variables, taken as a
    gamma distribution with its mean and variance (Satterthwaite), whose quantile is
    that of Wilson and Hilferty: 1.3 % low in the error for two poses, nearer for more.
    There are only products and roots in it, so that runs end alike on all machines.
    """
    settled_drops = int(counts.sum())
    if not settled_drops:
        return math.inf
    q = (counts + 0.5) / (settled_drops + 0.5 * counts.size)
    mean = float((q * (1.0 - q)).sum())
    if not mean > 0.0:  # the only pose
        return 0.0
    squares = float((q * q).sum())
    cubes = float((q * q * q).sum())
    variance = 2.0 * (squares - 2.0 * cubes + squares * squares)
    spread = variance / (9.0 * mean * mean)
    root = 1.0 - spread + CHECKPOINT_DEVIATE * math.sqrt(spread)
    return math.sqrt(mean / (settled_drops * counts.size) * root * root * root)
