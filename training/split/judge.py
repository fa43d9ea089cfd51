"""How the split estimator does on bodies, and on whole families, that it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.estimators.fitted_weights import SplitFit

from .fit import fitted, predicted
from .samples import FIT_SEED, JUDGE_SEED, LOW, USUAL, Sample
from .table import Array, Table, make_table

BENDS, RIDGE, ITERATIONS = (30, 10), 2e-6, 700
"""Of the fit."""
STARTS = 2
"""Fits from as many random starts are averaged."""

HELD_OUT = ("prisms", "plates", "ellipsoids", "machined")
FOLDS = 2
USUAL_HEIGHT = 20.0

ALL = "all"
TAIL = 0.999


class Score(NamedTuple):
    """Errors in points, the drops' noise taken off.

    Attributes
    ----------
    what : str
        Which bodies.
    height : float
        Radii.
    errors : tuple of float
        Of the split estimator: pooled over the restitutions 0.2, 0.5 and 0.8, and at each.
    combined : tuple of float
        The same of the paper's combined estimator.
    expected : float
        Root mean square of what the shipped weights expect, pooled.
    largest, tail : float
        Largest deviation of a pose, noise and all, and the one that one in a thousand exceeds.
    combined_largest, combined_tail : float
        The same of the combined estimator.
    """

    what: str
    height: float
    errors: tuple[float, ...]
    combined: tuple[float, ...]
    expected: float
    largest: float
    tail: float
    combined_largest: float
    combined_tail: float


def fit_all(samples: Sequence[Sample], workers: int) -> tuple[SplitFit, ...]:
    """The fits that the package holds."""
    table = make_table(_of(samples, FIT_SEED))
    with ThreadPoolExecutor(workers) as pool:
        return tuple(pool.map(lambda start: _fitted(table, start), range(STARTS)))


def judge(samples: Sequence[Sample], fits: Sequence[SplitFit], workers: int,
          on_progress: Callable[[str], object]) -> dict[str, list[Score]]:
    """Scores on new bodies of every family, across folds, and on families held out."""
    on_progress("measuring the bodies")
    known, new = make_table(_of(samples, FIT_SEED)), make_table(_of(samples, JUDGE_SEED))
    found = {"new bodies": list(_scores(new, predicted(fits, new), (USUAL_HEIGHT, LOW)))}
    out = {f"fold {fold + 1} of {FOLDS}": known.body % FOLDS == fold for fold in range(FOLDS)}
    out |= {family: known.family == family for family in HELD_OUT}
    with ThreadPoolExecutor(workers) as pool:
        again = {name: [pool.submit(_fitted_without, known, poses, start)
                        for start in range(STARTS)] for name, poses in out.items()}
        told = {}
        for name, jobs in again.items():
            told[name] = predicted([job.result() for job in jobs], known)
            on_progress(f"without {name}")
    names = list(out)
    whole = np.select([out[name] for name in names[:FOLDS]],
                      [told[name] for name in names[:FOLDS]])
    found["folds by body"] = list(_scores(known, whole, (USUAL_HEIGHT,)))
    found["families held out"] = [score for family in HELD_OUT for score in _scores(
        known, told[family], (USUAL_HEIGHT,), (family,))]
    return found


def _fitted_without(table: Table, out: NDArray[np.bool_], start: int) -> SplitFit:
    """The same fit to the samples none of whose poses are left out."""
    return _fitted(table.some(~out[table.first_pose]), start)


def _fitted(table: Table, start: int) -> SplitFit:
    return fitted(table, BENDS, RIDGE, ITERATIONS, start)


def _scores(table: Table, probability: Array, heights: Sequence[float],
            families: Sequence[str] | None = None) -> Iterator[Score]:
    for family in families or (*np.unique(table.family).tolist(), ALL):
        for height in heights:
            usual = np.isin(table.restitution, USUAL) & (table.height == height)
            where = usual if family == ALL else usual & (table.family == family)
            yield Score(family, height, _errors(table, probability, where),
                        _errors(table, table.reference["combined"], where),
                        100.0 * float(np.sqrt(np.mean(np.square(table.expected[where])))),
                        *_largest(table, probability, where),
                        *_largest(table, table.reference["combined"], where))


def _errors(table: Table, probability: Array, where: NDArray[np.bool_]) -> tuple[float, ...]:
    each = [table.error(probability, where & (table.restitution == rho)) for rho in USUAL]
    return (table.error(probability, where), *each)


def _largest(table: Table, probability: Array, where: NDArray[np.bool_]) -> tuple[float, float]:
    """Largest deviation, and the one that one pose in a thousand exceeds."""
    away = 100.0 * np.abs(probability - table.share)[where]
    return float(away.max()), float(np.quantile(away, TAIL))


def _of(samples: Sequence[Sample], seed: int) -> list[Sample]:
    return [one for one in samples if one.seed == seed]
