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

"""Pose probabilities after drops: means, errors, intervals, a bound."""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import betainc, gammainc

from ..records import Array, Index
from ..records.shares import Shares
from .errors import DEFAULT_LEVEL, largest_error

HALVINGS = 16  # of the logarithm of the bound, from a factor of `FARTHEST` each way
LARGEST_FACTOR = 8.0


class SquareError(NamedTuple):
    """Distribution of the mean square error of the means over the poses.

    A mixture of gamma distributions that have the moments of the posterior's
    components, in which the units are normal with the correlations of a multinomial
    distribution (Satterthwaite).
    """

    weight: Array  # (M,)
    mean: Array
    variance: Array

    @property
    def expected(self) -> float:
        """Its mean."""
        return float(self.weight @ self.mean)

    def quantile(self, level: float) -> float:
        """Below which it is with this probability."""
        expected = self.expected
        if expected <= TINY:
            return 0.0
        shape = self.mean * self.mean / np.maximum(self.variance, TINY)
        rate = shape / np.maximum(self.mean, TINY)
        low_logarithm = -math.log(LARGEST_FACTOR)
        high_logarithm = math.log(LARGEST_FACTOR)
        for _ in range(HALVINGS):
            logarithm = 0.5 * (low_logarithm + high_logarithm)
            factor = math.exp(logarithm)
            if self.weight @ gammainc(shape, rate * expected * factor) < level:
                low_logarithm = logarithm
            else:
                high_logarithm = logarithm
        return expected * math.exp(0.5 * (low_logarithm + high_logarithm))


WIDEST_SHARE = 1.0 - 1e-9  # variance of a unit over that of a single drop, at most
NARROWEST_SHARE = 1e-12  # the same at least, where the unit is not certain


class Kinds(NamedTuple):
    """The units' distributions, each a mixture of K."""

    share: Array  # (K, G)
    mean: Array
    variance: Array


class Posterior(NamedTuple):
    """Distribution of the pose probabilities of one part."""

    probability: Array  # (P,); of sum 1, equal for poses of one unit
    standard_error: Array  # (P,); root mean square distances from these
    unit: Index  # (P,); the unit that each pose belongs to
    size: Index  # (G,); poses of each unit, which share its error evenly
    error: SquareError  # over the poses
    row_error: SquareError  # over the rows of a table: shares of poses taken together
    variance: Array  # (M, G); of the units at each of M strengths
    offset: Array  # (M, G); mean less the answer
    kinds: Kinds

    @classmethod
    def from_moments(
        cls,
        weight: Array,
        answer_weight: Array,
        mean: Array,
        variance: Array,
        unit: Index,
        row: Index,
        kinds: Kinds,
    ) -> "Posterior":
        """Take the units' moments (M, G) at some strengths, and their weights (M,).

        The answer is the mean by its own weights; errors are distances from it, by
        `weight`. `unit`, `row` (P,): of each pose; poses of one row are of one unit.
        `kinds`: the same moments, parted by which kind of estimate holds rather than by
        strength.
        """
        size = np.bincount(unit)
        # The weights' sum is rounded; it shows where all agree, as on a pose that is
        # the only one.
        center = np.where(np.ptp(mean, axis=0) == 0.0, mean[0], answer_weight @ mean)
        offset = mean - center
        spread = weight @ (variance + offset * offset)
        share = 1.0 / size
        # What each row has of its unit.
        first_pose = np.unique(row, return_index=True)[1]
        row_unit = unit[first_pose]
        row_share = np.bincount(row) * share[row_unit]
        row_square = np.bincount(row_unit, row_share * row_share)

        def square_error(unit_factor: Array) -> SquareError:
            """Of values of which the units' square errors are a weighed sum."""
            unit_square = variance * unit_factor
            odds = unit_square * (mean / np.maximum(1.0 - mean, TINY))
            covariance = np.square(odds.sum(axis=1)) - np.square(odds).sum(axis=1)
            return SquareError(
                weight,
                (variance + offset * offset) @ unit_factor,
                2.0
                * (np.square(unit_square).sum(axis=1) + np.maximum(covariance, 0.0)),
            )

        return cls(
            (center * share)[unit],
            (np.sqrt(spread) * share)[unit],
            unit,
            size,
            square_error(share / size.sum()),
            square_error(row_square / row_unit.size),
            variance,
            offset,
            kinds,
        )

    @property
    def expected_error(self) -> float:
        """Root mean square over the poses of their standard errors, as a fraction."""
        return math.sqrt(self.error.expected)

    def shares(self, counts: Index) -> Shares:
        """The probabilities with their errors, beside what was counted (P,)."""
        return Shares(
            self.probability,
            *self.interval(),
            self.standard_error,
            counts,
            self.expected_error,
            self.largest_error(),
        )

    def error_quantile(self, level: float = DEFAULT_LEVEL) -> float:
        """Bound of the root mean square errors, over poses and rows, at a level."""
        return math.sqrt(
            max(self.error.quantile(level), self.row_error.quantile(level))
        )

    def largest_error(self) -> float:
        """Bound that all poses' errors keep together with 90 % confidence."""
        return largest_error(
            np.sqrt(self.variance),
            DEFAULT_LEVEL,
            weight=self.error.weight,
            offset=self.offset,
            size=self.size,
        )

    def interval(self, level: float = DEFAULT_LEVEL) -> tuple[Array, Array]:
        """Bounds (P,): the shortest interval that holds this share of a distribution.

        A pose that is hardly ever met has a lower bound of 0; of a distribution as
        skewed as that the mean may lie above both bounds.
        """
        share, mean, variance = self.kinds
        single_drop = mean * (1.0 - mean)
        spread = np.minimum(variance, WIDEST_SHARE * single_drop)
        is_unsure = (share * spread).sum(axis=0) > 0.0
        low = (share * mean).sum(axis=0)
        high = low.copy()
        if is_unsure.any():
            low[is_unsure], high[is_unsure] = shortest_interval(
                share[:, is_unsure],
                mean[:, is_unsure],
                np.maximum(
                    spread[:, is_unsure], NARROWEST_SHARE * single_drop[:, is_unsure]
                ),
                level,
            )
        return (low / self.size)[self.unit], (high / self.size)[self.unit]


TINY = 1e-300

MEAN_NODES = np.linspace(-4.0, 7.0, 67)
"""Where the distribution is looked at: standard deviations from the mean of each
component."""

RARE_NODES = 10.0 ** np.arange(-8.0, 0.0)
"""And means of each component, for a rare pose whose density rises without bound
towards 0."""

LEAST_ALPHA = 1.0
"""First Beta parameter of a pose that has never come up, at least: drops alone leave
such a pose an interval that ends where it would have come up with that confidence. With
less the interval shrinks towards 0, whatever the number of drops, and misses poses that
came up by chance not once."""

CELL_HALVINGS = 16  # of the cell in which the upper end lies


def shortest_interval(
    weight: Array, mean: Array, variance: Array, level: float
) -> tuple[Array, Array]:
    """Bounds (P,) of the shortest interval of a mixture (K, P).

    `weight` sums to 1 over K; 0 < mean < 1, 0 < variance < mean (1 - mean), 0 < level <
    1. The length is within a thousandth of the least one, a few per cent where a sharp
    component stands beside a broad one.
    """
    is_mirrored = (weight * mean).sum(axis=0) > 0.5
    low, high = _lower_half_interval(
        weight, np.where(is_mirrored, 1.0 - mean, mean), variance, level
    )
    return (
        np.where(is_mirrored, 1.0 - high, low),
        np.where(is_mirrored, 1.0 - low, high),
    )


def _lower_half_interval(
    weight: Array, mean: Array, variance: Array, level: float
) -> tuple[Array, Array]:
    """The same for means of at most 1 / 2, so that only 0 may bind."""
    # Parameters of the Beta distributions of these moments.
    total = mean * (1.0 - mean) / np.maximum(variance, TINY) - 1.0
    alpha = np.maximum(mean * total, LEAST_ALPHA)
    beta = (1.0 - mean) * total

    nodes_around_mean = mean[..., None] + np.sqrt(variance)[..., None] * MEAN_NODES
    nodes_near_zero = mean[..., None] * RARE_NODES
    nodes = np.concatenate((nodes_around_mean, nodes_near_zero), axis=2)
    count = mean.shape[1]
    nodes = nodes.swapaxes(0, 1).reshape(count, -1)
    nodes = np.column_stack((np.zeros(count), nodes, np.ones(count)))
    nodes = np.sort(np.clip(nodes, 0.0, 1.0))
    mass = np.einsum(
        "kp,kpn->pn", weight, betainc(alpha[..., None], beta[..., None], nodes)
    )
    low = np.array(
        [_interval_begin(x, y, level) for x, y in zip(nodes, mass, strict=True)]
    )
    upper_mass = level + _cumulative_mass(weight, alpha, beta, low)
    cell = np.sum(mass < upper_mass[:, None], axis=1, keepdims=True).clip(
        1, nodes.shape[1] - 1
    )
    cell_begin = np.take_along_axis(nodes, cell - 1, axis=1)[:, 0]
    cell_end = np.take_along_axis(nodes, cell, axis=1)[:, 0]
    for _ in range(CELL_HALVINGS):
        middle = 0.5 * (cell_begin + cell_end)
        is_short = _cumulative_mass(weight, alpha, beta, middle) < upper_mass
        cell_begin = np.where(is_short, middle, cell_begin)
        cell_end = np.where(is_short, cell_end, middle)
    return low, np.where(upper_mass < 1.0, cell_end, 1.0)


def _interval_begin(nodes: Array, mass: Array, level: float) -> float:
    """Where the shortest interval begins, by a parabola through three in a row."""
    begin = nodes[mass <= mass[-1] - level]
    ends = np.interp(mass[: begin.size] + level, mass, nodes)
    length = ends - begin
    shortest = int(np.argmin(length))
    if not 0 < shortest < begin.size - 1 or begin[shortest - 1] == begin[shortest]:
        return float(begin[shortest])
    x = begin[shortest - 1 : shortest + 2]
    y = length[shortest - 1 : shortest + 2]
    left_slope = (y[0] - y[1]) / (x[1] - x[0])
    right_slope = (y[2] - y[1]) / max(x[2] - x[1], 1e-300)
    minimum = 0.5 * (x[0] + x[1])
    if left_slope + right_slope > 0.0:
        minimum += 0.5 * (x[2] - x[0]) * left_slope / (left_slope + right_slope)
    return float(min(max(minimum, x[0]), x[2]))


def _cumulative_mass(weight: Array, alpha: Array, beta: Array, x: Array) -> Array:
    return np.asarray((weight * betainc(alpha, beta, x)).sum(axis=0))
