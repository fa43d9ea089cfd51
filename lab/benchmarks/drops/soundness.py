"""Effects of stopping and of thresholds on the answers, and the worth of even starts."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import PoseStatistics, simulate
from ros_pose_stats.core.kernels.drops.layout import DropRules

from ..results import Row, Section
from .dropper import RESTITUTIONS, Dropper

Array = NDArray[np.float64]

RESTITUTION = 0.5
LONG_SEED = 1_000_000

STOPPING_TIMED = (
    "`simulate` until its error is within {:.0%} with 90 % confidence, restitution {}, once for "
    "each of {} seeds; the mean probability of each pose against that of one long run of {} "
    "random drops. `largest bias`: of a pose, in points. `its errors`: the largest bias in units "
    "of its standard error, that of the mean and of the long run together; `rms` is the root mean "
    "square over the poses, 1 where there is no bias. `error / told`: root mean square error of a "
    "run over the expected error that it tells at its end; `kept`: share of the runs whose error "
    "is within the target, in %. Not times."
)


def stopping(
    droppers: Sequence[Dropper], target: float, seeds: int, drops: int
) -> Section:
    """A row for each body.

    Parameters
    ----------
    droppers : sequence of Dropper
    target : float
    seeds : int
        Runs that stop.
    drops : int
        Of the long run.
    """
    rows = []
    for dropper in droppers:
        long = simulate(dropper.part, drops, RESTITUTION, LONG_SEED)
        known = _probabilities(long)
        known_square = known * (1.0 - known) / drops
        rows.append(_stopping_row(dropper, target, seeds, known, known_square))
    return Section(
        "drop_stopping",
        "Stopping at a wanted error",
        STOPPING_TIMED.format(target, RESTITUTION, seeds, drops),
        tuple(rows),
    )


def _stopping_row(
    dropper: Dropper, target: float, seeds: int, known: Array, known_square: Array
) -> Row:
    run = partial(
        simulate, dropper.part, 100_000, RESTITUTION, target_error=target, workers=1
    )
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        runs = list(pool.map(lambda seed: run(seed=seed), range(seeds)))
    found = np.array([_probabilities(each) for each in runs])
    bias = found.mean(axis=0) - known
    error = np.sqrt(found.var(axis=0, ddof=1) / seeds + known_square)
    seen = error > 0.0
    told = np.mean([each.expected_error**2 for each in runs]) ** 0.5
    return Row(
        f"{dropper.vertices} vertices",
        {
            "poses": len(known),
            "drops a run": float(np.mean([each.drops for each in runs])),
            "largest bias, points": 100.0 * float(np.abs(bias).max()),
            "its errors": float((np.abs(bias[seen]) / error[seen]).max(initial=0.0)),
            "rms": float(np.mean((bias[seen] / error[seen]) ** 2) ** 0.5),
            "error / told": float(np.mean((found - known) ** 2) ** 0.5 / told),
            "kept": 100.0
            * float(np.mean(np.mean((found - known) ** 2, axis=1) <= target**2)),
        },
    )


def _probabilities(statistics: PoseStatistics) -> Array:
    """Probabilities by `index`."""
    ranked = sorted(statistics.poses, key=lambda pose: pose.index)
    return np.array([pose.probability for pose in ranked])


FACTORS = (0.04, 4.0)

THRESHOLDS_TIMED = (
    "The speed below which a series of impacts is cut off and `TOUCHING` (within which a vertex "
    "takes part) multiplied by the factor, `SOFT` and `SOFT_SHARE` (the energy that cutting off "
    "may cost) and `TRUNCATION` by its square: × 0.04 is at restitution 0.5 what appendix B has. "
    "Every body ({}) is dropped {} times from the same starts as with the thresholds as they are. "
    "`ended otherwise`: share of drops that came to another pose. `largest change`: of "
    "a pose's probability, in points. `its errors`: the largest change in units of its own "
    "standard error, the root of the number of drops that came to or left the pose; the largest "
    "of that many independent ones is about `by chance`. `rate`: over that with the thresholds "
    "as they are."
)


class Change(NamedTuple):
    """Changes by a factor on one body: share of drops, largest change, and that in its errors."""

    otherwise: int
    largest: float
    errors: float
    compared: int
    seconds: float
    before: float


def scale_thresholds(rules: DropRules, factor: float) -> DropRules:
    """Multiply the thresholds of the rules."""
    return rules._replace(
        slow=factor * rules.slow,
        touching=factor * rules.touching,
        soft=factor**2 * rules.soft,
        soft_share=factor**2 * rules.soft_share,
        truncation=factor**2 * rules.truncation,
    )


def thresholds(droppers: Sequence[Dropper], drops: int) -> Section:
    """A row for each restitution and factor, over all bodies."""
    rows = []
    for restitution in RESTITUTIONS:
        changes = [list(_changes(dropper, restitution, drops)) for dropper in droppers]
        rows += [
            _thresholds_row(restitution, factor, [each[i] for each in changes], drops)
            for i, factor in enumerate(FACTORS)
        ]
    names = ", ".join(
        f"{dropper.name}, {dropper.vertices} vertices" for dropper in droppers
    )
    return Section(
        "drop_thresholds",
        "What the thresholds change",
        THRESHOLDS_TIMED.format(names, drops),
        tuple(rows),
    )


def _changes(dropper: Dropper, restitution: float, drops: int) -> Iterator[Change]:
    rules = dropper.rules(restitution)
    known, before = _timed(dropper, rules, drops)
    for factor in FACTORS:
        found, seconds = _timed(dropper, scale_thresholds(rules, factor), drops)
        moved = found != known
        came, left = (
            np.bincount(each[moved] + 1, minlength=dropper.poses + 1)
            for each in (found, known)
        )
        # One row more than poses: drops that did not settle count as a pose of their own.
        change = (came - left) / drops
        error = np.sqrt(came + left) / drops
        seen = error > 0.0
        yield Change(
            int(moved.sum()),
            float(np.abs(change).max()),
            float((np.abs(change)[seen] / error[seen]).max(initial=0.0)),
            int(seen.sum()),
            seconds,
            before,
        )


def _timed(
    dropper: Dropper, rules: DropRules, drops: int
) -> tuple[NDArray[np.int64], float]:
    begin = time.process_time()
    pose = dropper.drop(rules, 1, drops).pose
    return pose, time.process_time() - begin


def _thresholds_row(
    restitution: float, factor: float, changes: Sequence[Change], drops: int
) -> Row:
    compared = sum(change.compared for change in changes)
    return Row(
        f"restitution {restitution}, thresholds × {factor:g}",
        {
            "ended otherwise": sum(each.otherwise for each in changes)
            / drops
            / len(changes),
            "largest change, points": 100.0 * max(each.largest for each in changes),
            "its errors": max(each.errors for each in changes),
            "by chance": _largest_by_chance(compared),
            "poses": compared,
            "rate": sum(each.before for each in changes)
            / sum(each.seconds for each in changes),
        },
    )


def _largest_by_chance(number: int) -> float:
    """Median of the largest of some normally distributed numbers, in absolute terms."""
    if number == 0:
        return 0.0
    draws = np.random.default_rng(0).standard_normal((2000, number))
    return float(np.median(np.abs(draws).max(axis=1)))
