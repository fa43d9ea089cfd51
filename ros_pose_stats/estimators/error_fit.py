"""How the square error of an estimate grows with what is known of the part and the scene."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bent import Bent

Array = NDArray[np.float64]


class ErrorFit(NamedTuple):
    """Of one method.

    Attributes
    ----------
    lowest, highest : (K,) array
        Inputs of the fit; beyond them the answer is that for the nearest ones.
    bent : Bent
    """

    lowest: Array
    highest: Array
    bent: Bent

    def __call__(self, inputs: Array) -> Array:
        """Logarithm (...) of the expected square error over the mean of `doubts`.

        Parameters
        ----------
        inputs : (..., K) array
            As from `error_inputs.error_inputs`.
        """
        return self.bent(np.clip(inputs, self.lowest, self.highest))
