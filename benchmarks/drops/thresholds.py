"""Whether the thresholds of the simulation have a say in its answers."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.kernels.drops.layout import DropRules

from ..results import Row, Section
from .dropper import RESTITUTIONS, Dropper

FACTORS = (0.01, 10.0, 100.0)

TIMED = (
    "`SLOW` (below which a series of impacts is cut off) and `TOUCHING` (within which a vertex "
    "takes part) multiplied by the factor, `SOFT` (the energy that cutting off may cost) by its "
    "square. Every body ({}) is dropped {} times from the same starts as with the thresholds as "
    "they are. `ended otherwise`: share of drops that came to another pose. `largest change`: of "
    "a pose's probability, in points. `its errors`: the largest change in units of its own "
    "standard error, the root of the number of drops that came to or left the pose; the largest "
    "of that many independent ones is about `by chance`. `rate`: over that with the thresholds "
    "as they are.")


class Change(NamedTuple):
    """What a factor changed on one body: drops, largest change and the same in its errors."""

    otherwise: int
    largest: float
    errors: float
    compared: int
    seconds: float
    before: float


def scaled(rules: DropRules, factor: float) -> DropRules:
    """Rules with other thresholds."""
    return rules._replace(slow=factor * rules.slow, touching=factor * rules.touching,
                          soft=factor**2 * rules.soft)


def thresholds(droppers: Sequence[Dropper], drops: int) -> Section:
    """A row for each restitution and factor, over all bodies."""
    rows = []
    for restitution in RESTITUTIONS:
        changes = [list(_changes(dropper, restitution, drops)) for dropper in droppers]
        rows += [_row(restitution, factor, [each[i] for each in changes], drops)
                 for i, factor in enumerate(FACTORS)]
    names = ", ".join(f"{dropper.name}, {dropper.vertices} vertices" for dropper in droppers)
    return Section("drop_thresholds", "What the thresholds change",
                   TIMED.format(names, drops), tuple(rows))


def _changes(dropper: Dropper, restitution: float, drops: int) -> Iterator[Change]:
    rules = dropper.rules(restitution)
    known, before = _timed(dropper, rules, drops)
    for factor in FACTORS:
        found, seconds = _timed(dropper, scaled(rules, factor), drops)
        moved = found != known
        came, left = (np.bincount(each[moved] + 1, minlength=dropper.poses + 1)
                      for each in (found, known))
        # One row more than poses: drops that did not settle count as a pose of their own.
        change, error = (came - left) / drops, np.sqrt(came + left) / drops
        seen = error > 0.0
        yield Change(int(moved.sum()), float(np.abs(change).max()),
                     float((np.abs(change)[seen] / error[seen]).max(initial=0.0)),
                     int(seen.sum()), seconds, before)


def _timed(dropper: Dropper, rules: DropRules, drops: int) -> tuple[NDArray[np.int64], float]:
    begin = time.perf_counter()
    pose = dropper.drop(rules, 1, drops).pose
    return pose, time.perf_counter() - begin


def _row(restitution: float, factor: float, changes: Sequence[Change], drops: int) -> Row:
    compared = sum(change.compared for change in changes)
    return Row(f"restitution {restitution}, thresholds × {factor:g}", {
        "ended otherwise": sum(each.otherwise for each in changes) / drops / len(changes),
        "largest change, points": 100.0 * max(each.largest for each in changes),
        "its errors": max(each.errors for each in changes),
        "by chance": _largest_by_chance(compared), "poses": compared,
        "rate": sum(each.before for each in changes) / sum(each.seconds for each in changes),
    })


def _largest_by_chance(number: int) -> float:
    """Median of the largest of some normally distributed numbers, in absolute terms."""
    if number == 0:
        return 0.0
    draws = np.random.default_rng(0).standard_normal((2000, number))
    return float(np.median(np.abs(draws).max(axis=1)))
