"""How far a difference between two variants may be off on a real plate.

A share that drops tell is off by `plate_error` on a real plate, whatever the number of drops. Two
variants that are alike are off alike, so most of that is gone from their difference. What is left
grows with the difference itself, up to that of two parts that have nothing to do with each other.
"""

from __future__ import annotations

import math
from typing import Final

KEPT: Final = 6.0
"""Error of a difference over the plate's error and the difference: three tenths of a difference at
5 points. Rolled dice and simulated plates stand behind it: tests/design/test_model_error.py."""

EXPORTED: Final = 0.005
"""Standard deviation by which shares of two exports of one round part differ: the drops see the
facets of the file, not the part (docs/study/exports.md)."""


def plate_part(difference: float, plate_error: float) -> float:
    """Standard deviation of what a plate adds to a difference of two shares.

    Parameters
    ----------
    difference : float
        Of the shares in the model, -1 to 1.
    plate_error : float
        Of a single share on the plate, a fraction.
    """
    return plate_error * min(math.sqrt(2.0), KEPT * abs(difference))
