"""Expected errors against true ones, in bins of parts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from ...errors import RequestError
from .cost import INK, REFERENCE

Array = NDArray[np.float64]

COLUMNS = 4
BLUE = "#0072B2"


def reliability_figure(panels: Sequence[tuple[str, ArrayLike]]) -> Figure:
    """Draw what was expected across and what was found up, a panel a method.

    Parameters
    ----------
    panels : sequence of (title, (k, 3) array)
        Rows of expected error, true error, and the standard error of the true one; fractions.

    Returns
    -------
    Figure
        In percentage points; the diagonal is where both are the same.

    Raises
    ------
    RequestError
        No panel.
    """
    if not panels:
        raise RequestError("at least one panel", "none", "give one a method")
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(2.7 * columns + 0.5, 2.8 * rows + 0.9), layout="constrained")
    FigureCanvasAgg(figure)
    for place, (title, given) in enumerate(panels):
        axes = figure.add_subplot(rows, columns, place + 1)
        _draw(axes, title, 100.0 * np.asarray(given, dtype=np.float64).reshape(-1, 3))
    figure.suptitle("Does a larger expected error mean a larger true one? Parts in ten bins of "
                    "rising expected error", fontsize=12, color=INK)
    figure.supxlabel("expected error, percentage points", fontsize=11)
    figure.supylabel("true error, percentage points", fontsize=11)
    return figure


def _draw(axes: Axes, title: str, rows: Array) -> None:
    expected, true, error = rows.T
    end = 1.08 * float(max(expected.max(), (true + error).max()))
    axes.plot((0.0, end), (0.0, end), color=REFERENCE, linewidth=0.9, linestyle=":")
    axes.errorbar(expected, true, 2.0 * error, fmt="o", markersize=4.0, color=BLUE,
                  elinewidth=1.1)
    axes.set(xlim=(0.0, end), ylim=(0.0, end), aspect="equal")
    axes.set_title(title, fontsize=11, color=INK)
    axes.grid(color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
