"""Errors of the split estimator on bodies, and on whole families, that it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators.fitted import SplitFit

from .fit import fit_networks, predict
from .samples import FIT_SEED, HEIGHT, JUDGE_SEED, LOW, USUAL, Sample
from .table import Array, Table, make_table

UNITS = (60, 20)
RIDGE = 2e-6
EPOCHS = 100
"""Hidden units of both networks, ridge, and how often the fit uses each sample."""
STARTS = 2
"""Number of fits, from random starts, whose logarithms are averaged."""

HELD_OUT = ("prisms", "plates", "ellipsoids", "machined", "hollow", "gears", "bars")
FOLDS = 2

ALL = "all"
TAIL = 0.999


class Score(NamedTuple):
    """Errors in points, the drops' noise taken off."""

    what: str  # name of the bodies
    height: float  # radii
    errors: tuple[
        float, ...
    ]  # of `split`: pooled over the usual restitutions, and at each
    combined: tuple[float, ...]  # the same of the combined estimator
    expected: float  # root mean square of the expected ones, pooled
    largest: float  # deviation of a pose, noise included
    tail: float  # the one that one pose in a thousand exceeds
    combined_largest: float
    combined_tail: float


def fit_all(samples: Sequence[Sample], workers: int) -> tuple[SplitFit, ...]:
    """Make the fits that the package ships."""
    table = make_table(_of(samples, FIT_SEED), compared=False)
    with ThreadPoolExecutor(workers) as pool:
        return tuple(pool.map(lambda start: _fit(table, start), range(STARTS)))


def judge(
    samples: Sequence[Sample], fits: Sequence[SplitFit]
) -> dict[str, list[Score]]:
    """Score new bodies of every family."""
    new = make_table(_of(samples, JUDGE_SEED))
    return {"new bodies": list(_scores(new, predict(fits, new), (HEIGHT, LOW)))}


def judge_refits(
    samples: Sequence[Sample], workers: int, on_progress: Callable[[str], object]
) -> dict[str, list[Score]]:
    """Score folds of bodies and families held out, by fits without them; takes an hour or two."""
    on_progress("measuring the bodies")
    known = make_table(_of(samples, FIT_SEED))
    out = {
        f"fold {fold + 1} of {FOLDS}": known.body % FOLDS == fold
        for fold in range(FOLDS)
    }
    out |= {family: known.family == family for family in HELD_OUT}
    with ThreadPoolExecutor(workers) as pool:
        again = {
            name: [
                pool.submit(_fit_without, known, poses, start)
                for start in range(STARTS)
            ]
            for name, poses in out.items()
        }
        told = {}
        for name, jobs in again.items():
            told[name] = predict([job.result() for job in jobs], known)
            on_progress(f"without {name}")
    names = list(out)
    whole = np.select(
        [out[name] for name in names[:FOLDS]], [told[name] for name in names[:FOLDS]]
    )
    found = {"folds by body": list(_scores(known, whole, (HEIGHT,)))}
    found["families held out"] = [
        score
        for family in HELD_OUT
        for score in _scores(known, told[family], (HEIGHT,), (family,))
    ]
    return found


def _fit_without(table: Table, out: NDArray[np.bool_], start: int) -> SplitFit:
    """Fit to the samples without those that have a pose among `out`."""
    return _fit(table.some(~out[table.first_pose]), start)


def _fit(table: Table, start: int) -> SplitFit:
    return fit_networks(table, UNITS, RIDGE, EPOCHS, start)


def _scores(
    table: Table,
    probability: Array,
    heights: Sequence[float],
    families: Sequence[str] | None = None,
) -> Iterator[Score]:
    for family in families or (*np.unique(table.family).tolist(), ALL):
        for height in heights:
            usual = np.isin(table.restitution, USUAL) & (table.height == height)
            where = usual if family == ALL else usual & (table.family == family)
            yield Score(
                family,
                height,
                _errors(table, probability, where),
                _errors(table, table.reference["combined"], where),
                100.0 * float(np.sqrt(np.mean(np.square(table.expected[where])))),
                *_largest(table, probability, where),
                *_largest(table, table.reference["combined"], where),
            )


def _errors(
    table: Table, probability: Array, where: NDArray[np.bool_]
) -> tuple[float, ...]:
    each = [
        table.error(probability, where & (table.restitution == rho)) for rho in USUAL
    ]
    return (table.error(probability, where), *each)


def _largest(
    table: Table, probability: Array, where: NDArray[np.bool_]
) -> tuple[float, float]:
    """Largest deviation, and the one that one pose in a thousand exceeds."""
    away = 100.0 * np.abs(probability - table.share)[where]
    return float(away.max()), float(np.quantile(away, TAIL))


def _of(samples: Sequence[Sample], seed: int) -> list[Sample]:
    return [one for one in samples if one.seed == seed]
