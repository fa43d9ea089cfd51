"""Whether a target error is kept where the drops themselves choose when to stop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from lab.frame.results import Row, Section, Target
from ros_pose_stats.core.planning.confidence import FIRST_LOOK, judge_drops
from ros_pose_stats.core.statistics.prefix import Judge, Prefix
from ros_pose_stats.core.statistics.prior import PosePrior

from .cases import Case

TARGETS = (0.05, 0.03, 0.02, 0.01)
KEPT = 0.9
FEWEST = 100
"""Cases of a row whose share is compared with the promise."""

ABOUT = (
    "Share of the cases that are within the target error at which `{}` stopped, in %; in brackets "
    "the mean number of drops, if any. Cases that do not stop within {} drops are left out of "
    "their share. The truth is {} other drops, their noise taken off. `error`: standard error of "
    "a share of 90 % of so many cases. Not times."
)


class Stop(NamedTuple):
    """Where a run ended, and whether it is within the target there."""

    drops: int
    kept: bool


def promises(cases: Sequence[Case]) -> tuple[Section, Section]:
    """Table of `simulate --target-error` by family, and one of `hybrid` likewise."""
    priors = [one.prior() for one in cases]
    alone = [[stop_alone(one, target) for one in cases] for target in TARGETS]
    together = [
        [
            stop_together(one, prior, target)
            for one, prior in zip(cases, priors, strict=True)
        ]
        for target in TARGETS
    ]
    return (_section("simulate", cases, alone), _section("hybrid", cases, together))


def stop_alone(case: Case, target: float) -> Stop | None:
    """Stop counts as `simulate` does; None where the sequence of drops ends before."""
    prefix = _stopped(case, target, None)
    if prefix.judged().bound > target:
        return None
    return Stop(prefix.drops, _within(case, prefix.counts / prefix.settled, target))


def stop_together(case: Case, prior: PosePrior, target: float) -> Stop | None:
    """Stop drops and estimate as `hybrid` does; None where the sequence ends before."""
    prefix = _stopped(case, target, Judge(partial(judge_drops, prior), FIRST_LOOK))
    if prefix.judged().bound > target:
        return None
    refuted = prior.contradicted(prefix.counts).any()
    answer = (
        prefix.counts / prefix.settled
        if refuted
        else prior.updated(prefix.counts).probability
    )
    return Stop(prefix.drops, _within(case, answer, target))


def _stopped(case: Case, target: float, judge: Judge | None) -> Prefix:
    prefix = Prefix(case.reference.size, case.sequence.size, target, judge)
    prefix.add(case.sequence.astype(np.int64))
    return prefix


def _within(
    case: Case, answer: np.ndarray[tuple[int], np.dtype[np.float64]], target: float
) -> bool:
    return case.square_error(answer) <= target**2


def _section(
    method: str, cases: Sequence[Case], stops: Sequence[Sequence[Stop | None]]
) -> Section:
    family = np.array([one.family for one in cases])
    rows = [
        _row(
            name, [[each[k] for k in np.flatnonzero(family == name)] for each in stops]
        )
        for name in np.unique(family).tolist()
    ]
    rows.append(_row("all", stops))
    about = ABOUT.format(method, cases[0].sequence.size, int(cases[0].reference.sum()))
    return Section(
        f"promise_{method}", f"Targets kept by {method}, by family", about, tuple(rows)
    )


def _row(name: str, stops: Sequence[Sequence[Stop | None]]) -> Row:
    """Shares of one family at each target; a row of many cases has to keep the promise."""
    cells: dict[str, float | str] = {
        "cases": len(stops[0]),
        "error": 100.0 * math.sqrt(KEPT * (1.0 - KEPT) / len(stops[0])),
    }
    targets = []
    for target, each in zip(TARGETS, stops, strict=True):
        ended = [one for one in each if one is not None]
        label = f"{100.0 * target:g} points"
        if not ended:
            cells[label] = "-"
            continue
        share = float(np.mean([one.kept for one in ended]))
        cells[label] = (
            f"{100.0 * share:.1f} ({np.mean([one.drops for one in ended]):.0f})"
        )
        if len(ended) >= FEWEST:
            targets.append(Target(label, share, KEPT, at_least=True))
    return Row(name, cells, tuple(targets))
