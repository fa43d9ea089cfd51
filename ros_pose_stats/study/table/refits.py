"""The fitted numbers of the paper's estimators, fitted anew to a dataset.

NQSE's coefficients and the weight of the combination enter linearly, so each fit is a small
linear system made of sums over the poses, and a bootstrap over bodies costs little. The errors
with the fitted numbers are on the drops that they were fitted to. With four numbers and the
thousands of poses of a reference dataset they are too small by some 0.002 points.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ...estimators.energy_absorption import COMBINED_WEIGHT
from ...estimators.quasi_static import NQSE_COEFFICIENTS, PQSE_SHARE, perturbed_quasi_static
from ...resting.poses import RestingPoses
from ..errors.bootstrap import body_bootstrap
from ..errors.partition import accuracy
from ..errors.simulated_poses import SimulatedPoses
from .table_results import Refit

Array = NDArray[np.float64]

FEWEST_BODIES = 20
"""Least number of bodies; with fewer, some resamples do not determine four coefficients."""

SHARES = 0.0, 2.6
"""Redistributed shares of PQSE between which the best is sought."""

SHARE_STEP = 0.1
"""Distance of shares on either side of the best. A parabola through the three misfits gives the
best share of a resample."""


def refits(estimates: dict[str, Array], pooled: SimulatedPoses,
           single: dict[float, SimulatedPoses], poses: list[RestingPoses]) -> Iterator[Refit]:
    """Fit Eq. 6 and Eq. 9 pooled, Eq. 9 at each restitution, and PQSE's share.

    The result is empty where there are too few bodies.

    Parameters
    ----------
    estimates : dict of str to (P,) array
    pooled : SimulatedPoses
        All restitutions after each other.
    single : dict of float to SimulatedPoses
    poses : list of RestingPoses
        Of all bodies.
    """
    body = next(iter(single.values())).body
    if len(poses) < FEWEST_BODIES:
        return
    yield _nonlinear(estimates["qse"], body, pooled, len(single))
    two = estimates["meae"], estimates["nqse"]
    yield _weight("combined", np.tile(two[0], len(single)), np.tile(two[1], len(single)), pooled)
    for restitution, simulated in single.items():
        yield _weight(f"combined, {restitution:g}", *two, simulated)
    yield _share(poses, pooled, len(single))


def _nonlinear(qse: Array, body: NDArray[np.int64], pooled: SimulatedPoses,
               times: int) -> Refit:
    """Least squares of s - x = sum c_i x^(i+1) (1 - x), as in section 4.C."""
    x = np.tile(qse, times)
    basis = (x * (1.0 - x))[:, None] * x[:, None] ** np.arange(len(NQSE_COEFFICIENTS))
    fitted, errors = _least_squares(basis, pooled.probability - x, pooled)

    def error(coefficients: tuple[float, ...]) -> float:
        bend = np.polynomial.polynomial.polyval(qse, coefficients)
        weight = np.maximum(qse + qse * (1.0 - qse) * bend, 0.0)
        share = weight / np.bincount(body, weight)[body]
        return accuracy(np.tile(share, times), pooled).error

    return Refit("NQSE", NQSE_COEFFICIENTS, fitted, errors, error(NQSE_COEFFICIENTS),
                 error(fitted))


def _weight(name: str, meae: Array, nqse: Array, simulated: SimulatedPoses) -> Refit:
    """Least squares of s - nqse = c (meae - nqse), section 4.E."""
    fitted, errors = _least_squares((meae - nqse)[:, None], simulated.probability - nqse,
                                    simulated)

    def error(c: float) -> float:
        return accuracy(c * meae + (1.0 - c) * nqse, simulated).error

    return Refit(name, (COMBINED_WEIGHT,), fitted, errors, error(COMBINED_WEIGHT),
                 error(fitted[0]))


def _share(poses: list[RestingPoses], pooled: SimulatedPoses, times: int) -> Refit:
    """The share of PQSE with the smallest error."""
    def estimated(share: float) -> Array:
        return np.tile(np.concatenate([perturbed_quasi_static(one, share) for one in poses]),
                       times)

    def squares(share: float) -> Array:
        return np.asarray((estimated(share) - pooled.probability) ** 2)

    best = float(minimize_scalar(lambda share: squares(share).mean(), bounds=SHARES,
                                 method="bounded", options={"xatol": 0.005}).x)
    middle = min(max(best, SHARE_STEP), SHARES[1] - SHARE_STEP)
    three = [squares(middle + away) for away in (-SHARE_STEP, 0.0, SHARE_STEP)]

    def lowest(sums: Array) -> Array:
        a, b, c = sums
        return np.asarray(np.clip(middle + 0.5 * SHARE_STEP * (a - c) / (a - 2.0 * b + c),
                                  *SHARES))

    spread = body_bootstrap(pooled.body, np.stack(three, axis=1), lowest)
    return Refit("PQSE", (PQSE_SHARE,), (best,), (float(spread.std(ddof=1)),),
                 accuracy(estimated(PQSE_SHARE), pooled).error,
                 accuracy(estimated(best), pooled).error)


def _least_squares(basis: Array, target: Array,
                   simulated: SimulatedPoses) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Coefficients (k,) and their standard errors, from bodies drawn anew."""
    k = basis.shape[1]
    products = (basis[:, :, None] * basis[:, None, :]).reshape(-1, k * k)
    terms = np.column_stack((products, basis * target[:, None]))

    def solved(sums: Array) -> Array:
        matrices, sides = sums[:k * k].T.reshape(-1, k, k), sums[k * k:].T[:, :, None]
        return np.asarray(np.linalg.solve(matrices, sides)[:, :, 0], dtype=np.float64)

    best = solved(terms.sum(axis=0)[:, None])[0]
    spread = body_bootstrap(simulated.body, terms, solved)
    return tuple(best.tolist()), tuple(spread.std(axis=0, ddof=1).tolist())
