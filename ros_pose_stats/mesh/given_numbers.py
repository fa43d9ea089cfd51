"""Numbers as they are handed over: lists, arrays of any kind, masked arrays."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

NOT_NUMBERS: Final = (TypeError, ValueError, OverflowError)
"""What the functions below raise for what cannot be read as real numbers."""

# Complex numbers, dates and durations convert to floats, but not without losing their meaning.
_NOT_REAL: Final = "cMm"


def unmasked(values: Any) -> NDArray[Any]:
    """As an array; masked entries are missing, so they become NaN.

    Raises
    ------
    TypeError, ValueError
        If the rows differ in length, or the numbers are not real ones.
    """
    array = np.asarray(values)
    if array.dtype.kind in _NOT_REAL:
        raise TypeError(f"{array.dtype} is no real number")
    if isinstance(values, np.ma.MaskedArray) and np.any(values.mask):
        incomplete: Any = values.astype(np.float64)
        return np.asarray(incomplete.filled(np.nan))
    return array


def real_array(values: Any) -> NDArray[np.float64]:
    """As float64, without a copy where it is that already; beyond its range: infinite.

    Raises
    ------
    TypeError, ValueError, OverflowError
        If these are no real numbers.
    """
    with np.errstate(over="ignore"):
        return unmasked(values).astype(np.float64, copy=False)


def real_number(value: Any) -> float:
    """One number as a float.

    Raises
    ------
    TypeError, ValueError, OverflowError
        If it is none, or an array of numbers.
    """
    if np.ndim(value) > 0:
        raise TypeError("an array is no number")
    return float(real_array(value))
