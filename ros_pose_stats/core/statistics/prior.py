"""What an estimate says before any drop: probabilities, and how far to believe them.

The belief has a strength: as many pseudo-drops, divided as the estimate says. Nobody knows it
for the part at hand. Its logarithm is taken to scatter over parts about what the expected error
implies, with the tails of Student's t with three degrees of freedom. A part may also be of a kind
that no fit has seen; then the estimate may be worth anything from a single drop up. Drops tell.
Rare poses are estimated more surely than the others, but for a share of them that is not: drops
tell which kind a pose is of. Poses that symmetry makes equal are one unit.
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

    # natural logarithm of the typical strength of the estimate over the one that its expected
    # error implies
    center: float
    spread: float  # scale of that logarithm over parts, above 0
    # probability that the method overrates by a factor of two, 0 to 1: poses far below it are in
    # truth rarer still
    overrated: float
    # probability below which a pose's estimate is stronger, in pseudo-drops, than the others', 0
    # to 1
    rare_below: float
    # share of poses that are estimated no more surely than the others though they are rare, above
    # 0 and below 1
    unsure_share: float
    # probability that the part is of a kind that no fit has seen, 0 to below 1
    strange: float = 0.0


def prior_fit(restitution: float) -> PriorFit:
    """The fit at a restitution, straight between those measured, the nearest one beyond."""
    return PriorFit(
        *(
            float(np.interp(restitution, fitted_prior.FITTED_AT, column))
            for column in zip(*fitted_prior.FITTED, strict=True)
        )
    )


FLOOR = 1e-4
"""Least probability of a pose: far below the errors of all methods, but above 0, so that drops
can contradict an estimate that rules a pose out."""

FLOORS_TOGETHER = (
    0.01  # most probability that the floor may take where there are many poses
)
LEAST_ERROR = (
    1e-4  # no estimate is believed to be nearer than this: beyond 10 million drops
)
LEAST_STRENGTH = 1.0  # pseudo-drops of an estimate that is expected to be worthless
TAIL = 3.0  # degrees of freedom of the scatter of the strength

GRID = np.linspace(-8.0, 5.0, 14)
"""Strengths looked at, in spreads from the center of their logarithm."""

STRANGE_GRID = np.arange(8) / 8
"""Those of a part of a strange kind: logarithms over that of the typical strength, from a single
drop on, each as likely as the others."""


class PosePrior:
    """Distribution of the pose probabilities of one part before it is dropped.

    `group`: poses of one number have equal probabilities by symmetry; `expected_error`: NaN where
    nothing is known. Attributes `unit` (P,): that each pose belongs to; `size` (G,): poses of each
    unit; `mean` (G,): of the units; `strength`: pseudo-drops that the estimate is typically worth;
    `known`: whether there is an expected error.
    """

    def __init__(
        self,
        estimate: ArrayLike,
        group: ArrayLike,
        expected_error: float,
        restitution: float,
        fit: PriorFit | None = None,
    ) -> None:
        given = np.asarray(estimate, dtype=np.float64)
        if (
            given.ndim != 1
            or given.size == 0
            or not (given >= 0.0).all()
            or not (abs(given.sum() - 1.0) < 1e-6)
        ):
            raise RequestError(
                "probabilities of one pose at least, with a sum of 1",
                f"{given}",
                "give an estimate of all poses",
            )
        how = prior_fit(restitution) if fit is None else fit
        self.unit: Index = np.unique(np.asarray(group), return_inverse=True)[1].reshape(
            -1
        )
        if self.unit.shape != given.shape:
            raise RequestError(
                f"a group for each of {given.size} poses",
                f"{self.unit.size}",
                "give poses of their own group each",
            )
        self.size: Index = np.bincount(self.unit)
        together = np.bincount(self.unit, given).astype(np.float64)
        self.mean: Array = _thinned(together, self.size, how.overrated)
        self.known = not math.isnan(expected_error)
        self.strength = self._implied(expected_error) * math.exp(how.center)
        strange = STRANGE_GRID if how.strange else STRANGE_GRID[:0]
        log_strength = (
            how.center + how.spread * GRID + math.log(self._implied(expected_error))
        )
        firm = 1.0 + how.rare_below * self.size / self.mean
        kinds = np.vstack((firm, np.ones_like(firm)))[:, None]
        any_strength = max(self.strength, LEAST_STRENGTH) ** strange[:, None]
        self._strength = np.concatenate(
            (
                np.exp(log_strength)[:, None] * kinds,
                np.broadcast_to(any_strength, (2, strange.size, firm.size)),
            ),
            axis=1,
        )
        self._share = np.array((1.0 - how.unsure_share, how.unsure_share))
        scatter = -0.5 * (TAIL + 1.0) * np.log1p(GRID * GRID / TAIL)
        usual = scatter - math.log(np.exp(scatter).sum())
        self._log_weight = np.concatenate(
            (
                usual + math.log1p(-how.strange),
                np.log(np.full(strange.shape, how.strange / STRANGE_GRID.size)),
            )
        )

    def _implied(self, expected_error: float) -> float:
        """Pseudo-drops that leave as large an error as is expected."""
        spread = np.mean(
            (self.mean * (1.0 - self.mean) / (self.size * self.size))[self.unit]
        )
        if math.isnan(expected_error):
            return LEAST_STRENGTH
        return max(
            float(spread) / max(expected_error, LEAST_ERROR) ** 2 - 1.0, LEAST_STRENGTH
        )

    def log_evidence(self, counts: ArrayLike) -> float:
        """Logarithm of the probability of such counts (P,), up to what the prior leaves alone."""
        return self._updated(self._pooled(counts))[2]

    def updated(self, counts: ArrayLike) -> posterior.Posterior:
        """What is known after drops; counts are all 0 for what is known before the first."""
        pooled = self._pooled(counts)
        breaks, weight, _ = self._updated(pooled)
        back = np.argsort(self._order(pooled))
        mean, variance = (each[:, back] for each in breaks.moments())
        kinds = posterior.Kinds(*(each[:, back] for each in breaks.kinds(weight)))
        return posterior.Posterior.mixed(
            weight, mean, variance, self.unit, self.size, kinds
        )

    def contradicted(self, counts: ArrayLike) -> Mask:
        """Poses (P,) in which drops contradict the estimate beyond both errors."""
        usual = np.exp(self._log_weight[: GRID.size])
        weight = self._share[:, None] * usual / usual.sum()
        strength = self._strength[:, : GRID.size]
        return contradicted_units(self._pooled(counts), self.mean, weight, strength)[
            self.unit
        ]

    def _updated(self, pooled: Array) -> "tuple[ConnorMosimann, Array, float]":
        """Breaks after the drops at each strength, the strengths' weights, log evidence."""
        order = self._order(pooled)
        before = ConnorMosimann.around(
            self.mean[order], self._strength[..., order], self._share
        )
        after, log_evidence = before.updated(pooled[order])
        log_weight = self._log_weight + log_evidence
        top = log_weight.max()
        weight = np.exp(log_weight - top)
        return after, weight / weight.sum(), float(top + math.log(weight.sum()))

    def _order(self, pooled: Array) -> Index:
        """Rare units first; where estimates are equal, those seen less."""
        return np.asarray(np.lexsort((pooled, self.mean)))

    def _pooled(self, counts: ArrayLike) -> Array:
        counted = np.asarray(counts, dtype=np.float64)
        if counted.shape != self.unit.shape or not (counted >= 0.0).all():
            raise RequestError(
                f"{self.unit.size} counts from 0 up",
                f"{counted}",
                "count the settled drops of each pose",
            )
        return np.bincount(self.unit, counted).astype(np.float64)


def _thinned(together: Array, size: Index, overrated: float) -> Array:
    """Probabilities (G,) of the units with what a method overrates in rare poses taken off."""
    each = together / size
    kept = each * each / np.maximum(each + overrated, FLOOR)
    least = min(FLOOR, FLOORS_TOGETHER / size.sum())
    raised = np.maximum(kept / max(float((kept * size).sum()), FLOOR), least) * size
    return np.asarray(raised / raised.sum())


FALSE_ALARMS = 0.002
"""Chance at each look that some pose of a part is said to be contradicted though the estimate is
as far off as it says, at most; Bonferroni's bound over the units and both sides."""

LEAST_PARAMETER = 1e-9


def contradicted_units(
    counts: Array, mean: Array, weight: Array, strength: Array
) -> Mask:
    """Units whose count is too far from its estimate to be explained by both errors.

    A count of n drops with a probability from a Beta distribution of strength s scatters like a
    share from a Beta distribution of strength n (s + 1) / (s + n) - 1; which `strength` (K, M, G)
    holds is not known, so its tails are averaged by their `weight` (K, M).
    """
    total = counts.sum()
    if not total or mean.size == 1:
        return np.zeros(mean.shape, dtype=bool)
    together = total * (strength + 1.0) / (strength + total) - 1.0
    first = np.maximum(together * mean, LEAST_PARAMETER)
    second = np.maximum(together * (1.0 - mean), LEAST_PARAMETER)
    above = 1.0 - betainc(first, second, np.clip((counts - 0.5) / total, 0.0, 1.0))
    below = betainc(first, second, np.clip((counts + 0.5) / total, 0.0, 1.0))
    tails = np.minimum(np.tensordot(weight, above, 2), np.tensordot(weight, below, 2))
    return np.asarray(2.0 * tails * mean.size < FALSE_ALARMS)


LEAST_WEIGHT = 1e-300
RULED_OUT = 1e-12


class ConnorMosimann(NamedTuple):
    """Breaks of the stick; the last unit takes what is left.

    Each break has K Beta distributions, of which one holds; which one is found out break by break.
    Strengths (M,) hold for all breaks of a stick.
    """

    taken: Array  # (K, M, G - 1) first Beta parameters
    left: Array  # (K, M, G - 1) second ones
    log_share: Array  # (K, M, G - 1) logarithms of how likely each is, or (K, 1, 1) if all alike

    @classmethod
    def around(cls, mean: Array, strength: Array, share: Array) -> "ConnorMosimann":
        """With given means, as sure as pseudo-drops; `share` (K,): how likely each of the K is."""
        beyond = np.cumsum(mean[:0:-1])[::-1]
        return cls(
            strength[..., :-1] * mean[:-1],
            strength[..., :-1] * beyond,
            np.log(share)[:, None, None],
        )

    def updated(self, counts: Array) -> "tuple[ConnorMosimann, Array]":
        """After counts (G,), and the logarithm (M,) of their probability in this very sequence."""
        beyond = np.cumsum(counts[:0:-1])[::-1]
        taken = self.taken + counts[:-1]
        left = self.left + beyond
        likely = self.log_share + betaln(taken, left) - betaln(self.taken, self.left)
        top = likely.max(axis=0)
        together = top + np.log(np.exp(likely - top).sum(axis=0))
        return ConnorMosimann(taken, left, likely - together), together.sum(axis=-1)

    def moments(self) -> tuple[Array, Array]:
        """Means and variances (M, G) of the units."""
        share, mean, square = self._kinds()
        middle = (share * mean).sum(axis=0)
        return middle, np.maximum((share * square).sum(axis=0) - middle * middle, 0.0)

    def kinds(self, weight: Array) -> tuple[Array, Array, Array]:
        """How likely (K, G) each distribution is for a unit, and the moments where it holds.

        Of one that cannot hold they are those of the likeliest.
        """
        share, mean, square = self._kinds()
        each = weight[:, None] * share
        whole = each.sum(axis=1)
        part = each / np.maximum(whole, LEAST_WEIGHT)[:, None]
        middle = (part * mean).sum(axis=1)
        spread = np.maximum((part * square).sum(axis=1) - middle * middle, 0.0)
        holds = np.where(
            whole > RULED_OUT, np.arange(len(whole))[:, None], whole.argmax(axis=0)
        )
        return (
            whole,
            np.take_along_axis(middle, holds, axis=0),
            np.take_along_axis(spread, holds, axis=0),
        )

    def _kinds(self) -> tuple[Array, Array, Array]:
        """Shares, means and mean squares (K, M, G) of the units; the last has the last break."""
        share = np.exp(self.log_share)
        total = self.taken + self.left
        first = self.taken / total
        rest = self.left / total
        twice = first * (self.taken + 1.0) / (total + 1.0)
        rest_twice = rest * (self.left + 1.0) / (total + 1.0)
        before, before_twice = (
            _remaining((share * one).sum(axis=0)) for one in (rest, rest_twice)
        )
        shares = np.broadcast_to(share, first.shape)
        if not first.shape[-1]:
            whole = np.ones((*first.shape[:-1], 1))
            return whole / len(first), whole, whole
        return (
            np.concatenate((shares, shares[..., -1:]), axis=-1),
            np.concatenate((first, rest[..., -1:]), axis=-1) * before,
            np.concatenate((twice, rest_twice[..., -1:]), axis=-1) * before_twice,
        )


def _remaining(rest: Array) -> Array:
    """What all breaks before a unit's left (..., G), on average; the last two have one break."""
    one = np.ones((*rest.shape[:-1], 1))
    before = np.concatenate((one, np.cumprod(rest[..., :-1], axis=-1)), axis=-1)
    return np.asarray(np.concatenate((before, before[..., -1:]), axis=-1))
