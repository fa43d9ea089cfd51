"""Fitted weights: small neural networks, and the files that hold those of the package.

`python -m lab.training.split fit --write` stores the weights of `split`, and
`python -m lab.training.expected_errors --write` those of expected errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SPLIT_FILE = Path(__file__).parent / "weights" / "split.npz"
ERROR_FILE = SPLIT_FILE.with_name("expected_errors.npz")

LEAST_RANGE = 0.1
"""Of an input of expected errors that hardly varies in the fit."""


class TanhNetwork(NamedTuple):
    """A network with one hidden layer of hyperbolic tangents, beside a linear function.

    Its value is bias + skip x + output_weights tanh(hidden_weights x + hidden_bias) for K inputs
    x.
    """

    bias: float
    skip: Array  # (K,); weights of the inputs themselves, which skip the hidden layer
    hidden_weights: Array  # (K, n); for n hidden units
    hidden_bias: Array  # (n,)
    output_weights: Array

    def __call__(self, inputs: NDArray[np.floating]) -> Array:
        """Values (...) for inputs (..., K)."""
        hidden = np.tanh(inputs @ self.hidden_weights + self.hidden_bias)
        return np.asarray(self.bias + inputs @ self.skip + hidden @ self.output_weights,
                          dtype=float)


def _networks(stored: Mapping[str, Array], prefix: str) -> list[TanhNetwork]:
    """Read networks of one size, which are stored field by field."""
    columns = [stored[prefix + name] for name in TanhNetwork._fields]
    return [TanhNetwork(float(bias), *(np.array(row) for row in rows))
            for bias, *rows in zip(*columns, strict=True)]


class SplitFit(NamedTuple):
    """Networks for the logarithms of two factors; their inputs are `split.split_inputs`."""

    # factor of the area of {r < E}: parts that lose the last of their energy in a component
    left: TanhNetwork
    # factor of the solid angle of the faces that hold: parts that stay where they land
    held: TanhNetwork


class ErrorFit(NamedTuple):
    """Square error of one method as a function of part, estimate and scene."""

    # (K,); bounds of the inputs in the fit; beyond them the value is that of the nearest inputs
    lowest: Array
    highest: Array
    network: TanhNetwork
    # standard deviation, over parts of which the same is expected, of the logarithm of the square
    # error
    scatter: float

    def __call__(self, inputs: Array) -> Array:
        """Logarithm (...) of the expected square error over the mean of `error_scale`.

        `inputs` (..., K): as from `fitted_inputs.error_inputs`.
        """
        return self.network(np.clip(inputs, self.lowest, self.highest))

    def outside(self, inputs: Array) -> float:
        """How far inputs (K,) lie beyond those of the fit, in ranges of the input, summed."""
        beyond = np.maximum(inputs - self.highest, self.lowest - inputs)
        width = np.maximum(self.highest - self.lowest, LEAST_RANGE)
        return float(np.maximum(beyond / width, 0.0).sum())


with np.load(SPLIT_FILE) as _stored:
    SPLIT_FITS = tuple(map(SplitFit, _networks(_stored, "left_"), _networks(_stored, "held_")))
    """Fits from several random starts, whose logarithms are averaged."""

    HIGHEST_RESTITUTION, LOWEST_DROP, HIGHEST_DROP = _stored["scenes"].tolist()
    """Highest restitution, and drop heights in radii, of the samples of the fit."""

with np.load(ERROR_FILE) as _stored:
    _methods: list[str] = _stored["method"].tolist()

    ERROR_FITS = dict(zip(_methods, map(
        ErrorFit, _stored["lowest"], _stored["highest"], _networks(_stored, ""),
        _stored["scatter"].tolist()),
        strict=True))
    """By method; their inputs are `fitted_inputs.error_inputs`."""

    USUAL_AT: tuple[float, ...] = tuple(_stored["usual_at"].tolist())
    """Restitutions of the tuples below."""

    USUAL_ERRORS: dict[str, tuple[float, ...]] = {
        name: tuple(row) for name, row in zip(_methods, _stored["usual"].tolist(), strict=True)}
    """Root mean square error over the parts of the reference datasets, as a fraction."""
