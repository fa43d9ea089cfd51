"""How the split estimator does on bodies, and on whole families, that it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .fit import Weights, averaged, fitted, predicted
from .samples import FIT_SEED, JUDGE_SEED, LOW, USUAL, Sample
from .table import Array, Table, make_table

BENDS, RIDGE, ITERATIONS = 40, 2e-6, 700
"""Of the fit."""
STARTS = 2
"""Of the shipped weights: fits from as many random starts, averaged. Elsewhere there is one."""

HELD_OUT = ("prisms", "plates", "ellipsoids", "machined")
FOLDS = 2
USUAL_HEIGHT = 20.0


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
    largest, combined_largest : float
        Largest deviation of a pose, noise and all.
    """

    what: str
    height: float
    errors: tuple[float, ...]
    combined: tuple[float, ...]
    expected: float
    largest: float
    combined_largest: float


def fit_all(samples: Sequence[Sample]) -> Weights:
    """The fit that the package holds."""
    table = make_table(_of(samples, FIT_SEED))
    return averaged([fitted(table, BENDS, RIDGE, ITERATIONS, start) for start in range(STARTS)])


def judge(samples: Sequence[Sample], weights: Weights,
          on_progress: Callable[[str], object]) -> dict[str, list[Score]]:
    """Scores on new bodies of every family, across folds, and on families held out."""
    on_progress("measuring the bodies")
    known, new = make_table(_of(samples, FIT_SEED)), make_table(_of(samples, JUDGE_SEED))
    found = {"new bodies": list(_scores(new, predicted(weights, new), (USUAL_HEIGHT, LOW)))}
    whole = np.empty_like(known.share)
    for fold in range(FOLDS):
        on_progress(f"fold {fold + 1} of {FOLDS}")
        out = known.body % FOLDS == fold
        told = _fitted_without(known, out)
        whole[out] = predicted(told, known)[out]
    found["folds by body"] = list(_scores(known, whole, (USUAL_HEIGHT,)))
    found["families held out"] = []
    for family in HELD_OUT:
        on_progress(f"without {family}")
        out = known.family == family
        told = _fitted_without(known, out)
        found["families held out"] += _scores(known, predicted(told, known), (USUAL_HEIGHT,),
                                              (family,))
    return found


def _fitted_without(table: Table, out: NDArray[np.bool_]) -> Weights:
    """The same fit to the samples none of whose poses are left out."""
    keep = ~out[table.first_pose]
    return fitted(table.some(keep), BENDS, RIDGE, ITERATIONS)


def _scores(table: Table, probability: Array, heights: Sequence[float],
            families: Sequence[str] | None = None) -> Iterator[Score]:
    for family in families or np.unique(table.family).tolist():
        for height in heights:
            usual = np.isin(table.restitution, USUAL) & (table.height == height)
            where = usual & (table.family == family)
            yield Score(family, height, _errors(table, probability, where),
                        _errors(table, table.reference["combined"], where),
                        100.0 * float(np.sqrt(np.mean(np.square(table.expected[where])))),
                        _largest(table, probability, where),
                        _largest(table, table.reference["combined"], where))


def _errors(table: Table, probability: Array, where: NDArray[np.bool_]) -> tuple[float, ...]:
    each = [table.error(probability, where & (table.restitution == rho)) for rho in USUAL]
    return (table.error(probability, where), *each)


def _largest(table: Table, probability: Array, where: NDArray[np.bool_]) -> float:
    return 100.0 * float(np.abs(probability - table.share)[where].max())


def _of(samples: Sequence[Sample], seed: int) -> list[Sample]:
    return [one for one in samples if one.seed == seed]
