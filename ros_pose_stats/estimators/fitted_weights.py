"""Fitted weights: small neural networks, and the files that hold those of the package.

`python -m training.split fit --write` stores the weights of `split`, and
`python -m training.expected_errors --write` those of expected errors.
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


class TanhNetwork(NamedTuple):
    """One layer of hyperbolic tangents beside a linear function.

    bias + skip x + output_weights tanh(hidden_weights x + hidden_bias), with K inputs x.

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


def _networks(stored: Mapping[str, Array], prefix: str) -> list[TanhNetwork]:
    """Networks of one size, stored field by field."""
    columns = [stored[prefix + name] for name in TanhNetwork._fields]
    return [TanhNetwork(float(bias), *(np.array(row) for row in rows))
            for bias, *rows in zip(*columns, strict=True)]


class SplitFit(NamedTuple):
    """Logarithms of factors, of the inputs of `split.split_inputs`.

    Attributes
    ----------
    left : TanhNetwork
        On the area of {r < E}: parts that the last of their energy leaves in a component.
    held : TanhNetwork
        On the solid angle of the faces that hold: parts that are caught where they land.
    """

    left: TanhNetwork
    held: TanhNetwork


class ErrorFit(NamedTuple):
    """How the square error of one method grows with what is known of the part and the scene.

    Attributes
    ----------
    lowest, highest : (K,) array
        Inputs of the fit; beyond them the answer is that for the nearest ones.
    network : TanhNetwork
    """

    lowest: Array
    highest: Array
    network: TanhNetwork

    def __call__(self, inputs: Array) -> Array:
        """Logarithm (...) of the expected square error over the mean of `error_scale`.

        Parameters
        ----------
        inputs : (..., K) array
            As from `fitted_inputs.error_inputs`.
        """
        return self.network(np.clip(inputs, self.lowest, self.highest))


with np.load(SPLIT_FILE) as _stored:
    SPLIT_FITS = tuple(map(SplitFit, _networks(_stored, "left_"), _networks(_stored, "held_")))
    """From several starts; the mean of their logarithms counts."""

    HIGHEST_RESTITUTION, HIGHEST_DROP = _stored["highest"].tolist()
    """What the fit has seen goes up to here; the drop in radii."""

with np.load(ERROR_FILE) as _stored:
    _methods: list[str] = _stored["method"].tolist()

    ERROR_FITS = dict(zip(_methods, map(
        ErrorFit, _stored["lowest"], _stored["highest"], _networks(_stored, "")),
        strict=True))
    """By method, of the inputs of `fitted_inputs.error_inputs`."""

    USUAL_AT: tuple[float, ...] = tuple(_stored["usual_at"].tolist())
    """Restitutions of the tuples below."""

    USUAL_ERRORS: dict[str, tuple[float, ...]] = {
        name: tuple(row) for name, row in zip(_methods, _stored["usual"].tolist(), strict=True)}
    """Root mean square error over the parts of the reference datasets, as a fraction."""
