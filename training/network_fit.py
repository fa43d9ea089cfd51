"""What fits of networks have in common: weights in a row, the gradient, how they are stored."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from ros_pose_stats.estimators.fitted_weights import TanhNetwork

Array = NDArray[np.float64]
Floats = NDArray[np.floating]


def length(columns: int, units: int) -> int:
    """How many coefficients there are for so many inputs and hyperbolic tangents."""
    return 1 + columns + (columns + 2) * units


def start(columns: int, units: int, draw: Generator) -> Array:
    """Coefficients (`length`,) of a function that is 0, its turns and offsets at random."""
    return np.concatenate(([0.0], np.zeros(columns),
                           draw.normal(size=columns * units) / math.sqrt(columns),
                           0.1 * draw.normal(size=units), np.zeros(units)))


def network_of(values: Array, columns: int, units: int) -> TanhNetwork:
    """The function of coefficients (`length`,)."""
    end = 1 + columns * (1 + units)
    return TanhNetwork(float(values[0]), values[1:1 + columns],
                values[1 + columns:end].reshape(columns, units), values[end:end + units],
                values[end + units:])


def change(network: TanhNetwork, tangents: Floats, inputs: Floats, back: Floats) -> Floats:
    """Gradient by the coefficients, from that by the values: rows (n, K) and (n,)."""
    inner = (1.0 - tangents * tangents) * np.outer(back, network.output_weights)
    return np.concatenate(([back.sum()], inputs.T @ back, (inputs.T @ inner).ravel(),
                           inner.sum(axis=0), tangents.T @ back))


def unscaled(network: TanhNetwork, mean: Floats, scale: Floats) -> TanhNetwork:
    """The same function of x from one of (x - mean) / scale."""
    skip, hidden = network.skip / scale, network.hidden_weights / scale[:, None]
    return TanhNetwork(network.bias - float(mean @ skip), skip, hidden,
                       network.hidden_bias - mean @ hidden, network.output_weights)


def pack_networks(networks: Sequence[TanhNetwork], prefix: str) -> dict[str, Array]:
    """Networks of one size as arrays to be stored, of five digits: the data tell no more."""
    columns = zip(TanhNetwork._fields, zip(*networks, strict=True), strict=True)
    return {prefix + name: round_to_digits(np.array(column)) for name, column in columns}


def round_to_digits(values: Array, digits: int = 5) -> Array:
    """Values rounded to so many significant digits, each the float nearest to that decimal."""
    told = [float(f"{value:.{digits}g}") for value in np.ravel(values)]
    return np.reshape(told, np.shape(values))
