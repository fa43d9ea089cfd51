"""`auto` beside the best fixed method for all parts."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import Part, PoseStatistics, auto, estimate, hybrid, simulate
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.statistics.prior import PosePrior

from ..results import Row, Section, Target
from .cases import Case, probabilities

Array = NDArray[np.float64]

TARGETS = (0.05, 0.03, 0.02, 0.01)
SLOWER = 1.5
TIMED_EVERY = 8
"""Fixed methods, and `auto` beside them, are timed on every so many cases. Families and
restitutions take turns, and their numbers have no common divisor with this one, so that all of
them are among these cases."""

TIMED = (
    "`auto(part, target)` on {} parts at three restitutions, on one thread. `kept`: share of the "
    "cases whose true root mean square error over the poses is within the target, in %; the "
    "truth is {} other drops, their noise taken off. `best single`: the fastest of the most "
    "accurate estimator, and of hybrid and simulation with one number of drops for all parts, "
    "that keeps the target in {:.0%} of the cases too, judged with hindsight on these very cases. "
    "Milliseconds are processor time a part from a new `Part` on, poses and all, mean over one "
    "case in {}."
)

FAMILIES = (
    "Share of the same cases of each family whose true error is within the target, in %. `error`: "
    "standard error of a share of 90 % of so many cases. Not times."
)


def choosing(cases: Sequence[Case]) -> tuple[Section, Section]:
    """Table of the targets, a row each and one for all, and table of the families."""
    priors = [one.prior() for one in cases]
    some = cases[::TIMED_EVERY]
    rows = []
    totals = np.zeros(2)
    kept_all = []
    for target in TARGETS:
        answers = [_auto(one, target) for one in cases]
        kept = np.array(
            [
                one.square_error(probabilities(found)) <= target**2
                for one, (found, _) in zip(cases, answers, strict=True)
            ]
        )
        policy, spent = best_policy(cases, priors, some, target)
        seconds = float(np.mean([spent for _, spent in answers[::TIMED_EVERY]]))
        rows.append(
            _row(
                f"auto, {100.0 * target:g} points",
                kept,
                seconds,
                policy.name,
                policy.kept,
                spent,
                Counter(found.method for found, _ in answers),
            )
        )
        totals += seconds, spent
        kept_all.append(kept)
    rows.append(
        _row(
            "auto, all",
            np.concatenate(kept_all),
            float(totals[0]),
            "each its own",
            KEPT,
            float(totals[1]),
            Counter(),
        )
    )
    about = TIMED.format(
        len({one.number for one in cases}),
        int(cases[0].reference.sum()),
        KEPT,
        TIMED_EVERY,
    )
    return (
        Section("auto", "The cheapest method for a target error", about, tuple(rows)),
        _families(cases, np.array(kept_all)),
    )


def _families(cases: Sequence[Case], kept: NDArray[np.bool_]) -> Section:
    """Table of the families, from which case (T, C) kept each target."""
    family = np.array([one.family for one in cases])
    rows = []
    for name in np.unique(family).tolist():
        where = family == name
        shares = {
            f"{100.0 * target:g} points": 100.0 * float(each[where].mean())
            for target, each in zip(TARGETS, kept, strict=True)
        }
        error = math.sqrt(KEPT * (1.0 - KEPT) / where.sum())
        rows.append(
            Row(
                name,
                {
                    "cases": int(where.sum()),
                    "error": 100.0 * error,
                    **shares,
                    "all": 100.0 * float(kept[:, where].mean()),
                },
            )
        )
    return Section("auto_families", "Targets kept by family", FAMILIES, tuple(rows))


def _row(
    name: str,
    kept: NDArray[np.bool_],
    seconds: float,
    single: str,
    single_kept: float,
    spent: float,
    methods: Counter[str],
) -> Row:
    share = float(kept.mean())
    ratio = seconds / spent
    return Row(
        name,
        {
            "kept": 100.0 * share,
            "auto, ms": 1e3 * seconds,
            "used": ", ".join(
                f"{method} {times}" for method, times in methods.most_common()
            )
            or "-",
            "best single": single,
            "its kept": 100.0 * single_kept,
            "its ms": 1e3 * spent,
            "auto / single": ratio,
        },
        (
            Target("kept", share, KEPT, at_least=True),
            Target("auto / single", ratio, SLOWER),
        ),
    )


def _auto(case: Case, target: float) -> tuple[PoseStatistics, float]:
    return spent_on(
        case,
        lambda part, one: auto(
            part,
            target,
            restitution=one.restitution,
            seed=77_000 + one.number,
            workers=1,
            **one.options,
        ),
    )


KEPT = 0.9

Run = Callable[[Part, Case], PoseStatistics]
"""Answers for the part of a case, made anew with nothing prepared."""


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


def best_policy(
    cases: Sequence[Case],
    priors: Sequence[PosePrior],
    some: Sequence[Case],
    target: float,
) -> tuple[Policy, float]:
    """The fastest of the policies that keep the target often enough."""
    timed = [
        (policy, float(np.mean([spent_on(one, policy.run)[1] for one in some])))
        for policy in (*_estimates(cases, target), *_drops(cases, priors, target))
        if policy.kept >= KEPT
    ]
    return min(timed, key=lambda pair: pair[1])


def _estimates(cases: Sequence[Case], target: float) -> list[Policy]:
    """The most accurate estimator; all take the same time but for some per cent."""

    def share(name: str) -> float:
        return _share_kept(
            cases,
            [ESTIMATORS[name].function(one.resting(), one.scene()) for one in cases],
            target,
        )

    shares = {name: share(name) for name in ESTIMATORS}
    best = max(shares, key=lambda name: shares[name])
    return [
        Policy(
            best,
            shares[best],
            lambda part, one: estimate(
                part, best, restitution=one.restitution, **one.options
            ),
            0,
        )
    ]


def _drops(
    cases: Sequence[Case], priors: Sequence[PosePrior], target: float
) -> list[Policy]:
    """Hybrid and simulation, each with as few drops as keep the target."""
    found = []
    for drops in _steps(cases[0].sequence.size):
        kept = _share_kept(
            cases,
            [
                prior.updated(one.counts(drops)).probability
                for one, prior in zip(cases, priors, strict=True)
            ],
            target,
        )
        if kept >= KEPT:
            found.append(Policy(f"hybrid, {drops} drops", kept, _hybrid(drops), drops))
            break
    for drops in _steps(cases[0].sequence.size):
        kept = _share_kept(cases, [one.counts(drops) / drops for one in cases], target)
        if kept >= KEPT:
            found.append(
                Policy(f"simulation, {drops} drops", kept, _simulation(drops), drops)
            )
            break
    return found


def _hybrid(drops: int) -> Run:
    return lambda part, one: hybrid(
        part, drops, one.restitution, 5, workers=1, **one.options
    )


def _simulation(drops: int) -> Run:
    return lambda part, one: simulate(
        part, drops, one.restitution, 5, workers=1, **one.options
    )


def _share_kept(
    cases: Sequence[Case], answers: Sequence[Array], target: float
) -> float:
    return float(
        np.mean(
            [
                one.square_error(answer) <= target**2
                for one, answer in zip(cases, answers, strict=True)
            ]
        )
    )


def _steps(most: int) -> list[int]:
    """Numbers of drops, each about a tenth more than the one before."""
    steps = [1]
    while steps[-1] < most:
        steps.append(min(max(steps[-1] + 1, int(1.1 * steps[-1])), most))
    return steps
