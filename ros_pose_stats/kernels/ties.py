"""Values that agree within a tolerance are numbered as one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .array_types import Fixed1, FixedIndex1
from .compilation import entry_kernel

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@entry_kernel
def number_ties(values: Fixed1, tolerance: float, group: FixedIndex1,
                order: FixedIndex1) -> tuple[Index, int]:
    """Split groups into ties, each of which opens at its smallest value.

    Parameters
    ----------
    values : (S,) array
    tolerance : float
    group : (S,) array of int
    order : (S,) array of int
        By rising group, within a group by rising value.

    Returns
    -------
    numbers : (S,) array of int
        Of the ties, in that order.
    count : int
        How many there are.
    """
    numbers = np.empty(values.shape[0], np.int64)
    number, opened = -1, 0
    for i in range(order.shape[0]):
        here = order[i]
        if i == 0 or group[here] > group[opened] or values[here] - values[opened] > tolerance:
            number += 1
            opened = here
        numbers[here] = number
    return numbers, number + 1
