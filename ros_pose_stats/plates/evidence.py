"""What counts say of a plate once it is known how likely each scene makes them."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ..statistics.chi_square import goodness_of_fit
from . import counts, plate_fit, response, round_parts, scenes
from .likelihood import REACH, SceneEstimate, averaged, most_likely

Array = NDArray[np.float64]

UNCALIBRATED, UNCONFIRMED = 0.05, 0.02
"""Error of a plate that nothing was tested on, and least one until three parts agree."""

AGREE = 0.05
"""Least p-value with which parts agree."""


class ExplainedPart(NamedTuple):
    """A counted part: its expected shares and its likelihood (S, n) at the scenes of a grid."""

    counted: counts.CountedPart
    shares: response.Shares
    likelihood: Array


Alternatives = Mapping[int, Sequence[ExplainedPart]]
"""All parts as they stand with each number of sides a turn; one number where none is round."""


def join_likelihoods(explained: Sequence[ExplainedPart]) -> Array:
    """Logarithm (S, n) of the likelihood of all parts together."""
    return np.asarray(np.sum([one.likelihood for one in explained], axis=0))


def weigh_scenes(alternatives: Alternatives, without: int | None = None) -> Array:
    """Logarithm (C, n) of the likelihood of each number of sides and scene.

    `without`: place of a part that is left out.
    """
    return np.array([
        averaged(join_likelihoods(parts)
                 - (0.0 if without is None else parts[without].likelihood))
        for parts in alternatives.values()])


def conclude(grid: scenes.SceneGrid, alternatives: Alternatives) -> plate_fit.PlateFit:
    """Fit a plate to parts whose shares are known at the scenes of a grid."""
    weights = weigh_scenes(alternatives)
    sides, place = _likeliest(alternatives, weights)
    explained = alternatives[sides]
    fitted = 2 + (len(alternatives) > 1)
    best = most_likely(grid, weights.max(axis=0))
    predicted = [_predict_part(alternatives, number) for number in range(len(explained))]
    parts = tuple(
        _evidence(one, place, left_out, most_likely(grid, averaged(one.likelihood)))
        for one, left_out in zip(explained, predicted, strict=True))
    p_value = _p_value(explained, place, fitted)
    return plate_fit.PlateFit(best.restitution, best.drop_height,
                              _plate_error(alternatives, sides, place, predicted, p_value),
                              p_value,
                              sum(one.counted.counted for one in explained), parts,
                              _sides_with_bounds(alternatives, sides, weights))


def _likeliest(alternatives: Alternatives, weights: Array) -> tuple[int, int]:
    """Number of sides and place on the grid; the first number of those as likely."""
    chosen, place = np.unravel_index(int(weights.argmax()), weights.shape)
    return list(alternatives)[int(chosen)], int(place)


def _sides_with_bounds(alternatives: Alternatives, sides: int,
                       weights: Array) -> tuple[int, int, int]:
    if len(alternatives) == 1:
        return round_parts.UNTOLD_SIDES
    likely = weights.max(axis=1) >= weights.max() - 0.5 * REACH
    left = [each for each, is_left in zip(alternatives, likely, strict=True) if is_left]
    return sides, min(left), max(left)


def _round_places(alternatives: Alternatives) -> list[int]:
    """Places of the parts that stand differently with another number of sides."""
    standing = zip(*alternatives.values(), strict=True)
    return [number for number, ways in enumerate(standing)
            if len({one.counted.round_sides for one in ways}) > 1]


def _predict_part(alternatives: Alternatives, left_out: int) -> ExplainedPart | None:
    """A part in the one scene that the others ask for; None where they ask for none."""
    explained = next(iter(alternatives.values()))
    others = sum(one.counted.free_shares for number, one in enumerate(explained)
                 if number != left_out)
    if others < 2 or _round_places(alternatives) == [left_out]:
        return None
    sides, place = _likeliest(alternatives, weigh_scenes(alternatives, left_out))
    return _in_scene(alternatives[sides][left_out], place)


def _in_scene(one: ExplainedPart, place: int) -> ExplainedPart:
    """The same at one scene of the grid only."""
    at = slice(place, place + 1)
    return ExplainedPart(one.counted,
                         response.Shares(one.shares.share[at], one.shares.dispersion[at]),
                         one.likelihood[:, at])


def _evidence(one: ExplainedPart, place: int, predicted: ExplainedPart | None,
              alone: SceneEstimate) -> plate_fit.PartEvidence:
    counts, group = one.counted.by_group, one.counted.resting.group
    return plate_fit.PartEvidence(
        one.counted.part.part_id, one.counted.part.digest, one.counted.counted,
        tuple(tuple(np.flatnonzero(group == each).tolist()) for each in range(counts.size)),
        counts / counts.sum(), one.shares.share[place], _root(_square_error(one, place)),
        math.nan if predicted is None else _root(_square_error(predicted, 0)), alone)


def _square_error(one: ExplainedPart, place: int) -> float:
    """Mean square error over the groups at a scene, free of the noise of counts and drops.

    It has no bias, so it may be below 0.
    """
    counts = one.counted.by_group
    observed, expected = counts / counts.sum(), one.shares.share[place]
    noise = (observed * (1.0 - observed)).mean() / max(counts.sum() - 1, 1)
    noise += (expected * (1.0 - expected)).mean() * one.shares.dispersion[place]
    return float(np.square(observed - expected).mean() - noise)


def _root(square: float) -> float:
    return math.sqrt(max(square, 0.0))


def _plate_error(alternatives: Alternatives, sides: int, place: int,
                 predicted: Sequence[ExplainedPart | None], p_value: float) -> float:
    """Expected error on a part that was not counted.

    It is that of each part in the scene that the others ask for; the only round part, which alone
    tells the number of sides, tests nothing. The root of a mean of n squares is on average too
    small by the root of (n - 1/2) / n, which is made up for. Where the others are too few, it is
    that in the fitted scene, for as many numbers as the fit left free. It is never below what
    counts so few would show by chance, nor below `UNCONFIRMED` until three parts agree.
    """
    explained, round_places = alternatives[sides], _round_places(alternatives)
    tested = [one for number, one in enumerate(predicted) if round_places != [number]]
    foretold = [one for one in tested if one is not None]
    if tested and len(foretold) == len(tested):
        few = len(foretold) / (len(foretold) - 0.5)
        squares = [few * _square_error(one, 0) for one in foretold]
        judged = [(one, 0) for one in foretold]
    else:
        fitted = 2 + (len(alternatives) > 1)
        free = sum(one.counted.free_shares for one in explained)
        if free <= fitted:
            return UNCALIBRATED
        squares = [_square_error(one, place) * free / (free - fitted) for one in explained]
        judged = [(one, place) for one in explained]
    chance = math.sqrt(sum(_chance(*one) for one in judged)) / len(judged)
    found = math.sqrt(max(float(np.mean(squares)), chance))
    agreed = len(judged) >= 3 and p_value >= AGREE
    return found if agreed else max(found, UNCONFIRMED)


def _chance(one: ExplainedPart, place: int) -> float:
    """Variance of the mean square error over the groups that the counts alone make."""
    share = one.shares.share[place]
    spread = (np.diag(share) - np.outer(share, share)) / one.counted.counted
    return float(2.0 * np.square(spread).sum() / share.size ** 2)


def _p_value(explained: Sequence[ExplainedPart], place: int, fitted: int) -> float:
    """Chance of counts this far from the scene, to which so many numbers were fitted."""
    statistic, free = 0.0, -fitted
    for one in explained:
        share = one.shares.share[place]
        errors = np.sqrt(share * (1.0 - share) * one.shares.dispersion[place])
        test = goodness_of_fit(one.counted.by_group, share, errors)
        if not test.too_few:
            statistic += test.statistic
            free += test.degrees_of_freedom
    return float(chdtrc(free, statistic)) if free > 0 else math.nan
