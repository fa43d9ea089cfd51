"""Suggested changes against drops: how often the share rises and the told intervals hold."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from ros_pose_stats.tools.design.paired_drops import paired_difference
from ros_pose_stats.tools.design.suggest import suggest

from .bodies import Case

WITHIN = 0.04
"""Bound of a suggestion, in radii: a millimetre on a part of 50 mm."""

TOLD_DROPS = 300
TOLDS = 10
TRUE_DROPS = 4000
FEWEST_DROPS = 500
SECONDS = 8.0
"""Drops that tell a gain, how often, and those that stand for the truth; fewer on slow parts."""


class Gain(NamedTuple):
    """A suggestion for one part; shares as fractions.

    `told` counts the told intervals, each from drops of its own, and `held` those that hold the
    gain of the drops that stand for the truth.
    """

    family: str
    number: int
    share: float
    estimated: float
    estimated_error: float
    measured: float
    measured_error: float
    held: int
    told: int
    steps: int
    seconds: float


def measure_gain(case: Case, workers: int) -> Gain:
    """Suggest a change of a part, and drop it before and after."""
    space = case.space
    model = case.model
    begin = time.process_time()
    found = suggest(
        space.part,
        case.wanted,
        WITHIN * space.body.radius,
        drops=100,
        seed=1,
        restitution=case.restitution,
        workers=workers,
        cluster_tolerance=space.scene.cluster_tolerance,
        round_sides=space.scene.round_sides,
    )
    seconds = time.process_time() - begin
    pair = [space.change_one(0, 0.0), found.changed]
    begin = time.process_time()
    model.drop(pair, 50, 0, workers)
    each = (time.process_time() - begin) / 50
    drops = int(min(TRUE_DROPS, max(FEWEST_DROPS, 0.6 * SECONDS / each)))
    truth = paired_difference(*model.drop(pair, drops, 2, workers))
    held = 0
    told_drops = int(min(TOLD_DROPS, max(100, 0.4 * SECONDS / (TOLDS * each))))
    for seed in range(3, 3 + TOLDS):
        one = paired_difference(*model.drop(pair, told_drops, seed, workers))
        # The truth was dropped, too: the interval is as much wider as both errors together are.
        wider = np.hypot(one.standard_error, truth.standard_error) / max(
            one.standard_error, 1e-9
        )
        middle = 0.5 * (one.low + one.high)
        held += bool(abs(truth.value - middle) <= wider * 0.5 * (one.high - one.low))
    return Gain(
        case.family,
        case.number,
        found.before,
        found.after - found.before,
        found.gain_error,
        truth.value,
        truth.standard_error,
        held,
        TOLDS,
        len(found.steps),
        seconds,
    )
