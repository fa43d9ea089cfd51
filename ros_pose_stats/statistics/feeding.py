"""What a feeder gets out of a part: accepted parts, passes and flips, with their intervals.

Parts are looked at one after another. One that lies in a wanted pose is accepted. The others are
sent back and dropped afresh, or kicked where they lie until they lie right. The errors are those
of the probabilities by the delta method, of first order in them.
"""

import math
from collections.abc import Sequence
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from ..errors import RequestError
from ..records import Array, Index, Mask
from .errors import DEFAULT_LEVEL, jeffreys_interval
from .pose_groups import PoseShares


class Bounded(NamedTuple):
    """A number and the bounds of its 90 % interval; NaN where none are known."""

    value: float
    low: float
    high: float


class Feeding(NamedTuple):
    """What becomes of the parts that are dropped."""

    accepted: Bounded  # share of the parts dropped that are accepted before they are dropped again
    passes: Bounded  # drops that an accepted part took
    # flips that an accepted part took; infinite where a pose that is not wanted can keep a part
    # for ever
    flips: Bounded
    per_minute: Bounded  # accepted parts a minute


CERTAIN = 1e15  # so many drops would leave no error but that of rounding
NO_FLIPS = Bounded(0.0, 0.0, 0.0)


def drop_afresh(dropped: PoseShares, wanted: Sequence[int], rate: float = math.nan) -> Feeding:
    """Feed a part by dropping those again that lie wrong.

    `wanted`: indices of the poses that are accepted, at least one; `rate`: parts dropped a minute,
    those sent back included, above 0; NaN where it is not known.
    """
    kept = check_wanted(wanted, dropped.probability.size)
    if not math.isnan(rate):
        check_rate(rate)
    share = 1.0 if kept.all() else min(1.0, float(dropped.probability[kept].sum()))
    low, high = (1.0, 1.0) if kept.all() else _share_interval(share, dropped, kept)
    return Feeding(Bounded(share, low, high), passes_of(share, low, high), NO_FLIPS,
                   Bounded(rate * share, rate * low, rate * high))


def passes_of(share: float, low: float, high: float) -> Bounded:
    """Drops that an accepted part takes where the others are dropped again."""
    return Bounded(*(1.0 / one if one else math.inf for one in (share, high, low)))


def flip_wrong_ones(dropped: PoseShares, counts: ArrayLike, wanted: Sequence[int], rate: float,
                    cycle_time: float) -> Feeding:
    """Feed a part by kicking those that lie wrong until they lie right.

    A part that is dropped takes 60 / rate seconds, and each flip as long as a cycle. `counts`
    (K, K): flips out of each pose, by the pose in which they ended.
    """
    flips = np.asarray(counts, dtype=float)
    kept = check_wanted(wanted, dropped.probability.size)
    check_rate(rate, cycle_time)
    settled = flips.sum(axis=1)
    if not (settled[~kept] > 0.0).all():
        raise RequestError("flips counted out of every pose that is not wanted",
                           f"none out of pose {np.flatnonzero(~kept & (settled <= 0.0))[0]}",
                           "simulate more flips")
    if kept.all():
        return Feeding(Bounded(1.0, 1.0, 1.0), Bounded(1.0, 1.0, 1.0), NO_FLIPS,
                       Bounded(rate, rate, rate))
    wrong, shares = np.flatnonzero(~kept), dropped.probability
    moves = flips[wrong] / settled[wrong, None]
    leaving = _that_get_out(moves, kept, wrong)
    if not leaving.all():
        # In the end a part lies there for ever; those that arrive before are accepted.
        out, moves = wrong[leaving], moves[leaving]
        arrive = np.linalg.solve(np.eye(out.size) - moves[:, out], moves[:, kept].sum(axis=1))
        unknown = Bounded(math.nan, math.nan, math.nan)
        return Feeding(
            unknown._replace(value=float(shares[kept].sum() + shares[out] @ arrive)), unknown,
            unknown._replace(value=math.inf), Bounded(0.0, 0.0, math.nan))
    value, error = _flips_needed(dropped, moves, flips[wrong], wrong)
    spread = spread_of(error / value) if value else 1.0
    needed = Bounded(value, value / spread, value * spread)
    certain = Bounded(1.0, 1.0, 1.0)
    return Feeding(certain, certain, needed, Bounded(*(
        60.0 / (60.0 / rate + one * cycle_time) for one in (value, needed.high, needed.low))))


def spread_of(error: float) -> float:
    """Factor to the end of the 90 % interval of a positive number, whose logarithm is normal."""
    return math.exp(-float(ndtri(0.5 * (1.0 - DEFAULT_LEVEL))) * error)


def _flips_needed(dropped: PoseShares, moves: Array, flips: Array,
                  wrong: Index) -> tuple[float, float]:
    """Flips that a dropped part needs on average, and the standard error of that.

    With T the moves among the wrong poses: g = (I - T)^-1 1 flips are needed out of each, and each
    is visited v = p (I - T)^-1 times. A change dT of the matrix changes p g by v dT g.
    """
    shares = dropped.probability
    inner = np.eye(wrong.size) - moves[:, wrong]
    needed = np.zeros(shares.size)
    needed[wrong] = np.linalg.solve(inner, np.ones(wrong.size))
    visits = np.linalg.solve(inner.T, shares[wrong])
    smooth = (flips + 0.5) / (flips.sum(axis=1) + 0.5 * shares.size)[:, None]
    rows = smooth @ needed ** 2 - (smooth @ needed) ** 2
    variance = float(visits ** 2 @ (rows / flips.sum(axis=1)))
    if dropped.drops != math.inf:
        variance += dropped.scatter(needed) / dropped.drops
    return float(shares @ needed), math.sqrt(variance)


def _that_get_out(moves: Array, kept: Mask, wrong: Index) -> Mask:
    """From which of the other poses a wanted one can be reached by the flips counted."""
    out = moves[:, kept].any(axis=1)
    while True:
        further = out | (moves[:, wrong[out]] > 0.0).any(axis=1)
        if (further == out).all():
            return np.asarray(out)
        out = further


def _share_interval(share: float, dropped: PoseShares, kept: Mask) -> tuple[float, float]:
    """Bounds of the share of some poses; symmetry tells how a unit's share is shared out."""
    drops, single = dropped.drops, share * (1.0 - share)
    if math.isnan(drops):
        return math.nan, math.nan
    if single > 0.0:
        scatter = dropped.scatter(kept.astype(np.float64))
        drops *= single / scatter if scatter else math.inf
    if drops > CERTAIN:
        return share, share
    low, high = jeffreys_interval(share * drops, drops)
    return float(low), float(high)


def check_wanted(wanted: Sequence[int], poses: int) -> Mask:
    """Which of all poses (K,) are accepted."""
    indices: list[Any] = list(wanted) if np.ndim(wanted) == 1 else [wanted]
    bad = [one for one in indices if isinstance(one, bool) or not isinstance(one, Integral)
           or not 0 <= int(one) < poses]
    if bad or not indices:
        raise RequestError(f"wanted poses out of 0 to {poses - 1}, at least one",
                           f"{bad[0]!r}" if bad else "none",
                           "they are the `index` of the poses; `ros_pose_stats estimate` lists "
                           "them")
    kept = np.zeros(poses, dtype=np.bool_)
    kept[indices] = True
    return kept


def check_rate(rate: float, cycle_time: float = 0.0) -> None:
    """Refuse a rate of drops, and a time from kick to kick, that is none."""
    if not 0.0 < rate < math.inf:
        raise RequestError("a rate above 0 parts a minute", f"{rate}",
                           "count the parts that are dropped, those sent back included")
    if not 0.0 <= cycle_time < math.inf:
        raise RequestError("a cycle time of 0 s or more", f"{cycle_time}",
                           "it is the time from one kick to the next")
