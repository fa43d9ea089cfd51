"""A small neural network: one layer of hyperbolic tangents beside a linear function."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class TanhNetwork(NamedTuple):
    """bias + skip x + output_weights tanh(hidden_weights x + hidden_bias), with K inputs x.

    Attributes
    ----------
    bias : float
    skip : (K,) array
        Weights of the inputs themselves, which skip the hidden layer.
    hidden_weights : (K, n) array
        Of n units.
    hidden_bias, output_weights : (n,) array
    """

    bias: float
    skip: Array
    hidden_weights: Array
    hidden_bias: Array
    output_weights: Array

    def __call__(self, inputs: NDArray[np.floating]) -> Array:
        """Values (...) for inputs (..., K)."""
        hidden = np.tanh(inputs @ self.hidden_weights + self.hidden_bias)
        return np.asarray(self.bias + inputs @ self.skip + hidden @ self.output_weights,
                          dtype=float)


def pack_networks(networks: Sequence[TanhNetwork], prefix: str) -> dict[str, Array]:
    """Networks of one size as arrays to be stored, of five digits: the data tell no more."""
    columns = zip(TanhNetwork._fields, zip(*networks, strict=True), strict=True)
    return {prefix + name: round_to_digits(np.array(column)) for name, column in columns}


def unpack_networks(stored: Mapping[str, Array], prefix: str) -> list[TanhNetwork]:
    """The networks that `pack_networks` was given, rounded."""
    columns = [stored[prefix + name] for name in TanhNetwork._fields]
    return [TanhNetwork(float(bias), *(np.array(row) for row in rows))
            for bias, *rows in zip(*columns, strict=True)]


def round_to_digits(values: Array, digits: int = 5) -> Array:
    """Values rounded to so many significant digits, each the float nearest to that decimal."""
    told = [float(f"{value:.{digits}g}") for value in np.ravel(values)]
    return np.reshape(told, np.shape(values))
