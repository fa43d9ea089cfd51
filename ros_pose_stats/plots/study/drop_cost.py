"""Cost of a drop against the number of vertices, on logarithmic axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from .cost import INK, REFERENCE, STYLES

Array = NDArray[np.float64]


def drop_cost_figure(families: Sequence[tuple[str, ArrayLike, ArrayLike]],
                     title: str = "") -> Figure:
    """Draw the time of a drop against the number of vertices.

    Parameters
    ----------
    families : sequence of (label, (k,) array, (k,) array)
        Vertices, rising, and microseconds; at most as many as there are styles.
    title : str

    Returns
    -------
    Figure
        Log-log, a legend, and a line of slope 1 to compare with.
    """
    curves = [(label, np.asarray(count, dtype=np.float64), np.asarray(cost, dtype=np.float64))
              for label, count, cost in families]
    figure = Figure(figsize=(8.0, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set(xscale="log", yscale="log", xlabel="hull vertices", ylabel="time of a drop, µs",
             title=title)
    for (label, count, cost), (colour, dash, marker) in zip(curves, STYLES, strict=False):
        axes.plot(count, cost, color=colour, linestyle=dash, marker=marker, markersize=4.5,
                  linewidth=1.6, label=label)
    axes.legend(loc="upper left", frameon=False, fontsize=10, labelcolor=INK)
    everything = np.concatenate([cost for _, _, cost in curves])
    axes.set_ylim(float(everything.min()) / 2.0, float(everything.max()) * 2.0)
    axes.xaxis.set_major_formatter(_plain)
    axes.yaxis.set_major_formatter(_plain)
    _slope_one(axes, np.concatenate([count for _, count, _ in curves]), everything)
    axes.grid(which="major", color="#dddddd", linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def _plain(value: float, _: float) -> str:
    """Tick label without an exponent, thousands apart."""
    return f"{value:,g}".replace(",", " ")


def _slope_one(axes: Axes, count: Array, cost: Array) -> None:
    """A thin line proportional to the number of vertices, below the data at its right end."""
    ends = np.array((count.max() / 12.0, count.max()))
    low = 0.75 * cost.min()
    axes.plot(ends, low * ends / ends[0], color=REFERENCE, linewidth=1.0, linestyle=":")
    axes.annotate("slope 1", (ends[0], low), xytext=(-5, 0), textcoords="offset points",
                  ha="right", va="center", color=REFERENCE, fontsize=9)
