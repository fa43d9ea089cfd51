"""The fitted numbers of the paper's estimators, fitted anew to a dataset.

NQSE's coefficients and the weight of the combination enter linearly, so each fit is a
small linear system made of sums over the poses, and a bootstrap over bodies costs
little. The errors with the fitted numbers are on the drops that they were fitted to.
With four numbers and the thousands of poses of a reference dataset they are too small
by some 0.002 points.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators.published import COMBINED_WEIGHT, NQSE_COEFFICIENTS

from ..errors.bootstrap import body_bootstrap
from ..errors.partition import accuracy
from ..errors.simulated_poses import SimulatedPoses
from .table_results import Refit

Array = NDArray[np.float64]

FEWEST_BODIES = 20
"""Least number of bodies; with fewer, some resamples do not determine four
coefficients.
"""


def refits(
    estimates: dict[str, Array],
    pooled: SimulatedPoses,
    single: dict[float, SimulatedPoses],
) -> Iterator[Refit]:
    """Fit Eq. 6 and Eq. 9 pooled, and Eq. 9 at each restitution.

    The result is empty where there are too few bodies.

    Parameters
    ----------
    estimates : dict of str to (P,) array
    pooled : SimulatedPoses
        All restitutions after each other.
    single : dict of float to SimulatedPoses
    """
    body = next(iter(single.values())).body
    if len(np.unique(body)) < FEWEST_BODIES:
        return
    yield _nonlinear(estimates["qse"], body, pooled, len(single))
    two = estimates["meae"], estimates["nqse"]
    yield _weight(
        "combined", np.tile(two[0], len(single)), np.tile(two[1], len(single)), pooled
    )
    for restitution, simulated in single.items():
        yield _weight(f"combined, {restitution:g}", *two, simulated)


def _nonlinear(
    qse: Array, body: NDArray[np.int64], pooled: SimulatedPoses, times: int
) -> Refit:
    """Least squares of s - x = sum c_i x^(i+1) (1 - x), as in section 4.C."""
    x = np.tile(qse, times)
    basis = (x * (1.0 - x))[:, None] * x[:, None] ** np.arange(len(NQSE_COEFFICIENTS))
    fitted, errors = _least_squares(basis, pooled.probability - x, pooled)

    def error(coefficients: tuple[float, ...]) -> float:
        bend = np.polynomial.polynomial.polyval(qse, coefficients)
        weight = np.maximum(qse + qse * (1.0 - qse) * bend, 0.0)
        share = weight / np.bincount(body, weight)[body]
        return accuracy(np.tile(share, times), pooled).error

    return Refit(
        "NQSE",
        NQSE_COEFFICIENTS,
        fitted,
        errors,
        error(NQSE_COEFFICIENTS),
        error(fitted),
    )


def _weight(name: str, meae: Array, nqse: Array, simulated: SimulatedPoses) -> Refit:
    """Least squares of s - nqse = c (meae - nqse), section 4.E."""
    fitted, errors = _least_squares(
        (meae - nqse)[:, None], simulated.probability - nqse, simulated
    )

    def error(c: float) -> float:
        return accuracy(c * meae + (1.0 - c) * nqse, simulated).error

    return Refit(
        name,
        (COMBINED_WEIGHT,),
        fitted,
        errors,
        error(COMBINED_WEIGHT),
        error(fitted[0]),
    )


def _least_squares(
    basis: Array, target: Array, simulated: SimulatedPoses
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Coefficients (k,) and their standard errors, from bodies drawn anew."""
    k = basis.shape[1]
    products = (basis[:, :, None] * basis[:, None, :]).reshape(-1, k * k)
    terms = np.column_stack((products, basis * target[:, None]))

    def solved(sums: Array) -> Array:
        matrices = sums[: k * k].T.reshape(-1, k, k)
        sides = sums[k * k :].T[:, :, None]
        return np.asarray(np.linalg.solve(matrices, sides)[:, :, 0], dtype=np.float64)

    best = solved(terms.sum(axis=0)[:, None])[0]
    spread = body_bootstrap(simulated.body, terms, solved)
    return tuple(best.tolist()), tuple(spread.std(axis=0, ddof=1).tolist())
