"""What fits of bent functions have in common: their coefficients in a row, and the slopes."""

from __future__ import annotations

import math

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from ros_pose_stats.estimators.bent import Bent

Array = NDArray[np.float64]
Floats = NDArray[np.floating]


def length(columns: int, bends: int) -> int:
    """How many coefficients there are for so many inputs and hyperbolic tangents."""
    return 1 + columns + (columns + 2) * bends


def start(columns: int, bends: int, draw: Generator) -> Array:
    """Coefficients (`length`,) of a function that is 0, its turns and offsets at random."""
    return np.concatenate(([0.0], np.zeros(columns),
                           draw.normal(size=columns * bends) / math.sqrt(columns),
                           0.1 * draw.normal(size=bends), np.zeros(bends)))


def bent_of(values: Array, columns: int, bends: int) -> Bent:
    """The function of coefficients (`length`,)."""
    end = 1 + columns * (1 + bends)
    return Bent(float(values[0]), values[1:1 + columns],
                values[1 + columns:end].reshape(columns, bends), values[end:end + bends],
                values[end + bends:])


def change(bent: Bent, tangents: Floats, inputs: Floats, back: Floats) -> Floats:
    """Gradient by the coefficients, from that by the values: rows (n, K) and (n,)."""
    inner = (1.0 - tangents * tangents) * np.outer(back, bent.bends)
    return np.concatenate(([back.sum()], inputs.T @ back, (inputs.T @ inner).ravel(),
                           inner.sum(axis=0), tangents.T @ back))


def unscaled(bent: Bent, mean: Floats, scale: Floats) -> Bent:
    """The same function of x from one of (x - mean) / scale."""
    slope, turns = bent.slope / scale, bent.turns / scale[:, None]
    return Bent(bent.constant - float(mean @ slope), slope, turns, bent.offsets - mean @ turns,
                bent.bends)
