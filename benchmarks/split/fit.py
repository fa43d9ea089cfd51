"""The fit: by the likelihood of the counts, and by the error that the paper measures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from .gradient import tree_loss
from .table import Table

Array = NDArray[np.float64]
Single = NDArray[np.float32]

SQUARE = 3.0
"""Weight of the square error beside the negative log likelihood of a drop."""


@dataclass(frozen=True, eq=False)
class Weights:
    """A component's log weight: its log area + slope x + bends tanh(turns x + offsets).

    The constant of the formula is left out: only differences count.
    """

    slope: Array
    turns: Array
    offsets: Array
    bends: Array

    def __call__(self, inputs: NDArray[np.floating]) -> Array:
        """Of components (n,) with inputs (n, 19)."""
        bent = np.tanh(inputs @ self.turns + self.offsets)
        return np.asarray(inputs[:, 0] + inputs @ self.slope + bent @ self.bends, dtype=float)


def averaged(fits: Sequence[Weights]) -> Weights:
    """The mean of the logarithms of several fits, which errs less than each."""
    return Weights(np.mean([one.slope for one in fits], axis=0),
                   np.hstack([one.turns for one in fits]),
                   np.concatenate([one.offsets for one in fits]),
                   np.concatenate([one.bends for one in fits]) / len(fits))


def predicted(weights: Weights, table: Table) -> Array:
    """Probabilities (P,) of a table's poses."""
    return _loss(table, weights(table.inputs), gradient=False)[2]


def fitted(table: Table, bends: int, ridge: float, iterations: int, seed: int = 0) -> Weights:
    """Fit the weights of components to the samples of a table.

    Parameters
    ----------
    table : Table
    bends : int
        Hyperbolic tangents.
    ridge : float
        Of the squares of all coefficients for standardised inputs, against the loss a sample.
    iterations : int
    seed : int
        Of the start.
    """
    mean, scale = table.inputs.mean(axis=0), table.inputs.std(axis=0) + np.float32(1e-6)
    inputs = (table.inputs - mean) / scale
    columns = inputs.shape[1]
    draw = np.random.default_rng(seed)
    start = np.concatenate((np.zeros(columns), draw.normal(size=columns * bends)
                            / math.sqrt(columns), 0.1 * draw.normal(size=bends), np.zeros(bends)))
    found = minimize(_objective, start, (table, inputs, bends, ridge), "L-BFGS-B", True,
                     options={"maxiter": iterations, "maxcor": 20}).x
    slope, turns, offsets, heights = _parts(found, columns, bends)
    turns = turns / scale[:, None]
    return Weights(slope / scale, turns, offsets - mean @ turns, heights)


def _parts(values: Array, columns: int, bends: int) -> tuple[Array, Array, Array, Array]:
    end = columns * (1 + bends)
    return (values[:columns], values[columns:end].reshape(columns, bends),
            values[end:end + bends], values[end + bends:])


def _objective(values: Array, table: Table, inputs: Single, bends: int,
               ridge: float) -> tuple[float, Array]:
    slope, turns, offsets, heights = (part.astype(np.float32) for part in
                                      _parts(values, inputs.shape[1], bends))
    bent = np.tanh(inputs @ turns + offsets)
    told = table.inputs[:, 0] + inputs @ slope + bent @ heights
    loss, slopes, _ = _loss(table, told.astype(float), gradient=True)
    back = slopes.astype(np.float32)
    inner = (1.0 - bent * bent) * np.outer(back, heights)
    change = np.concatenate((inputs.T @ back, (inputs.T @ inner).ravel(), inner.sum(axis=0),
                             bent.T @ back)).astype(float)
    return loss + ridge * float(values @ values), change + 2.0 * ridge * values


def _loss(table: Table, told: Array, gradient: bool) -> tuple[float, Array, Array]:
    return tree_loss(told, table.first_split, table.splits, table.first_pose, table.children,
                     table.kept, table.share, SQUARE, gradient)
