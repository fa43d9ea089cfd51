"""What figures share: colours, axes, and labels that do not overlap."""

import math
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..records import Array

INK, REFERENCE = "#222222", "#767676"
"""Colours of text and outlines, and of the background: grids, notes, lines to compare with."""

BLUE = "#0072B2"


def new_figure(width: float, height: float, **options: Any) -> Figure:
    """A figure of so many inches, drawn by Agg whatever backend the user has chosen."""
    figure = Figure(figsize=(width, height), **options)
    FigureCanvasAgg(figure)
    return figure


def open_axes(axes: Axes, grid: str, width: float, axis: Literal["both", "x", "y"] = "both"
              ) -> None:
    """Grid lines of a colour and a width behind the data; no frame above and to the right."""
    axes.grid(which="major", axis=axis, color=grid, linewidth=width)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def apart(heights: Array, gap: float, low: float = -math.inf, high: float = math.inf) -> Array:
    """Move heights (k,) as little as it takes to lie `gap` apart in order; `high` may give way."""
    order = np.argsort(heights, kind="stable")
    steps = gap * np.arange(len(heights))
    rising = _nearest_rising(heights[order] - steps)
    highest = high - gap * (len(heights) - 1)
    placed = np.empty_like(heights)
    placed[order] = np.maximum(np.minimum(rising, highest), low) + steps
    return placed


def _nearest_rising(values: Array) -> Array:
    """Nearest sequence that never falls: neighbours that fall are pooled into their mean."""
    pools: list[tuple[float, int]] = []
    for value in values:
        mean, size = float(value), 1
        while pools and pools[-1][0] > mean:
            before, count = pools.pop()
            mean, size = (before * count + mean * size) / (count + size), count + size
        pools.append((mean, size))
    return np.array([mean for mean, size in pools for _ in range(size)])


def in_digits(value: float, digits: int) -> str:
    """A length with so many digits, never with an exponent where it is large."""
    return f"{value:.{digits}g}" if value < 10.0 ** digits else f"{value:.0f}"
