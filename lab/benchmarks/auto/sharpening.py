"""Error of estimate and drops together, beside that of either alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators.estimate import estimator
from ros_pose_stats.core.statistics.fitted_prior import FITTED_METHOD
from ros_pose_stats.core.statistics.posterior import Kinds
from ros_pose_stats.core.statistics.prior import PosePrior

from ..results import Row, Section, Target
from .cases import Case

Array = NDArray[np.float64]
Answer = Callable[[int], Array]

DROPS = (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000)
RARE = 0.01
WORSE = 1.02
LEVEL = 0.9
OFF = 0.03
ERRORS = (0.03, 0.02, 0.015, 0.01)
HALF = 0.5

ERROR_TIMED = (
    "Root mean square error over all poses, in points, against {} reference drops of each part "
    "with their noise taken off; {} parts that no fit has seen, of {} families in turn, at "
    "restitution 0.2, 0.5 and 0.8. `estimate`: {} alone; `drops`: count / n; "
    "`hybrid`: both. `told`: root mean square of hybrid's expected errors. Not times."
)
COVERAGE_TIMED = (
    "Share of the poses whose reference probability lies in hybrid's 90 % interval, in %, after "
    "n drops; for all poses, for those whose reference is below 1 %, and for those whose "
    "estimate is. Intervals and bound are widened by the noise of the reference. `bound kept`: "
    "share of the parts whose error is within hybrid's 90 % bound. Not times."
)
NEEDED_TIMED = (
    "Drops at which the root mean square error over the same parts is down to the first column, "
    "in points, interpolated between rows of drops half as many again. Not times."
)


def sharpening(cases: Sequence[Case]) -> Section:
    """Table of errors, a row for each number of drops."""
    priors = [one.prior() for one in cases]
    alone = math.sqrt(_mean_square(cases, [_estimate(one) for one in cases]))
    rows = []
    for drops in DROPS:
        after = [
            prior.updated(one.counts(drops))
            for one, prior in zip(cases, priors, strict=True)
        ]
        both = math.sqrt(_mean_square(cases, [one.probability for one in after]))
        counted = math.sqrt(
            _mean_square(cases, [one.counts(drops) / drops for one in cases])
        )
        poses = [one.reference.size for one in cases]
        told = np.average([one.expected_error**2 for one in after], weights=poses)
        ratio = both / min(alone, counted)
        rows.append(
            Row(
                f"hybrid, {drops} drops",
                {
                    "estimate": 100.0 * alone,
                    "drops": 100.0 * counted,
                    "hybrid": 100.0 * both,
                    "told": 100.0 * math.sqrt(told),
                    "hybrid / better": ratio,
                },
                (Target("hybrid / better", ratio, WORSE),),
            )
        )
    reference = int(cases[0].reference.sum())
    return Section(
        "hybrid_error",
        "Estimate and drops combined",
        ERROR_TIMED.format(
            reference,
            len({one.number for one in cases}),
            len({one.family for one in cases}),
            FITTED_METHOD,
        ),
        tuple(rows),
    )


def coverage(cases: Sequence[Case]) -> Section:
    """Table of coverage, a row for each number of drops; 0 is the estimate alone."""
    priors = [one.prior() for one in cases]
    true = np.concatenate([one.reference / one.reference.sum() for one in cases])
    estimated = np.concatenate([_estimate(one) for one in cases])
    kinds = {
        "all": np.ones(true.size, dtype=bool),
        "below 1 %": true < RARE,
        "estimate below 1 %": estimated < RARE,
    }
    rows = []
    for drops in (0, *DROPS):
        inside = np.concatenate(
            [
                intervals_hold(one, prior, drops)
                for one, prior in zip(cases, priors, strict=True)
            ]
        )
        shares = {
            name: float(inside[kind].mean())
            for name, kind in kinds.items()
            if kind.any()
        }
        kept = np.mean(
            [
                bound_holds(one, prior, drops)
                for one, prior in zip(cases, priors, strict=True)
            ]
        )
        rows.append(
            Row(
                f"hybrid, {drops} drops",
                {
                    **{
                        name: 100.0 * shares[name] if name in shares else "-"
                        for name in kinds
                    },
                    "bound kept": 100.0 * float(kept),
                },
                _off(shares),
            )
        )
    return Section(
        "hybrid_coverage", "How well hybrid knows itself", COVERAGE_TIMED, tuple(rows)
    )


def drops_needed(cases: Sequence[Case]) -> Section:
    """Table of the drops that some errors take, counted alone and with the estimate."""
    priors = [one.prior() for one in cases]
    steps = [10]
    while steps[-1] < cases[0].sequence.size * 2 // 3:
        steps.append(steps[-1] * 3 // 2)
    ways: dict[str, Callable[[Case, PosePrior, int], Array]] = {
        "drops": lambda one, _, n: one.counts(n) / n,
        "hybrid": lambda one, prior, n: prior.updated(one.counts(n)).probability,
    }
    curves = {
        name: [
            _mean_square(
                cases,
                [way(one, prior, n) for one, prior in zip(cases, priors, strict=True)],
            )
            for n in steps
        ]
        for name, way in ways.items()
    }
    rows = []
    for error in ERRORS:
        cells = {
            name: _crossing(steps, curve, error**2) for name, curve in curves.items()
        }
        ratio = cells["hybrid"] / cells["drops"]
        limit = HALF if error >= 0.02 else 1.0
        rows.append(
            Row(
                f"hybrid, {100.0 * error:g} points",
                {**cells, "hybrid / drops": ratio},
                (Target("hybrid / drops", ratio, limit),),
            )
        )
    return Section("hybrid_needed", "Drops for an error", NEEDED_TIMED, tuple(rows))


def _estimate(case: Case) -> Array:
    return estimator(FITTED_METHOD).function(case.resting(), case.scene())


def _mean_square(cases: Sequence[Case], answers: Sequence[Array]) -> float:
    """Mean square error over the poses of all cases."""
    poses = [one.reference.size for one in cases]
    return float(
        np.average(
            [
                one.square_error(answer)
                for one, answer in zip(cases, answers, strict=True)
            ],
            weights=poses,
        )
    )


def intervals_hold(case: Case, prior: PosePrior, drops: int) -> NDArray[np.bool_]:
    """Whether the interval of each pose (P,) holds its reference, with the reference's noise."""
    after = prior.updated(case.counts(drops))
    total = int(case.reference.sum())
    share, mean, variance = after.kinds
    each = mean / after.size
    noisy = Kinds(share, each, variance / after.size**2 + each * (1.0 - each) / total)
    low, high = replace(after, kinds=noisy, size=np.ones_like(after.size)).interval(
        LEVEL
    )
    true = case.reference / total
    return (low <= true) & (true <= high)


def bound_holds(case: Case, prior: PosePrior, drops: int) -> bool:
    """Whether the distance to the reference is within the bound, both with its noise."""
    after = prior.updated(case.counts(drops))
    s = case.reference / case.reference.sum()
    noise = float(np.mean(s * (1.0 - s))) / case.reference.sum()
    apart = float(np.mean(np.square(after.probability - s)))
    square = after.expected_error**2
    scale = 1.0 + noise / square if square > 0.0 else 1.0
    return apart <= after.error_quantile() ** 2 * scale + (
        noise if square == 0.0 else 0.0
    )


def _off(shares: dict[str, float]) -> tuple[Target, ...]:
    """The coverage that is farthest from the level."""
    worst = max(shares, key=lambda name: abs(shares[name] - LEVEL))
    return (Target(f"off the level, {worst}", abs(shares[worst] - LEVEL), OFF),)


def _crossing(steps: Sequence[int], squares: Sequence[float], wanted: float) -> float:
    """Where a falling curve meets a value, interpolated in logarithms."""
    falling = np.log(np.maximum(squares[::-1], 1e-12))
    return float(np.exp(np.interp(math.log(wanted), falling, np.log(steps[::-1]))))
