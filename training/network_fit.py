"""What fits of networks share: coefficients in one array, their gradient, and their storage."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from ros_pose_stats.estimators.fitted_weights import TanhNetwork

Array = NDArray[np.float64]
Floats = NDArray[np.floating]


def coefficient_count(columns: int, units: int) -> int:
    """Number of coefficients of a network with so many inputs and hidden units."""
    return 1 + columns + (columns + 2) * units


def random_coefficients(columns: int, units: int, draw: Generator) -> Array:
    """Coefficients of a network whose value is 0, with random weights of the hidden units."""
    return np.concatenate(([0.0], np.zeros(columns),
                           draw.normal(size=columns * units) / math.sqrt(columns),
                           0.1 * draw.normal(size=units), np.zeros(units)))


def network_of(values: Array, columns: int, units: int) -> TanhNetwork:
    """Network with the coefficients of one array."""
    end = 1 + columns * (1 + units)
    return TanhNetwork(float(values[0]), values[1:1 + columns],
                       values[1 + columns:end].reshape(columns, units), values[end:end + units],
                       values[end + units:])


def network_gradient(network: TanhNetwork, tangents: Floats, inputs: Floats,
                     back: Floats) -> Floats:
    """Gradient by the coefficients, from the gradient `back` (n,) by the values of rows (n, K)."""
    inner = (1.0 - tangents * tangents) * np.outer(back, network.output_weights)
    return np.concatenate(([back.sum()], inputs.T @ back, (inputs.T @ inner).ravel(),
                           inner.sum(axis=0), tangents.T @ back))


def undo_scaling(network: TanhNetwork, mean: Floats, scale: Floats) -> TanhNetwork:
    """The same function of x as a network, from a network of (x - mean) / scale."""
    skip, hidden = network.skip / scale, network.hidden_weights / scale[:, None]
    return TanhNetwork(network.bias - float(mean @ skip), skip, hidden,
                       network.hidden_bias - mean @ hidden, network.output_weights)


def pack_networks(networks: Sequence[TanhNetwork], prefix: str) -> dict[str, Array]:
    """Networks of one size as arrays to store, rounded to five digits: the data give no more."""
    columns = zip(TanhNetwork._fields, zip(*networks, strict=True), strict=True)
    return {prefix + name: round_to_digits(np.array(column)) for name, column in columns}


def round_to_digits(values: Array, digits: int = 5) -> Array:
    """Values rounded to so many significant digits, each the float nearest to that decimal."""
    rounded = [float(f"{value:.{digits}g}") for value in np.ravel(values)]
    return np.reshape(rounded, np.shape(values))
