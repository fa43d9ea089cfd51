"""A smooth function of a few numbers, as fits take it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Bent(NamedTuple):
    """Constant + slope x + bends tanh(turns x + offsets), with K inputs x.

    Attributes
    ----------
    constant : float
    slope : (K,) array
    turns : (K, n) array
    offsets, bends : (n,) array
    """

    constant: float
    slope: Array
    turns: Array
    offsets: Array
    bends: Array

    def __call__(self, inputs: NDArray[np.floating]) -> Array:
        """Values (...) for inputs (..., K)."""
        bent = np.tanh(inputs @ self.turns + self.offsets)
        return np.asarray(self.constant + inputs @ self.slope + bent @ self.bends, dtype=float)
