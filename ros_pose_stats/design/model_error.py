"""How far a difference between two variants may be off on a real plate.

A share that drops tell is off by `plate_error` on a real plate, whatever the number of drops. Two
variants that are alike are off alike, so most of that is gone from their difference. A part of it
stays however small the difference, more with the difference, up to that of two parts that have
nothing to do with each other.
"""

from __future__ import annotations

import math
from typing import Final

LEFT: Final = 0.1
"""Error of a difference that is nearly 0, over the plate's error of a single share."""

KEPT: Final = 0.35
"""Error of a larger difference over the difference. Both cover what rolled dice and simulated
plates have shown, with single shares off by up to 9 points (tests/truth/design)."""

EXPORTED: Final = 0.005
"""Standard deviation by which shares of two exports of one round part differ: the drops see the
facets of the file, not the part (docs/measured/exports.md)."""


def plate_part(difference: float, plate_error: float) -> float:
    """Standard deviation of what a plate adds to a difference of two shares.

    `difference`: of the shares in the model, -1 to 1; `plate_error`: of a single share on the
    plate, a fraction.
    """
    return min(math.sqrt(2.0) * plate_error, math.hypot(LEFT * plate_error, KEPT * difference))
