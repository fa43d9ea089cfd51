"""Pose probabilities as they are known after drops: means, errors, intervals, a bound."""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import betainc, gammainc

from ..records import Array, Index, statistics
from .errors import DEFAULT_LEVEL, largest_error

HALVINGS = 16  # of the logarithm of the bound, from a factor of `FARTHEST` each way
FARTHEST = 8.0


class SquareError(NamedTuple):
    """Distribution of the mean square error of the means over the poses.

    A mixture of gamma distributions that have the moments of the posterior's components, in which
    the units are normal with the correlations of a multinomial distribution (Satterthwaite).
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
        if expected <= SMALLEST:
            return 0.0
        shape = self.mean * self.mean / np.maximum(self.variance, SMALLEST)
        scaled = shape / np.maximum(self.mean, SMALLEST)
        least = -math.log(FARTHEST)
        most = math.log(FARTHEST)
        for _ in range(HALVINGS):
            middle = 0.5 * (least + most)
            below = self.weight @ gammainc(shape, scaled * expected * math.exp(middle))
            least, most = (middle, most) if below < level else (least, middle)
        return expected * math.exp(0.5 * (least + most))


WIDEST = 1.0 - 1e-9
NARROWEST = (
    1e-12  # variance of a unit over that of a single drop, where it is not certain
)


class Kinds(NamedTuple):
    """The units' distributions, each a mixture of K."""

    share: Array  # (K, G)
    mean: Array
    variance: Array


class Posterior(NamedTuple):
    """Distribution of the pose probabilities of one part."""

    probability: (
        Array  # (P,); means; they sum to 1, and poses of one group have equal ones
    )
    standard_error: Array  # (P,); standard deviations
    unit: Index  # (P,); the unit that each pose belongs to
    size: Index  # (G,); poses of each unit, which share its error evenly
    error: SquareError
    variance: Array  # (M, G); of the units at each of M strengths
    away: Array  # (M, G); mean less that of the mixture
    kinds: Kinds

    @classmethod
    def mixed(
        cls,
        weight: Array,
        mean: Array,
        variance: Array,
        unit: Index,
        size: Index,
        kinds: Kinds,
    ) -> "Posterior":
        """From the moments (M, G) of the units at each of some strengths, and their weights (M,).

        `kinds`: the same, parted by which kind of estimate holds rather than by strength.
        """
        # The weights' sum is rounded; it shows where all agree, as on a pose that is the only one.
        middle = np.where(np.ptp(mean, axis=0) == 0.0, mean[0], weight @ mean)
        away = mean - middle
        spread = weight @ (variance + away * away)
        share = 1.0 / size
        each = 1.0 / (
            size * size.sum()
        )  # a unit's square error to the poses' mean square
        own = variance * each
        odds = own * (mean / np.maximum(1.0 - mean, SMALLEST))
        shared = np.square(odds.sum(axis=1)) - np.square(odds).sum(axis=1)
        error = SquareError(
            weight,
            (variance + away * away) @ each,
            2.0 * (np.square(own).sum(axis=1) + np.maximum(shared, 0.0)),
        )
        return cls(
            (middle * share)[unit],
            (np.sqrt(spread) * share)[unit],
            unit,
            size,
            error,
            variance,
            away,
            kinds,
        )

    @property
    def expected_error(self) -> float:
        """Root mean square over the poses of their standard errors, as a fraction."""
        return math.sqrt(self.error.expected)

    def shares(self, counts: Index) -> statistics.Shares:
        """The probabilities with their errors, beside what was counted (P,)."""
        return statistics.Shares(
            self.probability,
            *self.interval(),
            self.standard_error,
            counts,
            self.expected_error,
            self.largest_error(),
        )

    def error_quantile(self, level: float = DEFAULT_LEVEL) -> float:
        """Bound that the root mean square error over the poses keeps with this probability."""
        return math.sqrt(self.error.quantile(level))

    def largest_error(self) -> float:
        """Bound that the errors of all poses keep together with 90 % confidence, a fraction."""
        return largest_error(
            np.sqrt(self.variance),
            DEFAULT_LEVEL,
            weight=self.error.weight,
            away=self.away,
            size=self.size,
        )

    def interval(self, level: float = DEFAULT_LEVEL) -> tuple[Array, Array]:
        """Bounds (P,), each pair the shortest that holds this share of a pose's distribution.

        A pose that is hardly ever met has a lower bound of 0; of a distribution as skewed as
        that the mean may lie above both bounds.
        """
        share, mean, variance = self.kinds
        single = mean * (1.0 - mean)
        spread = np.minimum(variance, WIDEST * single)
        unsure = (share * spread).sum(axis=0) > 0.0
        low = (share * mean).sum(axis=0)
        high = low.copy()
        if unsure.any():
            low[unsure], high[unsure] = shortest_interval(
                share[:, unsure],
                mean[:, unsure],
                np.maximum(spread[:, unsure], NARROWEST * single[:, unsure]),
                level,
            )
        return (low / self.size)[self.unit], (high / self.size)[self.unit]


SMALLEST = 1e-300

AROUND = np.linspace(-4.0, 7.0, 67)
"""Where the distribution is looked at: standard deviations from the mean of each component."""

NEAR_NOTHING = 10.0 ** np.arange(-8.0, 0.0)
"""And means of each component, for a rare pose whose density rises without bound towards 0."""

CELL_HALVINGS = 16  # of the cell in which the upper end lies


def shortest_interval(
    weight: Array, mean: Array, variance: Array, level: float
) -> tuple[Array, Array]:
    """Bounds (P,) between which the density of a mixture (K, P) is nowhere lower than outside.

    `weight` sums to 1 over K; 0 < mean < 1, 0 < variance < mean (1 - mean), 0 < level < 1. The
    length is within a thousandth of the least one, a few per cent where a sharp component stands
    beside a broad one.
    """
    mirrored = (weight * mean).sum(axis=0) > 0.5
    low, high = _left(weight, np.where(mirrored, 1.0 - mean, mean), variance, level)
    return np.where(mirrored, 1.0 - high, low), np.where(mirrored, 1.0 - low, high)


def _left(
    weight: Array, mean: Array, variance: Array, level: float
) -> tuple[Array, Array]:
    """The same of distributions whose mean is at most 1 / 2, so that only 0 may bind."""
    total = mean * (1.0 - mean) / np.maximum(variance, SMALLEST) - 1.0
    a = mean * total
    b = (1.0 - mean) * total  # of the Beta distributions of these moments
    around = mean[..., None] + np.sqrt(variance)[..., None] * AROUND
    near = mean[..., None] * NEAR_NOTHING
    count = mean.shape[1]
    nodes = np.concatenate((around, near), axis=2).swapaxes(0, 1).reshape(count, -1)
    nodes = np.sort(
        np.clip(np.column_stack((np.zeros(count), nodes, np.ones(count))), 0.0, 1.0)
    )
    mass = np.einsum("kp,kpn->pn", weight, betainc(a[..., None], b[..., None], nodes))
    low = np.array([_begin(x, y, level) for x, y in zip(nodes, mass, strict=True)])
    wanted = level + _mass(weight, a, b, low)
    cell = np.sum(mass < wanted[:, None], axis=1, keepdims=True).clip(
        1, nodes.shape[1] - 1
    )
    least, most = (
        np.take_along_axis(nodes, at, axis=1)[:, 0] for at in (cell - 1, cell)
    )
    for _ in range(CELL_HALVINGS):
        middle = 0.5 * (least + most)
        short = _mass(weight, a, b, middle) < wanted
        least = np.where(short, middle, least)
        most = np.where(short, most, middle)
    return low, np.where(wanted < 1.0, most, 1.0)


def _begin(nodes: Array, mass: Array, level: float) -> float:
    """Where the shortest interval begins, by a parabola through the three shortest in a row."""
    begin = nodes[mass <= mass[-1] - level]
    ends = np.interp(mass[: begin.size] + level, mass, nodes)
    length = ends - begin
    best = int(np.argmin(length))
    if not 0 < best < begin.size - 1 or begin[best - 1] == begin[best]:
        return float(begin[best])
    x = begin[best - 1 : best + 2]
    y = length[best - 1 : best + 2]
    left = (y[0] - y[1]) / (x[1] - x[0])
    right = (y[2] - y[1]) / max(x[2] - x[1], 1e-300)
    turn = 0.5 * (x[2] - x[0]) * left / (left + right) if left + right > 0.0 else 0.0
    return float(min(max(0.5 * (x[0] + x[1]) + turn, x[0]), x[2]))


def _mass(weight: Array, a: Array, b: Array, x: Array) -> Array:
    return np.asarray((weight * betainc(a, b, x)).sum(axis=0))
