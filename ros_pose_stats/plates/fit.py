"""The restitution and the drop height that explain what was counted on a plate."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ..errors import RequestError
from ..statistics.chi_square import goodness_of_fit
from ..text import several
from .counts import CountedPart, merge_counts
from .likelihood import (
    SceneEstimate,
    averaged,
    most_likely,
    plausible_bounds,
    scene_likelihood,
)
from .response import Response, Shares
from .scenes import SceneGrid, SceneRange

Array = NDArray[np.float64]

FEWEST_COUNTS = 50
"""Parts of all kinds together."""

FIRST_POINTS, FIRST_DROPS = 192, 120
"""Scenes all over the range, and drops of each part at each."""

ROUNDS, POINTS = 3, 48
"""Times that drops follow at likely scenes, and how many scenes."""

FEWEST_DROPS, MOST_DROPS = 150, 1000
"""At each of these; between them a twelfth of what was counted, so that counts decide."""

FLATTENED = 0.3
"""Power of the likelihood that these scenes are drawn from: the unlikely are looked at too."""

GRID, FINER, FALL = 40, 24, 6.0
"""Values of each coordinate all over, and where the likelihood is within exp(-FALL)."""

UNCALIBRATED, UNCONFIRMED = 0.05, 0.02
"""Error of a plate that nothing was tested on, and least one until three parts agree."""

AGREE = 0.05
"""Least p-value with which parts agree."""


@dataclass(frozen=True, eq=False)
class PartEvidence:
    """What one part says about a plate.

    Attributes
    ----------
    part_id, part_digest : str
    counted : int
    poses : tuple of tuple of int
        Indices of the poses of each group, whose poses look alike.
    observed, expected : (G,) arrays
        Shares of the groups as counted, and in the fitted scene.
    error : float
        Root mean square of their difference, the noise of the counts taken off; 0 to 1.
    left_out_error : float
        The same in the scene that the other parts alone ask for; NaN where they ask for none.
    alone : SceneEstimate
        What this part alone asks for.
    """

    part_id: str
    part_digest: str
    counted: int
    poses: tuple[tuple[int, ...], ...]
    observed: Array
    expected: Array
    error: float
    left_out_error: float
    alone: SceneEstimate


@dataclass(frozen=True, eq=False)
class PlateFit:
    """The scene that stands for a plate.

    Attributes
    ----------
    restitution, drop_height : tuple of float
        Most likely value and the bounds of its 90 % interval; the height in metres.
    plate_error : float
        Expected root mean square error, over groups of poses, on a part that was not counted.
    p_value : float
        Of the counts in the fitted scene; NaN where nothing is left to test it.
    counted : int
        Parts of all kinds.
    parts : tuple of PartEvidence
    drops : int
        Of all parts, on which the fit rests.
    seconds : float
    """

    restitution: tuple[float, float, float]
    drop_height: tuple[float, float, float]
    plate_error: float
    p_value: float
    counted: int
    parts: tuple[PartEvidence, ...]
    drops: int = 0
    seconds: float = math.nan


class ExplainedPart(NamedTuple):
    """A counted part: its expected shares and its likelihood (S, n) at the scenes of a grid."""

    counted: CountedPart
    shares: Shares
    likelihood: Array


def fit_plate(counted: Sequence[CountedPart], *, seed: int = 0, workers: int | None = None,
              on_progress: Callable[[float], object] | None = None,
              should_stop: Callable[[], bool] | None = None,
              background: bool = False) -> PlateFit | None:
    """Fit restitution and drop height to counts by maximum likelihood.

    Every part is dropped at many scenes, first all over the range of `SceneRange`, then where the
    counts make scenes likely. From that a smooth response follows (`response`), whose own error
    is part of the likelihood. Where no scene explains the counts, the intervals are wider by
    that (`likelihood`).

    Parameters
    ----------
    counted : sequence of CountedPart
        Of one part or several; counts of one part are added up. Poses that look alike count
        together.
    seed : int
        Of the drops, at least 0; the same one gives the same fit.
    workers : int, optional
        Threads; default: all cores.
    on_progress : callable, optional
        Told what share of the drops is done.
    should_stop : callable, optional
        Once it returns True the fit is given up.
    background : bool
        Whether the drops give way to other threads.

    Returns
    -------
    PlateFit or None
        None where it was given up.

    Raises
    ------
    RequestError
        If the counts cannot tell restitution and drop height, with what is missing.
    """
    begin = time.perf_counter()
    told = [one for one in merge_counts(counted) if one.counted and one.free_shares]
    refuse_too_little(counted, told)
    within = SceneRange.of_radii([one.resting.body.radius for one in told])
    responses = [Response(one, within, (seed, number)) for number, one in enumerate(told)]
    grid = SceneGrid.over(within.bounds, GRID)
    points = [within.spread_points(FIRST_POINTS)]
    random = np.random.default_rng(seed)
    for stage in range(ROUNDS + 1):
        for number, (one, response) in enumerate(zip(told, responses, strict=True)):
            drops = FIRST_DROPS if stage == 0 else drops_for(one.counted)
            response.add_drops(points[-1], drops, workers, should_stop, background=background)
            if should_stop is not None and should_stop():
                return None
            if on_progress is not None:
                on_progress((stage + (number + 1) / len(told)) / (ROUNDS + 1))
        explained = [explain(one, response, grid) for one, response in
                     zip(told, responses, strict=True)]
        logarithm = averaged(join_likelihoods(explained))
        if stage < ROUNDS:
            points.append(likely_points(grid, logarithm, random, POINTS))
    grid = grid.refined(plausible_bounds(grid, logarithm, FALL), FINER)
    explained = [explain(one, response, grid) for one, response in
                 zip(told, responses, strict=True)]
    refuse_undecided(grid, within, explained)
    found = conclude(grid, explained)
    return PlateFit(found.restitution, found.drop_height, found.plate_error, found.p_value,
                    found.counted, found.parts, sum(one.drops for one in responses),
                    time.perf_counter() - begin)


def drops_for(counted: int) -> int:
    """Drops at each likely scene of a part of which so many were counted."""
    return min(max(counted // 12, FEWEST_DROPS), MOST_DROPS)


def likely_points(grid: SceneGrid, logarithm: Array, random: np.random.Generator,
                  count: int) -> Array:
    """Scenes (count, 2) drawn from a flattened likelihood, anywhere in the cells of the grid."""
    steps = [np.gradient(values) for values in (grid.restitution, grid.log_height)]
    weight = np.exp(FLATTENED * (logarithm - logarithm.max())) * np.outer(*steps).ravel()
    chosen = random.choice(weight.size, count, p=weight / weight.sum())
    row, column = np.divmod(chosen, grid.shape[1])
    jitter = random.uniform(-0.5, 0.5, (count, 2))
    jitter *= np.stack((steps[0][row], steps[1][column]), axis=1)
    low, high = grid.points[[0, -1]]
    return np.asarray(np.clip(grid.points[chosen] + jitter, low, high))


def explain(counted: CountedPart, response: Response, grid: SceneGrid) -> ExplainedPart:
    """Expected shares of a part at all scenes of a grid, and how likely they make its counts."""
    shares = response.shares_at(grid.points)
    return ExplainedPart(counted, shares,
                         scene_likelihood(counted.by_group.astype(np.float64), shares))


def join_likelihoods(explained: Sequence[ExplainedPart]) -> Array:
    """Logarithm (S, n) of the likelihood of all parts together."""
    return np.asarray(np.sum([one.likelihood for one in explained], axis=0))


def conclude(grid: SceneGrid, explained: Sequence[ExplainedPart]) -> PlateFit:
    """Fit a plate to parts whose shares are known at the scenes of a grid."""
    together = join_likelihoods(explained)
    best = most_likely(grid, averaged(together))
    parts = tuple(_evidence(one, together, best.place, grid, explained) for one in explained)
    p_value = _p_value(explained, best.place)
    return PlateFit(best.restitution, best.drop_height,
                    _plate_error(explained, parts, best.place, p_value), p_value,
                    sum(one.counted.counted for one in explained), parts)


def _evidence(one: ExplainedPart, together: Array, place: int, grid: SceneGrid,
              explained: Sequence[ExplainedPart]) -> PartEvidence:
    counts, group = one.counted.by_group, one.counted.resting.group
    left_out = math.nan
    if sum(each.counted.free_shares for each in explained if each is not one) >= 2:
        elsewhere = int(averaged(together - one.likelihood).argmax())
        left_out = _root(_square_error(one, elsewhere))
    return PartEvidence(
        one.counted.part.part_id, one.counted.part.digest, one.counted.counted,
        tuple(tuple(np.flatnonzero(group == each).tolist()) for each in range(counts.size)),
        counts / counts.sum(), one.shares.share[place], _root(_square_error(one, place)),
        left_out, most_likely(grid, averaged(one.likelihood)))


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


def _plate_error(explained: Sequence[ExplainedPart], parts: Sequence[PartEvidence], place: int,
                 p_value: float) -> float:
    """Expected error on a part that was not counted.

    It is that of each part in the scene that the others ask for. A mean of n squares is as likely
    too small as too large, but the error it leaves to be expected is larger by n / (n - 2), the
    mean of a variance given n normal deviations and no prior knowledge (Jeffreys). Where the
    others are too few, it is that in the fitted scene, for as many numbers as the fit left free.
    It is never below what counts so few would show by chance, nor below `UNCONFIRMED` until three
    parts agree.
    """
    together = join_likelihoods(explained)
    if not any(math.isnan(one.left_out_error) for one in parts):
        few = len(explained) / max(len(explained) - 2, 1)
        squares = [few * _square_error(one, int(averaged(together - one.likelihood).argmax()))
                   for one in explained]
    else:
        free = sum(one.counted.free_shares for one in explained)
        if free <= 2:
            return UNCALIBRATED
        squares = [_square_error(one, place) * free / (free - 2) for one in explained]
    chance = math.sqrt(sum(_chance(one, place) for one in explained)) / len(explained)
    found = math.sqrt(max(float(np.mean(squares)), chance))
    agreed = len(explained) >= 3 and p_value >= AGREE
    return found if agreed else max(found, UNCONFIRMED)


def _chance(one: ExplainedPart, place: int) -> float:
    """Variance of the mean square error over the groups that the counts alone make."""
    share = one.shares.share[place]
    spread = (np.diag(share) - np.outer(share, share)) / one.counted.counted
    return float(2.0 * np.square(spread).sum() / share.size ** 2)


def _p_value(explained: Sequence[ExplainedPart], place: int) -> float:
    """Chance of counts this far from the scene; two numbers were fitted to them."""
    statistic, free = 0.0, -2
    for one in explained:
        share = one.shares.share[place]
        errors = np.sqrt(share * (1.0 - share) * one.shares.dispersion[place])
        test = goodness_of_fit(one.counted.by_group, share, errors)
        if not test.too_few:
            statistic += test.statistic
            free += test.degrees_of_freedom
    return float(chdtrc(free, statistic)) if free > 0 else math.nan


def refuse_too_little(counted: Sequence[CountedPart], told: Sequence[CountedPart]) -> None:
    """Refuse counts from which two numbers cannot follow, whatever they are.

    Raises
    ------
    RequestError
    """
    free = sum(one.free_shares for one in told)
    if free < 2:
        mute = [one.part.part_id for one in counted if not one.free_shares]
        said = f" ({', '.join(mute)} can lie in one way only, which says nothing)" if mute else ""
        raise RequestError(
            "counts that tell two numbers, of a part that can lie in three ways or of two parts",
            f"{several(free, 'number')} from {several(len(told), 'part')}{said}",
            "count another part on this plate")
    total = sum(one.counted for one in told)
    if total < FEWEST_COUNTS:
        raise RequestError(f"at least {FEWEST_COUNTS} counted parts", f"{total}",
                           f"count {FEWEST_COUNTS - total} more")


def refuse_undecided(grid: SceneGrid, within: SceneRange,
                     explained: Sequence[ExplainedPart]) -> None:
    """Refuse counts that leave restitution and drop height anywhere in their range.

    Raises
    ------
    RequestError
    """
    logarithm = averaged(join_likelihoods(explained))
    found = most_likely(grid, logarithm)
    (slow, low), (fast, high) = within.bounds
    open_restitution = found.restitution[1] <= slow and found.restitution[2] >= fast
    open_height = (found.drop_height[1] <= math.exp(low) * 1.001
                   and found.drop_height[2] >= math.exp(high) * 0.999)
    if open_restitution and open_height:
        total = sum(one.counted.counted for one in explained)
        fall = float(logarithm.max() - logarithm.min())
        needed = math.ceil(total * max(4.0 / max(fall, 0.1), 2.0) / 10.0) * 10
        raise RequestError(
            "counts that tell some restitutions and drop heights from others",
            f"{total} of {several(len(explained), 'part')} that fit all of them alike",
            f"count about {needed}, or parts of other shapes")
