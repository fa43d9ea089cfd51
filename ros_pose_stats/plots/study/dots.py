"""Square axes of probabilities with one dot a stable pose, and the checks of what they show."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from ...errors import RequestError
from .cost import INK

Array = NDArray[np.float64]

BLUE = "#0072B2"
FAINTEST, STRONGEST = 0.12, 0.8
"""Opacity of a dot among many and among few."""

OPAQUE_IN_ALL = 2000.0
"""Dots of opacity 1 that all dots together are worth, between these bounds."""

ROUNDING = 1e-9
"""A probability may be off its bounds by so much."""


def paired(across: ArrayLike, up: ArrayLike, what: str) -> tuple[Array, Array]:
    """Probabilities in pairs, checked.

    Parameters
    ----------
    across, up : (N,) array
        Probabilities, 0 to 1.
    what : str
        Named in a refusal.

    Raises
    ------
    RequestError
        Nothing to draw, unequal lengths, or a value that is no probability.
    """
    pair = np.asarray(across, dtype=np.float64), np.asarray(up, dtype=np.float64)
    shapes = [values.shape for values in pair]
    if shapes[0] != shapes[1] or pair[0].ndim != 1 or not pair[0].size:
        raise RequestError(f"two equally long rows of probabilities for {what}",
                           f"shapes {shapes[0]} and {shapes[1]}",
                           "give one value of each a stable pose, at least one")
    for values in pair:
        bad = ~((values >= -ROUNDING) & (values <= 1.0 + ROUNDING))
        if bad.any():
            raise RequestError(f"probabilities from 0 to 1 for {what}",
                               f"{values[bad][0]} at place {int(np.argmax(bad))}",
                               "leave such poses out of both rows")
    return pair


def axis_end(*rows: Array) -> float:
    """Largest value, rounded up to the next tenth; at least 0.1."""
    largest = max(float(values.max()) for values in rows)
    return max(math.ceil(10.0 * largest - 1e-9), 1) / 10.0


def draw_dots(axes: Axes, across: Array, up: Array, end: float, size: float) -> None:
    """Draw the dots and the diagonal on square axes from 0 to `end`.

    Parameters
    ----------
    axes : Axes
    across, up : (N,) array
        Probabilities.
    end : float
        Of both axes.
    size : float
        Diameter of a dot, points (1/72 inch).
    """
    opacity = min(max(OPAQUE_IN_ALL / len(across), FAINTEST), STRONGEST)
    axes.plot(across, up, color=BLUE, linestyle="none", marker="o", markersize=size,
              markeredgewidth=0.0, alpha=opacity, clip_on=False, rasterized=True, zorder=1)
    axes.plot((0.0, end), (0.0, end), color=INK, linewidth=0.8, linestyle=(0, (5, 3)), zorder=2)
    ticks = np.arange(0.0, end + 1e-9, 0.1 if end < 0.45 else 0.2)
    axes.set(xlim=(0.0, end), ylim=(0.0, end), aspect="equal", xticks=ticks, yticks=ticks)
    axes.xaxis.set_major_formatter("{x:.1f}")
    axes.yaxis.set_major_formatter("{x:.1f}")
    axes.spines[["top", "right"]].set_visible(False)
