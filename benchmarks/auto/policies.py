"""One method for all parts: which estimator, or how many drops."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import Part, PoseStatistics, estimate, hybrid, simulate
from ros_pose_stats.estimators.registry import ESTIMATORS
from ros_pose_stats.statistics.posterior import PosePrior

from .cases import Case

Array = NDArray[np.float64]

KEPT = 0.9

Run = Callable[[Part, Case], PoseStatistics]
"""Answers for the part of a case, which has nothing remembered."""


class Policy(NamedTuple):
    """One method for all parts."""

    name: str
    kept: float
    run: Run
    drops: int


def spent_on(case: Case, run: Run) -> tuple[PoseStatistics, float]:
    """Answer and processor seconds, which other programs do not lengthen much."""
    part = case.part()
    begin = time.process_time()
    found = run(part, case)
    return found, time.process_time() - begin


def best_policy(cases: Sequence[Case], priors: Sequence[PosePrior], some: Sequence[Case],
                target: float) -> tuple[Policy, float]:
    """The fastest of the policies that keep the target often enough."""
    timed = [(policy, float(np.mean([spent_on(one, policy.run)[1] for one in some])))
             for policy in (*_estimates(cases, target), *_drops(cases, priors, target))
             if policy.kept >= KEPT]
    return min(timed, key=lambda pair: pair[1])


def _estimates(cases: Sequence[Case], target: float) -> list[Policy]:
    """The most accurate estimator: all take the same time but for some per cent."""
    def share(name: str) -> float:
        return _kept(cases, [ESTIMATORS[name].function(
            one.resting(), one.scene()) for one in cases], target)

    shares = {name: share(name) for name in ESTIMATORS}
    best = max(shares, key=lambda name: shares[name])
    return [Policy(best, shares[best], lambda part, one: estimate(
        part, best, restitution=one.restitution, cluster_tolerance=one.tolerance), 0)]


def _drops(cases: Sequence[Case], priors: Sequence[PosePrior], target: float) -> list[Policy]:
    """Hybrid and simulation, each with as few drops as keep the target."""
    found = []
    for drops in _steps(cases[0].sequence.size):
        kept = _kept(cases, [prior.updated(one.counts(drops)).probability
                             for one, prior in zip(cases, priors, strict=True)], target)
        if kept >= KEPT:
            found.append(Policy(f"hybrid, {drops} drops", kept, _hybrid(drops), drops))
            break
    for drops in _steps(cases[0].sequence.size):
        kept = _kept(cases, [one.counts(drops) / drops for one in cases], target)
        if kept >= KEPT:
            found.append(Policy(f"simulation, {drops} drops", kept, _simulation(drops), drops))
            break
    return found


def _hybrid(drops: int) -> Run:
    return lambda part, one: hybrid(part, drops, one.restitution, 5, workers=1,
                                    cluster_tolerance=one.tolerance)


def _simulation(drops: int) -> Run:
    return lambda part, one: simulate(part, drops, one.restitution, 5, workers=1,
                                      cluster_tolerance=one.tolerance)


def _kept(cases: Sequence[Case], answers: Sequence[Array], target: float) -> float:
    return float(np.mean([one.square_error(answer) <= target ** 2
                          for one, answer in zip(cases, answers, strict=True)]))


def _steps(most: int) -> list[int]:
    """Numbers of drops, each about a tenth more than the one before."""
    steps = [1]
    while steps[-1] < most:
        steps.append(min(max(steps[-1] + 1, int(1.1 * steps[-1])), most))
    return steps
