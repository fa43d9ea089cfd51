"""The bound that the error over the poses keeps: what a target error promises.

A target is kept where the root mean square error over the poses is within it with 90 %
confidence. A run stops at the first look that finds the bound low enough, by luck at times;
so a little more than 90 % is asked for wherever a run may stop.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .errors import expected_error, standard_errors

if TYPE_CHECKING:
    from .posterior import Posterior

Index = NDArray[np.int64]

AT_A_LOOK: Final = 0.92
"""Confidence asked for at each look, so that 90 % are left."""

DEVIATE: Final = 1.4050715603096329
"""The normal deviate below which a share of `AT_A_LOOK` lies."""


class Judged(NamedTuple):
    """What drops so far are worth."""

    # root mean square of the poses' standard errors; NaN before a drop has settled
    expected_error: float
    bound: float  # that the root mean square error keeps; infinite before a drop has settled


def judge_counts(counts: Index) -> Judged:
    """Judge counts (K,) of independent drops by themselves."""
    return Judged(expected_error(standard_errors(counts, int(counts.sum()))),
                  counted_bound(counts))


def counted_bound(counts: Index) -> float:
    """Bound that the error of counts keeps, a fraction.

    The squared error of shares is a sum of squares of normal variables, taken as a gamma
    distribution with its mean and variance (Satterthwaite), whose quantile is that of Wilson and
    Hilferty: 1.3 % low in the error for two poses, nearer for more. There are only products and
    roots in it, so that runs end alike on all machines.

    `counts` (K,): settled drops in each pose. Returns infinite before a drop has settled.
    """
    settled = int(counts.sum())
    if not settled:
        return math.inf
    q = (counts + 0.5) / (settled + 0.5 * counts.size)
    mean = float((q * (1.0 - q)).sum())
    if not mean > 0.0:  # the only pose
        return 0.0
    squares, cubes = float((q * q).sum()), float((q * q * q).sum())
    variance = 2.0 * (squares - 2.0 * cubes + squares * squares)
    spread = variance / (9.0 * mean * mean)
    root = 1.0 - spread + DEVIATE * math.sqrt(spread)
    return math.sqrt(mean / (settled * counts.size) * root * root * root)


def judge_posterior(posterior: Posterior) -> Judged:
    """Judge drops and an estimate together."""
    return Judged(posterior.expected_error, posterior.error_quantile(AT_A_LOOK))
