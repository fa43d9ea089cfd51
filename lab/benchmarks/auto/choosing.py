"""Whether `auto` keeps a target error, and the time that it takes."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lab.frame.results import Row, Section, Target
from ros_pose_stats import auto

from .cases import Case, by_index

TARGETS = (0.05, 0.03, 0.02, 0.01)
KEPT = 0.9
TIMED_EVERY = 8
"""`auto` is timed on every so many cases. Families and restitutions take turns, and
their numbers have no common divisor with this one, so that all of them are among these
cases.
"""

TIMED = (
    "`auto(part, target)` on {} parts at three restitutions, on one thread. `kept`: "
    "share of the cases whose true root mean square error over the poses is within the "
    "target, in %; the truth is {} other drops, their noise taken off. Milliseconds "
    "are processor time a part from a new `Part` on, poses and all, mean over one case "
    "in {}."
)

BY_FAMILY = (
    "Share of the same cases of each family whose true error is within the target, in "
    "%. `error`: standard error of a share of 90 % of so many cases. Not times."
)


class Answer(NamedTuple):
    """What `auto` says of a case."""

    is_within_target: bool
    method: str
    seconds: float  # of processor time, which other programs do not lengthen much


def choosing(cases: Sequence[Case]) -> tuple[Section, Section]:
    """Table of the targets, a row each and one for all, and table of the families."""
    answers = {target: [_auto(case, target) for case in cases] for target in TARGETS}
    is_kept = np.array(
        [[answer.is_within_target for answer in row] for row in answers.values()]
    )
    rows = [
        _row(f"auto, {100.0 * target:g} points", row) for target, row in answers.items()
    ]
    share = float(is_kept.mean())
    milliseconds = sum(float(row.cells["auto, ms"]) for row in rows)
    rows.append(
        Row(
            "auto, all",
            {"kept": 100.0 * share, "auto, ms": milliseconds, "used": "-"},
            (Target("kept", share, KEPT, at_least=True),),
        )
    )
    description = TIMED.format(
        len({case.number for case in cases}),
        int(cases[0].reference.sum()),
        TIMED_EVERY,
    )
    return (
        Section(
            "auto", "The cheapest method for a target error", description, tuple(rows)
        ),
        _families(cases, is_kept),
    )


def _auto(case: Case, target: float) -> Answer:
    part = case.part()
    begin = time.process_time()
    statistics = auto(
        part,
        target,
        restitution=case.restitution,
        seed=77_000 + case.number,
        workers=1,
        **case.options,
    )
    seconds = time.process_time() - begin
    square = case.square_error(by_index(statistics, "probability"))
    return Answer(square <= target**2, statistics.method, seconds)


def _row(name: str, answers: Sequence[Answer]) -> Row:
    share = float(np.mean([answer.is_within_target for answer in answers]))
    seconds = float(np.mean([answer.seconds for answer in answers[::TIMED_EVERY]]))
    methods = Counter(answer.method for answer in answers).most_common()
    return Row(
        name,
        {
            "kept": 100.0 * share,
            "auto, ms": 1e3 * seconds,
            "used": ", ".join(f"{method} {count}" for method, count in methods),
        },
        (Target("kept", share, KEPT, at_least=True),),
    )


def _families(cases: Sequence[Case], is_kept: NDArray[np.bool_]) -> Section:
    """Table of the families, from which case (T, C) kept each target."""
    family = np.array([case.family for case in cases])
    rows = []
    for name in np.unique(family).tolist():
        is_member = family == name
        shares = {
            f"{100.0 * target:g} points": 100.0 * float(of_target[is_member].mean())
            for target, of_target in zip(TARGETS, is_kept, strict=True)
        }
        error = math.sqrt(KEPT * (1.0 - KEPT) / is_member.sum())
        rows.append(
            Row(
                name,
                {
                    "cases": int(is_member.sum()),
                    "error": 100.0 * error,
                    **shares,
                    "all": 100.0 * float(is_kept[:, is_member].mean()),
                },
            )
        )
    return Section("auto_families", "Targets kept by family", BY_FAMILY, tuple(rows))
