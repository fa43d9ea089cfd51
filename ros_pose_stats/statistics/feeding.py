"""What a feeder gets out of a part: accepted parts, passes and flips, with their intervals.

Parts are looked at one after another. One that lies in a wanted pose is accepted. The others are
sent back and dropped afresh, or kicked where they lie until they lie right. The errors are those
of the probabilities by the delta method, of first order in them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ..errors import RequestError
from .intervals import DEFAULT_LEVEL, jeffreys_interval

Array = NDArray[np.float64]


class Bounded(NamedTuple):
    """A number and the bounds of its 90 % interval; NaN where none are known."""

    value: float
    low: float
    high: float


class Feeding(NamedTuple):
    """What becomes of the parts that are dropped.

    Attributes
    ----------
    accepted : Bounded
        Share of the parts dropped that are accepted before they are dropped again.
    passes : Bounded
        Drops that an accepted part took.
    flips : Bounded
        Flips that an accepted part took; infinite where a pose that is not wanted can keep a part
        for ever.
    per_minute : Bounded
        Accepted parts a minute.
    """

    accepted: Bounded
    passes: Bounded
    flips: Bounded
    per_minute: Bounded


MOST_ROUNDS = 40
"""Each round halves the error of the logarithm."""

NO_FLIPS = Bounded(0.0, 0.0, 0.0)


def drop_afresh(probability: ArrayLike, standard_error: ArrayLike, wanted: Sequence[int],
                rate: float) -> Feeding:
    """Feed a part by dropping those again that lie wrong.

    Parameters
    ----------
    probability, standard_error : (K,) array
        Of the poses by their index, after a drop.
    wanted : sequence of int
        Indices of the poses that are accepted, at least one.
    rate : float
        Parts dropped a minute, above 0.

    Raises
    ------
    RequestError
        If a pose does not exist, or the rate is out of its range.
    """
    shares = np.asarray(probability, dtype=float)
    kept = _wanted(wanted, shares.size)
    _check_rate(rate, 0.0)
    drops = _equivalent_drops(shares, np.asarray(standard_error, dtype=float))
    share = min(1.0, float(shares[kept].sum()))
    low, high = _share_interval(share, drops)
    passes = Bounded(*(_over(1.0, one) for one in (share, high, low)))
    return Feeding(Bounded(share, low, high), passes, NO_FLIPS,
                   Bounded(rate * share, rate * low, rate * high))


def flip_wrong_ones(probability: ArrayLike, standard_error: ArrayLike, counts: ArrayLike,
                    wanted: Sequence[int], rate: float, cycle_time: float) -> Feeding:
    """Feed a part by kicking those that lie wrong until they lie right.

    A part that is dropped takes 60 / rate seconds, and each flip as long as a cycle.

    Parameters
    ----------
    probability, standard_error : (K,) array
        Of the poses by their index, after a drop.
    counts : (K, K) array
        Flips out of each pose, by the pose in which they ended.
    wanted : sequence of int
        Indices of the poses that are accepted, at least one.
    rate : float
        Parts dropped a minute, above 0.
    cycle_time : float
        Seconds from one kick to the next, 0 or more.

    Raises
    ------
    RequestError
        If a pose does not exist, flips of a pose are missing, or a number is out of its range.
    """
    shares, errors = np.asarray(probability, float), np.asarray(standard_error, float)
    flips = np.asarray(counts, dtype=float)
    kept = _wanted(wanted, shares.size)
    _check_rate(rate, cycle_time)
    settled = flips.sum(axis=1)
    if not (settled[~kept] > 0.0).all():
        raise RequestError("flips counted out of every pose that is not wanted",
                           f"none out of pose {np.flatnonzero(~kept & (settled <= 0.0))[0]}",
                           "simulate more flips")
    if kept.all():
        return Feeding(Bounded(1.0, 1.0, 1.0), Bounded(1.0, 1.0, 1.0), NO_FLIPS,
                       Bounded(rate, rate, rate))
    wrong = np.flatnonzero(~kept)
    moves = flips[wrong] / settled[wrong, None]
    if not _all_get_out(moves, kept, wrong):
        never = Bounded(math.inf, math.nan, math.nan)
        return Feeding(Bounded(float(shares[kept].sum()), math.nan, math.nan),
                       Bounded(math.nan, math.nan, math.nan), never, Bounded(0.0, 0.0, math.nan))
    value, error = _flips_needed(shares, errors, moves, flips[wrong], wrong)
    # The number of flips is positive and skewed: its logarithm is nearer to normal.
    spread = math.exp(-float(ndtri(0.5 * (1.0 - DEFAULT_LEVEL))) * error / value) if value else 1.0
    needed = Bounded(value, value / spread, value * spread)
    certain = Bounded(1.0, 1.0, 1.0)
    return Feeding(certain, certain, needed, Bounded(*(
        60.0 / (60.0 / rate + one * cycle_time) for one in (value, needed.high, needed.low))))


def _flips_needed(shares: Array, errors: Array, moves: Array, flips: Array,
                  wrong: NDArray[np.int64]) -> tuple[float, float]:
    """Flips that a dropped part needs on average, and the standard error of that.

    With T the moves among the wrong poses: g = (I - T)^-1 1 flips are needed out of each, and each
    is visited v = p (I - T)^-1 times. A change dT of the matrix changes p g by v dT g.
    """
    inner = np.eye(wrong.size) - moves[:, wrong]
    needed = np.zeros(shares.size)
    needed[wrong] = np.linalg.solve(inner, np.ones(wrong.size))
    visits = np.linalg.solve(inner.T, shares[wrong])
    smooth = (flips + 0.5) / (flips.sum(axis=1) + 0.5 * shares.size)[:, None]
    rows = smooth @ needed ** 2 - (smooth @ needed) ** 2
    variance = float(visits ** 2 @ (rows / flips.sum(axis=1)))
    drops = _equivalent_drops(shares, errors)
    if drops != math.inf:
        variance += float(shares @ needed ** 2 - (shares @ needed) ** 2) / drops
    return float(shares @ needed), math.sqrt(variance)


def _all_get_out(moves: Array, kept: NDArray[np.bool_], wrong: NDArray[np.int64]) -> bool:
    """Whether a wanted pose can be reached from every other one by the flips counted."""
    out = moves[:, kept].any(axis=1)
    while True:
        further = out | (moves[:, wrong[out]] > 0.0).any(axis=1)
        if (further == out).all():
            return bool(out.all())
        out = further


def _equivalent_drops(shares: Array, errors: Array) -> float:
    """Drops n whose counts would have these errors; NaN where no errors are known.

    The sum of the squares of `standard_errors` is that of q (1 - q) / n, with q between the share
    and 1 / K, so that n stands on both sides; the mean of both converges.
    """
    scatter = float((errors * errors).sum())
    if scatter == 0.0:
        return math.inf
    drops = 1.0 / scatter
    for _ in range(MOST_ROUNDS):
        q = (drops * shares + 0.5) / (drops + 0.5 * shares.size)
        drops = math.sqrt(drops * float((q * (1.0 - q)).sum()) / scatter)
    return drops


def _share_interval(share: float, drops: float) -> tuple[float, float]:
    if math.isnan(drops):
        return math.nan, math.nan
    if drops == math.inf:
        return share, share
    low, high = jeffreys_interval(share * drops, drops)
    return float(low), float(high)


def _wanted(wanted: Sequence[int], poses: int) -> NDArray[np.bool_]:
    indices = list(wanted)
    bad = [one for one in indices if isinstance(one, bool) or not 0 <= one < poses]
    if bad or not indices:
        raise RequestError(f"wanted poses out of 0 to {poses - 1}, at least one",
                           f"{bad[0] if bad else 'none'}", "they are the `index` of the poses")
    kept = np.zeros(poses, dtype=np.bool_)
    kept[indices] = True
    return kept


def _check_rate(rate: float, cycle_time: float) -> None:
    if not 0.0 < rate < math.inf:
        raise RequestError("a rate above 0 parts a minute", f"{rate}", "60 is one a second")
    if not 0.0 <= cycle_time < math.inf:
        raise RequestError("a cycle time of 0 s or more", f"{cycle_time}",
                           "it is the time from one kick to the next")


def _over(above: float, below: float) -> float:
    return above / below if below != 0.0 else math.inf
