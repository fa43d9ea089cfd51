"""What a feeder gets out of a part: accepted parts, passes and flips, with their intervals.

Parts are looked at one after another. One that lies in a wanted pose is accepted. The others are
sent back and dropped afresh, or kicked where they lie until they lie right. The errors are those
of the probabilities by the delta method, of first order in them. Flips that a cell has counted
are combined with those of the model.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln, ndtri

from ...base import text
from ...base.errors import RequestError
from ..records import Array, FlipStatistics, Index, Mask, PoseStatistics
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


def drop_afresh(
    dropped: PoseShares, wanted: Sequence[int], rate: float = math.nan
) -> Feeding:
    """Feed a part by dropping those again that lie wrong.

    `wanted`: indices of the poses that are accepted, at least one; `rate`: parts dropped a minute,
    those sent back included, above 0; NaN where it is not known.
    """
    kept = check_wanted(wanted, dropped.probability.size)
    if not math.isnan(rate):
        check_rate(rate)
    accepted = _accepted_share(dropped, kept)
    return Feeding(
        accepted,
        passes_of(*accepted),
        NO_FLIPS,
        Bounded(*(rate * one for one in accepted)),
    )


def passes_of(share: float, low: float, high: float) -> Bounded:
    """Drops that an accepted part takes where the others are dropped again."""
    return Bounded(*(1.0 / one if one else math.inf for one in (share, high, low)))


def flip_wrong_ones(
    dropped: PoseShares,
    counts: ArrayLike,
    wanted: Sequence[int],
    rate: float,
    cycle_time: float,
) -> Feeding:
    """Feed a part by kicking those that lie wrong until they lie right.

    A part that is dropped takes 60 / rate seconds, and each flip as long as a cycle. `counts`
    (K, K): flips out of each pose, by the pose in which they ended.
    """
    flips = np.asarray(counts, dtype=float)
    kept = check_wanted(wanted, dropped.probability.size)
    check_rate(rate, cycle_time)
    settled = flips.sum(axis=1)
    if not (settled[~kept] > 0.0).all():
        raise RequestError(
            "flips counted out of every pose that is not wanted",
            f"none out of pose {np.flatnonzero(~kept & (settled <= 0.0))[0]}",
            "simulate more flips",
        )
    if kept.all():
        return drop_afresh(dropped, wanted, rate)
    wrong = np.flatnonzero(~kept)
    shares = dropped.probability
    moves = flips[wrong] / settled[wrong, None]
    leaving = _that_get_out(moves, kept, wrong)
    if not leaving.all():
        # In the end a part lies there for ever; those that arrive before are accepted.
        out = wrong[leaving]
        moves = moves[leaving]
        arrive = np.linalg.solve(
            np.eye(out.size) - moves[:, out], moves[:, kept].sum(axis=1)
        )
        unknown = Bounded(math.nan, math.nan, math.nan)
        return Feeding(
            unknown._replace(value=float(shares[kept].sum() + shares[out] @ arrive)),
            unknown,
            unknown._replace(value=math.inf),
            Bounded(0.0, 0.0, math.nan),
        )
    value, error = _flips_needed(dropped, moves, flips[wrong], wrong)
    spread = spread_of(error / value) if value else 1.0
    needed = Bounded(value, value / spread, value * spread)
    certain = Bounded(1.0, 1.0, 1.0)
    return Feeding(
        certain,
        certain,
        needed,
        Bounded(
            *(
                60.0 / (60.0 / rate + one * cycle_time)
                for one in (value, needed.high, needed.low)
            )
        ),
    )


def spread_of(error: float) -> float:
    """Factor to the end of the 90 % interval of a positive number, whose logarithm is normal."""
    return math.exp(-float(ndtri(0.5 * (1.0 - DEFAULT_LEVEL))) * error)


def _flips_needed(
    dropped: PoseShares, moves: Array, flips: Array, wrong: Index
) -> tuple[float, float]:
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
    rows = smooth @ needed**2 - (smooth @ needed) ** 2
    variance = float(visits**2 @ (rows / flips.sum(axis=1)))
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


def _accepted_share(dropped: PoseShares, kept: Mask) -> Bounded:
    """Share of some poses; symmetry tells how a unit's share is shared out."""
    if kept.all():
        return Bounded(1.0, 1.0, 1.0)
    drops = dropped.drops
    share = min(1.0, float(dropped.probability[kept].sum()))
    if math.isnan(drops):
        return Bounded(share, math.nan, math.nan)
    if 0.0 < share < 1.0:
        scatter = dropped.scatter(kept.astype(np.float64))
        drops *= share * (1.0 - share) / scatter if scatter else math.inf
    if drops > CERTAIN:
        return Bounded(share, share, share)
    return Bounded(share, *map(float, jeffreys_interval(share * drops, drops)))


def check_wanted(wanted: Sequence[int], poses: int) -> Mask:
    """Which of all poses (K,) are accepted."""
    indices: list[Any] = list(wanted) if np.ndim(wanted) == 1 else [wanted]
    bad = [
        one
        for one in indices
        if isinstance(one, bool)
        or not isinstance(one, Integral)
        or not 0 <= int(one) < poses
    ]
    if bad or not indices:
        raise RequestError(
            f"wanted poses out of 0 to {poses - 1}, at least one",
            f"{bad[0]!r}" if bad else "none",
            "they are the `index` of the poses; `ros_pose_stats estimate` lists them",
        )
    kept = np.zeros(poses, dtype=np.bool_)
    kept[indices] = True
    return kept


def check_rate(rate: float, cycle_time: float = 0.0) -> None:
    """Refuse a rate of drops, and a time from kick to kick, that is none."""
    if not 0.0 < rate < math.inf:
        raise RequestError(
            "a rate above 0 parts a minute",
            f"{rate}",
            "count the parts that are dropped, those sent back included",
        )
    if not 0.0 <= cycle_time < math.inf:
        raise RequestError(
            "a cycle time of 0 s or more",
            f"{cycle_time}",
            "it is the time from one kick to the next",
        )


STRENGTHS = np.geomspace(3.0, 300.0, 9)
"""Flips that a row of the model may stand for, each as likely before any were counted: a row that
is 15 points off stands for some ten, one that is 5 points off for a hundred."""


def learn_flips(
    kicks: Sequence[FlipStatistics], counts: ArrayLike, feeder_speed: str = ""
) -> FlipStatistics:
    """Combine flips that were counted at one speed of a feeder with those of the model.

    The kick height is that of the model's kicks which explains the counts best. Each row is a
    Dirichlet about that kick's row, which stands for as many flips as agrees with how far the
    counts are from it. Poses that look alike share what was counted out of and into them.

    Parameters
    ----------
    kicks : sequence of FlipStatistics
        Of the model, of one part and scene with its poses, at least one.
    counts : (K, K) array of int
        Row i: flips out of pose i, by the pose in which they ended; 0 or more.
    feeder_speed : str
        Name of the speed.

    Returns
    -------
    FlipStatistics
        `transition` has the means, `standard_error` theirs, and `counts` the flips as which each
        row is known, those of the model included; `observed` is the number counted.

    Raises
    ------
    RequestError
        If the counts are not a whole number from 0 up from pose to pose, or there are no kicks.
    """
    counted = np.asarray(counts)
    if not kicks:
        raise RequestError(
            "flips of the model at one kick height or more", "none", "name kick heights"
        )
    check_alike(kicks)
    poses = kicks[0].counts.shape[0]
    if (
        counted.shape != (poses, poses)
        or counted.dtype.kind not in "iu"
        or (counted < 0).any()
    ):
        raise RequestError(
            f"{poses} rows of {poses} whole numbers from 0 up, a row a pose",
            f"{counted}",
            "count the flips from pose to pose, by their index",
        )
    member = np.equal.outer(
        [pose.group for pose in kicks[0].poses],
        sorted({pose.group for pose in kicks[0].poses}),
    ).astype(float)
    size = member.sum(axis=0)
    seen = member.T @ counted @ member
    rows = [
        (kick.counts + 0.5 / poses) / (kick.counts.sum(axis=1) + 0.5)[:, None]
        for kick in kicks
    ]
    models = [member.T @ row @ member for row in rows]
    evidence = np.array([_evidence(model, seen, size) for model in models])
    best = int(np.logaddexp.reduce(evidence, axis=1).argmax())
    weight = np.exp(evidence[best] - evidence[best].max())
    strength = float(np.exp(weight @ np.log(STRENGTHS) / weight.sum()))

    known = strength * models[best] + seen
    within = rows[best] / (rows[best] @ member @ member.T)
    flips = np.asarray(
        known.sum(axis=1) / size @ member.T
    )  # out of each pose, shared among twins
    between = known / known.sum(axis=1)[:, None]
    errors = np.sqrt(between * (1.0 - between) / (known.sum(axis=1) + 1.0)[:, None])
    moves, errors = (member @ each @ member.T * within for each in (between, errors))
    return replace(
        kicks[best],
        counts=flips[:, None] * moves,
        transition=moves,
        unsettled=np.zeros_like(kicks[best].unsettled),
        standard_error=errors,
        feeder_speed=feeder_speed,
        observed=int(counted.sum()),
    )


def check_alike(results: Sequence[PoseStatistics | FlipStatistics]) -> None:
    """Refuse results that are not about the same poses of the same part."""
    if (
        len(
            {
                (one.part_digest, one.cluster_tolerance, one.round_sides)
                for one in results
            }
        )
        > 1
    ):
        raise RequestError(
            "results of one part and its poses",
            text.listed(sorted({one.part_id for one in results})),
            "simulate all of them with the same part, cluster tolerance and "
            "round sides",
        )


def _evidence(model: Array, seen: Array | Index, size: Array) -> Array:
    """Log likelihoods (S,) of counts between groups about a model's rows, by the strength.

    `model` (G, G): shares, summed over the poses of a group, of which there are `size` (G,).
    """
    row, column = np.nonzero(seen)
    prior = STRENGTHS[:, None] * model[row, column]
    total = STRENGTHS[:, None] * size
    return np.asarray(
        (gammaln(prior + seen[row, column]) - gammaln(prior)).sum(axis=1)
        + (gammaln(total) - gammaln(total + seen.sum(axis=1))).sum(axis=1)
    )
