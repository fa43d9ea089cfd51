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

"""What an estimate says before any drop: probabilities, and how far to believe them.

The belief has a strength: as many pseudo-drops, divided as the estimate says. Nobody
knows it for the part at hand. Its logarithm is taken to scatter over parts about what
the expected error implies, with the tails of Student's t with three degrees of freedom.
A part may also be of a kind that no fit has seen; then the estimate may be worth
anything from a single drop up. How likely that is decides the answer; the errors that
are told beside it stand on more doubt, so that they are kept where the estimate is
wrong. Drops tell. Rare poses are estimated more surely than
the others, but for a share of them that is not: drops tell which kind a pose is of.
Poses that symmetry makes equal are one unit.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import betainc, betaln

from ...base.errors import RequestError
from ..records import Array, Index, Mask
from . import fitted_prior, posterior


class PriorFit(NamedTuple):
    """How a method's estimates err, beyond the expected error of each part."""

    # natural logarithm of the typical strength of the estimate over the one that its
    # expected error implies
    center: float
    spread: float  # scale of that logarithm over parts, above 0
    # probability that the method overrates by a factor of two, 0 to 1: poses far below
    # it are in truth rarer still
    overrated: float
    # probability below which a pose's estimate is stronger, in pseudo-drops, than the
    # others', 0 to 1
    rare_below: float
    # share of poses that are estimated no more surely than the others though they are
    # rare, above 0 and below 1
    unsure_share: float
    # probability that the part is of a kind that no fit has seen, 0 to below 1
    strange: float = 0.0
    # the same as the errors of the answer are told by, 0 to below 1; `strange` at least
    doubt: float = 0.0


def prior_fit(restitution: float) -> PriorFit:
    """The fit at a restitution, linear between those measured, constant beyond."""
    return PriorFit(
        *(
            float(np.interp(restitution, fitted_prior.FITTED_AT, column))
            for column in zip(*fitted_prior.FITTED, strict=True)
        )
    )


PROBABILITY_FLOOR = 1e-4
"""Least probability of a pose: far below the errors of all methods, but above 0, so
that drops can contradict an estimate that rules a pose out."""

LARGEST_FLOOR_SHARE = 0.01  # of the floor of all poses together, where they are many
SMALLEST_ERROR = 1e-4  # of any estimate that is believed: beyond 10 million drops
LEAST_STRENGTH = 1.0  # pseudo-drops of an estimate that is expected to be worthless
TAIL_FREEDOM = 3.0  # degrees of freedom of the scatter of the strength

STRENGTH_GRID = np.linspace(-8.0, 5.0, 14)
"""Strengths looked at, in spreads from the center of their logarithm."""

STRANGE_GRID = np.arange(8) / 8
"""Those of a part of a strange kind: logarithms over that of the typical strength, from
a single drop on, each as likely as the others."""

DOUBTED_DROPS = 100.0
"""Drops beside which the answer doubts the estimate half as much as its errors do: the
more there are, the less is won by an estimate that is right."""


class PosePrior:
    """Distribution of the pose probabilities of one part before it is dropped.

    `unit`: poses of one number have equal probabilities by symmetry; `row`: poses of
    one number, all of one unit, are a row of a table; each is one without;
    `expected_error`: NaN where nothing is known. Attributes `unit` (P,): that each pose
    belongs to, from 0 on; `row` (P,); `size` (G,): poses of each unit; `mean` (G,): of
    the units; `strength`: pseudo-drops that the estimate is typically worth.
    """

    def __init__(
        self,
        estimate: ArrayLike,
        unit: ArrayLike,
        expected_error: float,
        restitution: float,
        fit: PriorFit | None = None,
        row: ArrayLike | None = None,
    ) -> None:
        probability = np.asarray(estimate, dtype=np.float64)
        if (
            probability.ndim != 1
            or probability.size == 0
            or not (probability >= 0.0).all()
            or not (abs(probability.sum() - 1.0) < 1e-6)
        ):
            raise RequestError(
                "probabilities of one pose at least, with a sum of 1",
                f"{probability}",
                "give an estimate of all poses",
            )
        scatter_fit = prior_fit(restitution) if fit is None else fit
        self.unit: Index = np.unique(unit, return_inverse=True)[1]
        if self.unit.shape != probability.shape:
            raise RequestError(
                f"a unit for each of {probability.size} poses",
                f"{self.unit.size}",
                "give poses of their own unit each",
            )
        self.row: Index = self.unit
        if row is not None:
            self.row = np.unique(row, return_inverse=True)[1]
        self.size: Index = np.bincount(self.unit)
        unit_probability = np.bincount(self.unit, probability).astype(np.float64)
        self.mean: Array = _thin_rare_units(
            unit_probability, self.size, scatter_fit.overrated
        )
        self.has_expected_error = not math.isnan(expected_error)
        implied_strength = self._implied_strength(expected_error)
        self.strength = implied_strength * math.exp(scatter_fit.center)
        unsure_share = scatter_fit.unsure_share
        self._kind_share = np.array((1.0 - unsure_share, unsure_share))
        self._strange = scatter_fit.strange
        self._doubt = max(scatter_fit.strange, scatter_fit.doubt)
        self._strength = self._strength_grid(scatter_fit, implied_strength)
        self._log_weight = self._log_weights(self._doubt)

    def _strength_grid(self, fit: PriorFit, implied_strength: float) -> Array:
        """Strengths (2, M, G) of both kinds, those of a usual part first."""
        log_strength = (
            fit.center + fit.spread * STRENGTH_GRID + math.log(implied_strength)
        )
        rare_factor = 1.0 + fit.rare_below * self.size / self.mean
        kind_factors = np.vstack((rare_factor, np.ones_like(rare_factor)))[:, None]
        usual_strength: Array = np.exp(log_strength)[:, None] * kind_factors
        if not self._doubt:
            return usual_strength
        strange_strength = max(self.strength, LEAST_STRENGTH) ** STRANGE_GRID[:, None]
        shape = (2, STRANGE_GRID.size, rare_factor.size)
        return np.concatenate(
            (usual_strength, np.broadcast_to(strange_strength, shape)), axis=1
        )

    def _implied_strength(self, expected_error: float) -> float:
        """Pseudo-drops that leave as large an error as is expected."""
        spread = np.mean(
            (self.mean * (1.0 - self.mean) / (self.size * self.size))[self.unit]
        )
        if math.isnan(expected_error):
            return LEAST_STRENGTH
        return max(
            float(spread) / max(expected_error, SMALLEST_ERROR) ** 2 - 1.0,
            LEAST_STRENGTH,
        )

    def log_evidence(self, counts: ArrayLike) -> float:
        """Logarithm of the probability of such counts (P,), but for a constant."""
        return self._update(self._count_units(counts)).log_evidence

    def update(self, counts: ArrayLike) -> posterior.Posterior:
        """Distribution of the probabilities after counts (P,), which may be all 0."""
        unit_counts = self._count_units(counts)
        breaks, weight, answer_weight, _ = self._update(unit_counts)
        inverse_order = np.argsort(self._order(unit_counts))
        mean, variance = (moment[:, inverse_order] for moment in breaks.moments())
        kinds = posterior.Kinds(
            *(column[:, inverse_order] for column in breaks.kinds(weight))
        )
        return posterior.Posterior.from_moments(
            weight, answer_weight, mean, variance, self.unit, self.row, kinds
        )

    def contradicted_poses(self, counts: ArrayLike) -> Mask:
        """Poses (P,) in which drops contradict the estimate beyond both errors."""
        strength_weight = np.exp(self._log_weight[: STRENGTH_GRID.size])
        weight = self._kind_share[:, None] * strength_weight / strength_weight.sum()
        strength = self._strength[:, : STRENGTH_GRID.size]
        unit_counts = self._count_units(counts)
        return contradicted_units(unit_counts, self.mean, weight, strength)[self.unit]

    def _update(self, unit_counts: Array) -> "_Update":
        order = self._order(unit_counts)
        prior_breaks = ConnorMosimann.from_means(
            self.mean[order], self._strength[..., order], self._kind_share
        )
        posterior_breaks, log_evidence = prior_breaks.update(unit_counts[order])
        weight, total = _normalize(self._log_weight + log_evidence)
        strange = self._strange_beside(unit_counts.sum())
        answer_weight, _ = _normalize(self._log_weights(strange) + log_evidence)
        return _Update(posterior_breaks, weight, answer_weight, total)

    def _strange_beside(self, drops: float) -> float:
        """How likely the answer takes the part to be strange, beside so many drops."""
        square = (drops / DOUBTED_DROPS) ** 2
        share = square / (1.0 + square)
        return self._strange + (self._doubt - self._strange) * share

    def _log_weights(self, strange: float) -> Array:
        """Log weights (M,) of the strengths; `strange` as in `PriorFit`."""
        scatter = (
            -0.5
            * (TAIL_FREEDOM + 1.0)
            * np.log1p(STRENGTH_GRID * STRENGTH_GRID / TAIL_FREEDOM)
        )
        usual_weight = scatter - math.log(np.exp(scatter).sum()) + math.log1p(-strange)
        if not self._doubt:
            return usual_weight
        share = strange / STRANGE_GRID.size
        strange_weight = math.log(share) if share else -math.inf
        return np.concatenate(
            (usual_weight, np.full(STRANGE_GRID.shape, strange_weight))
        )

    def _order(self, unit_counts: Array) -> Index:
        """Rare units first; where estimates are equal, those seen less."""
        return np.asarray(np.lexsort((unit_counts, self.mean)))

    def _count_units(self, counts: ArrayLike) -> Array:
        pose_counts = np.asarray(counts, dtype=np.float64)
        if pose_counts.shape != self.unit.shape or not (pose_counts >= 0.0).all():
            raise RequestError(
                f"{self.unit.size} counts from 0 up",
                f"{pose_counts}",
                "count the settled drops of each pose",
            )
        return np.bincount(self.unit, pose_counts).astype(np.float64)


class _Update(NamedTuple):
    """A prior after drops."""

    breaks: "ConnorMosimann"
    weight: Array  # (M,); of the strengths, as errors are told by
    answer_weight: Array  # (M,); as the answer is made by
    log_evidence: float


def _normalize(log_weight: Array) -> tuple[Array, float]:
    """Weights of sum 1, and the logarithm of the sum that they had."""
    top = log_weight.max()
    weight = np.exp(log_weight - top)
    total = weight.sum()
    return weight / total, float(top + math.log(total))


def _thin_rare_units(unit_probability: Array, size: Index, overrated: float) -> Array:
    """Probabilities (G,) of the units, less what a method overrates in rare poses."""
    pose_probability = unit_probability / size
    inflated = np.maximum(pose_probability + overrated, PROBABILITY_FLOOR)
    thinned = pose_probability * pose_probability / inflated
    total = max(float((thinned * size).sum()), PROBABILITY_FLOOR)
    floor = min(PROBABILITY_FLOOR, LARGEST_FLOOR_SHARE / size.sum())
    floored = np.maximum(thinned / total, floor) * size
    return np.asarray(floored / floored.sum())


FALSE_ALARM_CHANCE = 0.002
"""Chance at each look that some pose of a part is said to be contradicted though the
estimate is as far off as it says, at most; Bonferroni's bound over the units and both
sides."""

LEAST_PARAMETER = 1e-9


def contradicted_units(
    counts: Array, mean: Array, weight: Array, strength: Array
) -> Mask:
    """Units whose count is too far from its estimate to be explained by both errors.

    A count of n drops with a probability from a Beta distribution of strength s
    scatters like a share from a Beta distribution of strength n (s + 1) / (s + n) - 1;
    which `strength` (K, M, G) holds is not known, so its tails are averaged by their
    `weight` (K, M).
    """
    total = counts.sum()
    if not total or mean.size == 1:
        return np.zeros(mean.shape, dtype=bool)
    count_strength = total * (strength + 1.0) / (strength + total) - 1.0
    alpha = np.maximum(count_strength * mean, LEAST_PARAMETER)
    beta = np.maximum(count_strength * (1.0 - mean), LEAST_PARAMETER)
    upper_tail = 1.0 - betainc(alpha, beta, np.clip((counts - 0.5) / total, 0.0, 1.0))
    lower_tail = betainc(alpha, beta, np.clip((counts + 0.5) / total, 0.0, 1.0))
    tails = np.minimum(
        np.tensordot(weight, upper_tail, 2), np.tensordot(weight, lower_tail, 2)
    )
    return 2.0 * tails * mean.size < FALSE_ALARM_CHANCE


TINY_WEIGHT = 1e-300
EXCLUDED_SHARE = 1e-12


class ConnorMosimann(NamedTuple):
    """Breaks of the stick; the last unit takes what is left.

    Each break has K Beta distributions, of which one holds; which one is found out
    break by break. Strengths (M,) hold for all breaks of a stick.
    """

    alpha: Array  # (K, M, G - 1) first Beta parameters
    beta: Array  # (K, M, G - 1) second ones
    # (K, M, G - 1) logarithms of how likely each distribution is, or (K, 1, 1) if alike
    log_share: Array

    @classmethod
    def from_means(cls, mean: Array, strength: Array, share: Array) -> "ConnorMosimann":
        """Breaks of given means, as sure as pseudo-drops.

        `share` (K,): how likely each of the K is.
        """
        remainder = np.cumsum(mean[:0:-1])[::-1]
        return cls(
            strength[..., :-1] * mean[:-1],
            strength[..., :-1] * remainder,
            np.log(share)[:, None, None],
        )

    def update(self, counts: Array) -> "tuple[ConnorMosimann, Array]":
        """Breaks after counts (G,), and the log probability (M,) of their sequence."""
        remainder = np.cumsum(counts[:0:-1])[::-1]
        alpha = self.alpha + counts[:-1]
        beta = self.beta + remainder
        log_likelihood = (
            self.log_share + betaln(alpha, beta) - betaln(self.alpha, self.beta)
        )
        top = log_likelihood.max(axis=0)
        log_total = top + np.log(np.exp(log_likelihood - top).sum(axis=0))
        breaks = ConnorMosimann(alpha, beta, log_likelihood - log_total)
        return breaks, log_total.sum(axis=-1)

    def moments(self) -> tuple[Array, Array]:
        """Means and variances (M, G) of the units."""
        share, mean, square = self._kind_moments()
        unit_mean = (share * mean).sum(axis=0)
        variance = (share * square).sum(axis=0) - unit_mean * unit_mean
        return unit_mean, np.maximum(variance, 0.0)

    def kinds(self, weight: Array) -> tuple[Array, Array, Array]:
        """How likely (K, G) each distribution is for a unit, and its moments.

        Of one that cannot hold they are those of the likeliest.
        """
        share, mean, square = self._kind_moments()
        joint_share = weight[:, None] * share
        kind_share = joint_share.sum(axis=1)
        strength_share = joint_share / np.maximum(kind_share, TINY_WEIGHT)[:, None]
        kind_mean = (strength_share * mean).sum(axis=1)
        kind_variance = np.maximum(
            (strength_share * square).sum(axis=1) - kind_mean * kind_mean, 0.0
        )
        valid_kind = np.where(
            kind_share > EXCLUDED_SHARE,
            np.arange(len(kind_share))[:, None],
            kind_share.argmax(axis=0),
        )
        return (
            kind_share,
            np.take_along_axis(kind_mean, valid_kind, axis=0),
            np.take_along_axis(kind_variance, valid_kind, axis=0),
        )

    def _kind_moments(self) -> tuple[Array, Array, Array]:
        """Shares, means and squares (K, M, G); the last unit has the last break."""
        share = np.exp(self.log_share)
        total = self.alpha + self.beta
        if not total.shape[-1]:
            certainty = np.ones((*total.shape[:-1], 1))
            return certainty / len(total), certainty, certainty
        break_mean = self.alpha / total
        rest_mean = self.beta / total
        break_square = break_mean * (self.alpha + 1.0) / (total + 1.0)
        rest_square = rest_mean * (self.beta + 1.0) / (total + 1.0)
        stick_mean = _stick_before((share * rest_mean).sum(axis=0))
        stick_square = _stick_before((share * rest_square).sum(axis=0))
        shares = np.broadcast_to(share, break_mean.shape)
        unit_mean = np.concatenate((break_mean, rest_mean[..., -1:]), axis=-1)
        unit_square = np.concatenate((break_square, rest_square[..., -1:]), axis=-1)
        return (
            np.concatenate((shares, shares[..., -1:]), axis=-1),
            unit_mean * stick_mean,
            unit_square * stick_square,
        )


def _stick_before(rest_mean: Array) -> Array:
    """Mean of what the breaks before a unit's left (..., G).

    The last two units have one break.
    """
    whole_stick = np.ones((*rest_mean.shape[:-1], 1))
    stick = np.concatenate(
        (whole_stick, np.cumprod(rest_mean[..., :-1], axis=-1)), axis=-1
    )
    return np.concatenate((stick, stick[..., -1:]), axis=-1)
