"""Whether stopping at a wanted error favours some poses."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import PoseStatistics, simulate

from ..results import Row, Section
from .dropper import Dropper

Array = NDArray[np.float64]

RESTITUTION = 0.5
LONG_SEED = 1_000_000

TIMED = (
    "`simulate` until its expected error is down to {:.0%}, restitution {}, once for each of {} "
    "seeds; the mean probability of each pose against that of one long run of {} random drops. "
    "`largest bias`: of a pose, in points. `its errors`: the largest bias in units of its "
    "standard error, that of the mean and of the long run together; `rms` is the root mean "
    "square over the poses, 1 where there is no bias. `error / told`: root mean square "
    "error of a run over the expected error that it tells at its end. Not times.")


def stopping(droppers: Sequence[Dropper], target: float, seeds: int, drops: int) -> Section:
    """A row for each body and sampling.

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
        for sampling in ("random", "lattice"):
            rows.append(_row(dropper, sampling, target, seeds, known, known_square))
    return Section("drop_stopping", "Stopping at a wanted error",
                   TIMED.format(target, RESTITUTION, seeds, drops), tuple(rows))


def _row(dropper: Dropper, sampling: str, target: float, seeds: int, known: Array,
         known_square: Array) -> Row:
    run = partial(simulate, dropper.part, 100_000, RESTITUTION, target_error=target, workers=1,
                  sampling=sampling)
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        runs = list(pool.map(lambda seed: run(seed=seed), range(seeds)))
    found = np.array([_probabilities(each) for each in runs])
    bias = found.mean(axis=0) - known
    error = np.sqrt(found.var(axis=0, ddof=1) / seeds + known_square)
    seen = error > 0.0
    told = np.mean([each.expected_error**2 for each in runs]) ** 0.5
    return Row(f"{dropper.vertices} vertices, {sampling}", {
        "poses": len(known), "drops a run": float(np.mean([each.drops for each in runs])),
        "largest bias, points": 100.0 * float(np.abs(bias).max()),
        "its errors": float((np.abs(bias[seen]) / error[seen]).max(initial=0.0)),
        "rms": float(np.mean((bias[seen] / error[seen]) ** 2) ** 0.5),
        "error / told": float(np.mean((found - known) ** 2) ** 0.5 / told),
    })


def _probabilities(statistics: PoseStatistics) -> Array:
    """By index."""
    ranked = sorted(statistics.poses, key=lambda pose: pose.index)
    return np.array([pose.probability for pose in ranked])
