"""Curves of several methods in one figure: colours, dashes, and common names of equal
ones.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

Curves = Sequence[tuple[str, ArrayLike]]

EQUAL = 1e-9
"""Largest difference of two curves that are drawn as one line with both names."""

# For the colour-blind: four of Okabe and Ito's, eight of Tol's "muted", none near the
# dice's vermilion. Neighbours have different dashes too, so that nobody needs to see
# colours.
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


def merge_curves(curves: Curves) -> list[tuple[str, Array]]:
    """Join equal curves under a common label, since one would hide the other."""
    joined: list[tuple[str, Array]] = []
    for label, samples in curves:
        values = np.asarray(samples, dtype=np.float64)
        for row, (names, curve) in enumerate(joined):
            if np.abs(values - curve).max() < EQUAL:
                joined[row] = f"{names} = {label}", curve
                break
        else:
            joined.append((label, values))
    return joined
