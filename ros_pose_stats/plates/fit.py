"""The restitution and the drop height that explain what was counted on a plate."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .. import errors, text
from . import counts, evidence, likelihood, plate_fit, round_parts, scenes
from .response import Response

Array = NDArray[np.float64]

FEWEST_COUNTS = 50
"""Parts of all kinds together."""

FIRST_POINTS, FIRST_DROPS = 192, 120
"""Scenes all over the range, and drops of each part at each."""

ROUNDS, POINTS = 3, 64
"""Times that drops follow at likely scenes, and how many scenes."""

FEWEST_DROPS, MOST_DROPS = 150, 1000
"""At each of these; between them a twelfth of what was counted, so that counts decide."""

FLATTENED = 0.3
"""Power of the likelihood that these scenes are drawn from: the unlikely are looked at too."""

GRID, FINER, FALL = 40, 24, 6.0
"""Values of each coordinate all over, and where the likelihood is within exp(-FALL)."""


def fit_plate(counted: Sequence[counts.CountedPart], *, seed: int = 0, workers: int | None = None,
              on_progress: Callable[[float], object] | None = None,
              should_stop: Callable[[], bool] | None = None,
              background: bool = False) -> plate_fit.PlateFit | None:
    """Fit restitution, drop height and what rolling loses to counts by maximum likelihood.

    Every part is dropped at many scenes, first all over the range of `SceneRange`, then where the
    counts make scenes likely. From that a smooth response follows (`response`), whose own error
    is part of the likelihood. Round parts are dropped with each number of sides of `round_parts`
    anew. Where no scene explains the counts, the intervals are wider by that (`likelihood`).

    `counted`: of one part or several; counts of one part are added up. Poses that look alike count
    together; `seed`: of the drops, at least 0; the same one gives the same fit; `on_progress`:
    told what share of the drops is done; `should_stop`: once it returns True the fit is given up;
    `background`: whether the drops give way to other threads. Returns none where it was given up.
    Raises RequestError if the counts cannot tell restitution and drop height, with what is
    missing.
    """
    begin = time.perf_counter()
    told = [one for one in counts.merge_counts(counted) if one.counted and one.free_shares]
    refuse_too_little(counted, told)
    within = scenes.SceneRange.of_radii([one.resting.body.radius for one in told])
    standing = round_parts.stand_on_sides(told)
    ways = {(number, one.round_sides): one
            for parts in standing.values() for number, one in enumerate(parts)}
    responses = {way: Response(one, within, (seed, way[0])) for way, one in ways.items()}

    def explain_all() -> evidence.Alternatives:
        explained = {way: explain(one, responses[way], grid) for way, one in ways.items()}
        return {sides: [explained[number, one.round_sides] for number, one in enumerate(parts)]
                for sides, parts in standing.items()}

    grid = scenes.SceneGrid.over(within.bounds, GRID)
    points = within.spread_points(FIRST_POINTS)
    random = np.random.default_rng(seed)
    for stage in range(ROUNDS + 1):
        for number, (way, response) in enumerate(responses.items(), start=1):
            drops = FIRST_DROPS if stage == 0 else drops_for(ways[way].counted)
            response.add_drops(points, drops, workers, should_stop, background=background)
            if should_stop is not None and should_stop():
                return None
            if on_progress is not None:
                on_progress((stage + number / len(responses)) / (ROUNDS + 1))
        if stage < ROUNDS:
            points = likely_points(grid, explain_all(), random, POINTS)
    weights = evidence.weigh_scenes(explain_all()).max(axis=0)
    grid = grid.refined(likelihood.plausible_bounds(grid, weights, FALL), FINER)
    explained = explain_all()
    refuse_undecided(grid, within, explained)
    return replace(evidence.conclude(grid, explained),
                   drops=sum(one.drops for one in responses.values()),
                   seconds=time.perf_counter() - begin)


def drops_for(counted: int) -> int:
    """Drops at each likely scene of a part of which so many were counted."""
    return min(max(counted // 12, FEWEST_DROPS), MOST_DROPS)


def likely_points(grid: scenes.SceneGrid, alternatives: evidence.Alternatives,
                  random: np.random.Generator,
                  count: int) -> Array:
    """Scenes (count, 2) drawn from flattened likelihoods, anywhere in the cells of the grid.

    Half of them are likely by all parts together, half if one of them is left out: what the others
    predict of it is asked for too.
    """
    steps = [np.gradient(values) for values in (grid.restitution, grid.log_height)]
    area = np.outer(*steps).ravel()
    weight = _flattened(evidence.weigh_scenes(alternatives).max(axis=0), area)
    parts = len(next(iter(alternatives.values())))
    if parts > 1:
        weight = 0.5 * weight + 0.5 * np.mean(
            [_flattened(evidence.weigh_scenes(alternatives, left_out).max(axis=0), area)
             for left_out in range(parts)], axis=0)
    chosen = random.choice(weight.size, count, p=weight / weight.sum())
    row, column = np.divmod(chosen, grid.shape[1])
    jitter = random.uniform(-0.5, 0.5, (count, 2))
    jitter *= np.stack((steps[0][row], steps[1][column]), axis=1)
    low, high = grid.points[[0, -1]]
    return np.asarray(np.clip(grid.points[chosen] + jitter, low, high))


def _flattened(logarithm: Array, area: Array) -> Array:
    """Weight (n,) of each cell, of sum 1."""
    weight = np.exp(FLATTENED * (logarithm - logarithm.max())) * area
    return np.asarray(weight / weight.sum())


def explain(counted: counts.CountedPart, response: Response,
            grid: scenes.SceneGrid) -> evidence.ExplainedPart:
    """Expected shares of a part at all scenes of a grid, and how likely they make its counts."""
    shares = response.shares_at(grid.points)
    return evidence.ExplainedPart(counted, shares,
                                  likelihood.scene_likelihood(counted.by_group.astype(np.float64),
                                                              shares))


def refuse_too_little(counted: Sequence[counts.CountedPart],
                      told: Sequence[counts.CountedPart]) -> None:
    """Refuse counts from which two numbers cannot follow, whatever they are.

    Raises RequestError.
    """
    free = sum(one.free_shares for one in told)
    if free < 2:
        mute = [one.part.part_id for one in counted if not one.free_shares]
        said = f" ({', '.join(mute)} can lie in one way only, which says nothing)" if mute else ""
        raise errors.RequestError(
            "counts that tell two numbers, of a part that can lie in three ways or of two parts",
            f"{text.several(free, 'number')} from {text.several(len(told), 'part')}{said}",
            "count another part on this plate")
    total = sum(one.counted for one in told)
    if total < FEWEST_COUNTS:
        raise errors.RequestError(f"at least {FEWEST_COUNTS} counted parts", f"{total}",
                                  f"count {FEWEST_COUNTS - total} more")


def refuse_undecided(grid: scenes.SceneGrid, within: scenes.SceneRange,
                     alternatives: evidence.Alternatives) -> None:
    """Refuse counts that leave restitution and drop height anywhere in their range.

    Raises RequestError.
    """
    logarithm = evidence.weigh_scenes(alternatives).max(axis=0)
    found = likelihood.most_likely(grid, logarithm)
    (slow, low), (fast, high) = within.bounds
    open_restitution = found.restitution[1] <= slow and found.restitution[2] >= fast
    open_height = (found.drop_height[1] <= math.exp(low) * 1.001
                   and found.drop_height[2] >= math.exp(high) * 0.999)
    if open_restitution and open_height:
        explained = next(iter(alternatives.values()))
        total = sum(one.counted.counted for one in explained)
        fall = float(logarithm.max() - logarithm.min())
        needed = math.ceil(total * max(4.0 / max(fall, 0.1), 2.0) / 10.0) * 10
        raise errors.RequestError(
            "counts that tell some restitutions and drop heights from others",
            f"{total} of {text.several(len(explained), 'part')} that fit all of them alike",
            f"count about {needed}, or parts of other shapes")
