"""The fit of `split`: its loss is the likelihood of the counts and the paper's square error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ros_pose_stats.estimators.fitted_weights import (
    SPLIT_FILE,
    SplitFit,
    TanhNetwork,
)
from ros_pose_stats.estimators.split import component_bases, component_weights

from ..network_fit import (
    coefficient_count,
    network_gradient,
    network_of,
    pack_networks,
    random_coefficients,
    undo_scaling,
)
from .counting import HIGHEST_DROP, HIGHEST_RESTITUTION, LOWEST_DROP
from .gradient import tree_loss
from .table import Table

Array = NDArray[np.float64]
Single = NDArray[np.float32]

SQUARE = 3.0
"""Weight of the square error beside the negative log likelihood of a drop."""

BLOCK = 4096

HELD_SELDOM = -4.0
"""First value of the constant in the weights of holding faces."""


def predict(fits: Sequence[SplitFit], table: Table) -> Array:
    """Estimate the probabilities (P,) of a table's poses."""
    return _loss(table, component_weights(table.inputs, fits), gradient=False)[2]


def fit_networks(table: Table, units: tuple[int, int], ridge: float, iterations: int,
                 seed: int = 0) -> SplitFit:
    """Fit both networks to the samples of a table.

    Parameters
    ----------
    table : Table
    units : tuple of int
        Hidden units of either network.
    ridge : float
        Weight of the squares of all coefficients, for standardised inputs, in the mean loss.
    iterations : int
    seed : int
        Of the first coefficients.
    """
    mean, scale = table.inputs.mean(axis=0), table.inputs.std(axis=0) + np.float32(1e-6)
    inputs = (table.inputs - mean) / scale
    columns = inputs.shape[1]
    draw = np.random.default_rng(seed)
    begin = np.concatenate([random_coefficients(columns, many, draw) for many in units])
    bases = np.stack(component_bases(table.inputs)).astype(np.float32)
    bases[1] += np.float32(HELD_SELDOM)
    found = minimize(_objective, begin, (table, inputs, bases, units, ridge), "L-BFGS-B", True,
                     options={"maxiter": iterations, "maxcor": 20}).x
    left, held = (undo_scaling(part, mean, scale) for part in _parts(found, columns, units))
    return SplitFit(left, held._replace(bias=held.bias + HELD_SELDOM))


def write_weights(fits: Sequence[SplitFit], file: Path = SPLIT_FILE) -> None:
    """Write the weights to the file that the estimator reads, or to another one.

    The highest restitution and the drop heights (radii) of the data are written too.
    """
    np.savez(file, **pack_networks([fit.left for fit in fits], "left_"),
             **pack_networks([fit.held for fit in fits], "held_"),
             scenes=np.array((HIGHEST_RESTITUTION, LOWEST_DROP, HIGHEST_DROP)))


def _parts(values: Array, columns: int, units: tuple[int, int]) -> tuple[TanhNetwork, TanhNetwork]:
    first = coefficient_count(columns, units[0])
    return (network_of(values[:first], columns, units[0]),
            network_of(values[first:], columns, units[1]))


def _objective(values: Array, table: Table, inputs: Single, bases: Single,
               units: tuple[int, int], ridge: float) -> tuple[float, Array]:
    """Loss with the ridge, and its gradient, computed in blocks of rows that fit the cache."""
    parts = [TanhNetwork(np.float32(part.bias), *(one.astype(np.float32) for one in part[1:]))
             for part in _parts(values, inputs.shape[1], units)]
    blocks = [slice(begin, begin + BLOCK) for begin in range(0, len(inputs), BLOCK)]
    hidden = [np.empty((len(inputs), many), np.float32) for many in units]
    told = np.empty_like(bases)
    for block in blocks:
        for k, part in enumerate(parts):
            np.tanh(inputs[block] @ part.hidden_weights + part.hidden_bias, out=hidden[k][block])
            told[k, block] = (bases[k, block] + part.bias + inputs[block] @ part.skip
                              + hidden[k][block] @ part.output_weights)
    whole = np.logaddexp(*told)
    loss, slopes, _ = _loss(table, whole.astype(float), gradient=True)
    back = slopes.astype(np.float32) * np.exp(told - whole)
    slope = np.concatenate([
        np.sum([network_gradient(part, hidden[k][block], inputs[block], back[k, block])
                for block in blocks], axis=0, dtype=float)
        for k, part in enumerate(parts)])
    return loss + ridge * float(values @ values), slope + 2.0 * ridge * values


def _loss(table: Table, told: Array, gradient: bool) -> tuple[float, Array, Array]:
    return tree_loss(told, table.first_split, table.splits, table.first_pose, table.poses,
                     table.children, table.leaf_pose, table.kept, table.share, SQUARE, gradient)
