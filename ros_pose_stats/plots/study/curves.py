"""Styles of curves that are told apart by colour and by dashes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Curves = Sequence[tuple[str, ArrayLike]]

EQUAL = 1e-9
"""Curves closer than this everywhere are one line with both names."""

# For the colour-blind: four of Okabe and Ito's, eight of Tol's "muted", none near the dice's
# vermilion. Neighbours have different dashes too, so that nothing hangs on the colour.
LINES: tuple[tuple[str, object], ...] = (
    ("#0072B2", "-"),
    ("#E69F00", (0, (6, 1.6))),
    ("#009E73", (0, (5, 1.4, 1, 1.4))),
    ("#CC79A7", (0, (1.2, 1.0))),
    ("#332288", "-"),
    ("#999933", (0, (6, 1.6))),
    ("#44AA99", (0, (5, 1.4, 1, 1.4))),
    ("#882255", (0, (1.2, 1.0))),
    ("#661100", "-"),
    ("#88CCEE", (0, (6, 1.6))),
    ("#117733", (0, (5, 1.4, 1, 1.4))),
    ("#DDCC77", (0, (1.2, 1.0))),
)


def merged(curves: Curves) -> list[tuple[str, Array]]:
    """Curves with equal ones under a common label, for one would hide the other."""
    merged: list[tuple[str, Array]] = []
    for label, given in curves:
        values = np.asarray(given, dtype=np.float64)
        for place, (names, known) in enumerate(merged):
            if np.abs(values - known).max() < EQUAL:
                merged[place] = f"{names} = {label}", known
                break
        else:
            merged.append((label, values))
    return merged
