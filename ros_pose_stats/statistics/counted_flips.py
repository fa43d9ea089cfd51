"""Flips that a cell has counted, and those of the model where few were counted."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln

from .. import text
from ..errors import RequestError
from ..records import Array, FlipStatistics, Index, PoseStatistics

STRENGTHS = np.geomspace(3.0, 300.0, 9)
"""Flips that a row of the model may stand for, each as likely before any were counted: a row that
is 15 points off stands for some ten, one that is 5 points off for a hundred."""


def learn_flips(kicks: Sequence[FlipStatistics], counts: ArrayLike,
                feeder_speed: str = "") -> FlipStatistics:
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
        raise RequestError("flips of the model at one kick height or more", "none",
                           "name kick heights")
    check_alike(kicks)
    poses = kicks[0].counts.shape[0]
    if counted.shape != (poses, poses) or counted.dtype.kind not in "iu" or (counted < 0).any():
        raise RequestError(f"{poses} rows of {poses} whole numbers from 0 up, a row a pose",
                           f"{counted}", "count the flips from pose to pose, by their index")
    member = np.equal.outer([pose.group for pose in kicks[0].poses],
                            sorted({pose.group for pose in kicks[0].poses})).astype(float)
    size = member.sum(axis=0)
    seen = member.T @ counted @ member
    rows = [(kick.counts + 0.5 / poses) / (kick.counts.sum(axis=1) + 0.5)[:, None]
            for kick in kicks]
    models = [member.T @ row @ member for row in rows]
    evidence = np.array([_evidence(model, seen, size) for model in models])
    best = int(np.logaddexp.reduce(evidence, axis=1).argmax())
    weight = np.exp(evidence[best] - evidence[best].max())
    strength = float(np.exp(weight @ np.log(STRENGTHS) / weight.sum()))

    known = strength * models[best] + seen
    within = rows[best] / (rows[best] @ member @ member.T)
    flips = np.asarray(known.sum(axis=1) / size @ member.T)  # out of each pose, shared among twins
    between = known / known.sum(axis=1)[:, None]
    errors = np.sqrt(between * (1.0 - between) / (known.sum(axis=1) + 1.0)[:, None])
    moves, errors = (member @ each @ member.T * within for each in (between, errors))
    return replace(kicks[best], counts=flips[:, None] * moves, transition=moves,
                   unsettled=np.zeros_like(kicks[best].unsettled), standard_error=errors,
                   feeder_speed=feeder_speed, observed=int(counted.sum()))


def check_alike(results: Sequence[PoseStatistics | FlipStatistics]) -> None:
    """Refuse results that are not about the same poses of the same part."""
    if len({(one.part_digest, one.cluster_tolerance, one.round_sides) for one in results}) > 1:
        raise RequestError("results of one part and its poses",
                           text.listed(sorted({one.part_id for one in results})),
                           "simulate all of them with the same part, cluster tolerance and "
                           "round sides")


def _evidence(model: Array, seen: Array | Index, size: Array) -> Array:
    """Log likelihoods (S,) of counts between groups about a model's rows, by the strength.

    `model` (G, G): shares, summed over the poses of a group, of which there are `size` (G,).
    """
    row, column = np.nonzero(seen)
    prior = STRENGTHS[:, None] * model[row, column]
    total = STRENGTHS[:, None] * size
    return np.asarray((gammaln(prior + seen[row, column]) - gammaln(prior)).sum(axis=1)
                      + (gammaln(total) - gammaln(total + seen.sum(axis=1))).sum(axis=1))
