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

"""Error of an estimator with the noise of the simulation taken off: the paper's
metric.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ros_pose_stats.core.records import Array

from .bootstrap import body_bootstrap
from .simulated_poses import SimulatedPoses

INTERVAL_LEVEL: Final = 0.95
"""Level of the interval of an `Accuracy`."""


@dataclass(frozen=True)
class Accuracy:
    """Root mean square deviation of two sets of probabilities, and its parts (Eqs.
    1-4).

    All are fractions, not percent.

    Attributes
    ----------
    deviation : float
        sigma(e, s), Eq. 1.
    noise : float
        sigma(p, s), Eq. 3: the part that is due to the finite number of drops.
    error : float
        sigma(e, p), Eq. 4: the root of `error_variance`, 0 where that is negative.
    error_variance : float
        sigma²(e, s) - sigma²(p, s), squared fractions. Chance makes it negative for an
        estimator whose error is small beside the noise.
    standard_error : float
        Of `error`, from a bootstrap over bodies. Too small where `error` is near 0. NaN
        where there is only one body.
    low, high : float
        Percentile interval of `error` at the level 0.95, by the same bootstrap.
    largest : float
        Largest |e - s|, noise included: the last column of the paper's Table I.
    largest_at : int
        Index of the value that has it; the first of equals.
    values : int
        N.
    """

    deviation: float
    noise: float
    error: float
    error_variance: float
    standard_error: float
    low: float
    high: float
    largest: float
    largest_at: int
    values: int


def accuracy(
    estimate: ArrayLike,
    simulated: SimulatedPoses,
) -> Accuracy:
    """Error of an estimator, sigma(e, p), from its deviation from noisy simulations.

    Eq. 4 of the paper. It neglects the covariance C of Eq. 2: the estimator must not
    have been fitted to these very counts. The drops must be independent; drops that
    share their starts evenly have less noise than is taken off here.

    Parameters
    ----------
    estimate : (N,) array
        e, the estimator's probabilities as fractions, in the order of `simulated`;
        finite.
    simulated : SimulatedPoses
        Pool the restitutions for the paper's figures.
    """
    return _partition(
        simulated,
        np.asarray(estimate) - simulated.probability,
        simulated.noise_variance(),
    )


def sensitivity(
    first: SimulatedPoses,
    second: SimulatedPoses,
) -> Accuracy:
    """Deviation of two exact sets, sigma(p_a, p_b), from a simulation of each.

    Eq. 10 of the paper, for instance of two restitutions: both noises are taken off.
    `deviation` is sigma(s_a, s_b), `noise` the root of both noise variances together,
    `error` the deviation of the exact sets, `largest` that of the simulated ones.

    Parameters
    ----------
    first, second : SimulatedPoses
        Of the same poses in the same order, from drops that are independent of each
        other: equal starts in both would tie their noises, and too much would be taken
        off.
    """
    return _partition(
        first,
        first.probability - second.probability,
        first.noise_variance() + second.noise_variance(),
    )


def _partition(
    simulated: SimulatedPoses,
    difference: Array,
    noise: Array,
) -> Accuracy:
    terms = np.stack([np.square(difference), noise, np.ones_like(noise)], axis=1)
    spread = np.sqrt(
        np.maximum(body_bootstrap(simulated.body, terms, _error_variance), 0.0)
    )
    low, high = np.quantile(
        spread, [0.5 - INTERVAL_LEVEL / 2.0, 0.5 + INTERVAL_LEVEL / 2.0]
    )
    # Resamples of a single body are all alike, so the error is not known.
    factor = 1.0 if np.ptp(simulated.body) else math.nan
    squares = terms[:, 0].mean()
    noises = terms[:, 1].mean()
    worst = int(np.argmax(np.abs(difference)))
    return Accuracy(
        deviation=math.sqrt(squares),
        noise=math.sqrt(noises),
        error=math.sqrt(max(squares - noises, 0.0)),
        error_variance=float(squares - noises),
        standard_error=factor * float(spread.std(ddof=1)),
        low=factor * float(low),
        high=factor * float(high),
        largest=float(abs(difference[worst])),
        largest_at=worst,
        values=difference.size,
    )


def _error_variance(sums: Array) -> Array:
    return np.asarray((sums[0] - sums[1]) / sums[2])


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
    """Noise of so many drops of the bodies, estimated from these drops.

    Parameters
    ----------
    simulated : SimulatedPoses
        At least two settled drops of each body. Their number does not bias the result.
    drops : int
        n.
    """
    # noise_variance is s (1 - s) / (m - 1) for the m drops there are: p (1 - p) / m
    # unbiased.
    variance = simulated.noise_variance() * simulated.settled / drops
    terms = np.column_stack((variance, np.ones_like(variance)))
    spread = np.sqrt(
        body_bootstrap(simulated.body, terms, lambda sums: sums[0] / sums[1])
    )
    low, high = np.quantile(
        spread, (0.5 - INTERVAL_LEVEL / 2, 0.5 + INTERVAL_LEVEL / 2)
    ).tolist()
    return Noise(
        math.sqrt(float(variance.mean())), float(spread.std(ddof=1)), low, high
    )
