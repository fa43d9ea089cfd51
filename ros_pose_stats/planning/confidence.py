"""How sure an estimate, and drops with or without it, are to be within a target error."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..estimators import ESTIMATORS
from ..estimators.error_weights import USUAL_AT, USUAL_ERRORS
from ..statistics.posterior import PosePrior, error_quantile

FIRST_LOOK = 10
"""Drops before the first look at the error: an estimate may need no more."""

Counts = NDArray[np.int64]

WORTHLESS = 0.02
"""An estimate that stands for less than this share of the drops needed is left out."""

SOON = 1.4
"""The first look, in drops for which the expected error is the target; its bound needs more."""

AT_A_LOOK = 0.92
"""Asked of the bound wherever it is looked at. A run stops at the first look that finds it low
enough, by luck at times: so nine out of ten are left that keep the target."""


def best_method(restitution: float) -> str:
    """The estimator that errs least on the reference parts at a restitution."""
    def usual(name: str) -> float:
        squares = np.square(USUAL_ERRORS[name])
        return float(np.interp(restitution, USUAL_AT, squares))

    return min((name for name in ESTIMATORS if name in USUAL_ERRORS), key=usual)


def estimate_bound(prior: PosePrior) -> float:
    """Error that an estimate alone keeps with 90 % confidence; infinite if nothing is known.

    How errors scatter over parts was fitted for the default estimator; others of larger errors
    scatter less, and keep the bound more often.
    """
    if not prior.known and len(prior.size) > 1:
        return math.inf
    return prior.updated(np.zeros(prior.unit.shape, dtype=np.int64)).error_quantile()


def worthwhile(prior: PosePrior, target_error: float) -> bool:
    """Whether an estimate, or symmetry, saves a share of the drops that is worth having."""
    return (len(prior.size) < len(prior.unit)
            or prior.strength > WORTHLESS * plain_drops(prior, target_error))


def plain_drops(prior: PosePrior, target_error: float) -> float:
    """Drops that have the target as their expected error, if the estimate is about right."""
    spread = prior.mean * (1.0 - prior.mean) / prior.size
    return float(spread.sum()) / (len(prior.unit) * target_error ** 2)


def first_look(prior: PosePrior, target_error: float, helped: bool) -> int:
    """Drops before the first look: a look costs as much as a dozen drops, and few are enough.

    It depends on part, scene and target alone, so the answer does not depend on the timing.
    """
    needed = plain_drops(prior, target_error) - (prior.strength if helped else 0.0)
    return max(FIRST_LOOK, int(SOON * needed))


def prior_bound(prior: PosePrior) -> Callable[[Counts], float]:
    """The bound of the error by the counts and an estimate."""
    return lambda counts: prior.updated(counts).error_quantile(AT_A_LOOK)


def plain_bound(counts: Counts) -> float:
    """The bound of the error by the counts alone; infinite where nothing was counted."""
    total = float(counts.sum())
    if total == 0.0:
        return math.inf
    return error_quantile((counts + 0.5) / (total + 0.5 * counts.size), total, AT_A_LOOK)
