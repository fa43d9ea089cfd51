"""Predictions of the estimators against the simulation: the paper's Fig. 4."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import ArrayLike

from ...errors import RequestError
from .cost import INK, REFERENCE
from .dots import Array, axis_end, draw_dots, paired

COLUMNS = 3


class Panel(NamedTuple):
    """One estimator.

    Attributes
    ----------
    title : str
        Its name.
    estimated, simulated : (N,) array
        Probabilities, 0 to 1; one value of each a stable pose.
    error : float
        Eq. 4, as a fraction of 1.
    largest : float
        Largest deviation of a prediction from the simulation, as a fraction of 1.
    curve : (x, y) or None
        Two (k,) arrays, 0 to 1: a function fitted to the dots, Eq. 6.
    """

    title: str
    estimated: ArrayLike
    simulated: ArrayLike
    error: float
    largest: float
    curve: tuple[ArrayLike, ArrayLike] | None = None


def estimators_figure(panels: Sequence[Panel], drops: int) -> Figure:
    """Draw what each estimator predicts against what was simulated.

    Parameters
    ----------
    panels : sequence of Panel
        At least one; three in a row.
    drops : int
        Of each part in the simulation.

    Returns
    -------
    Figure
        The same square axes in every panel.

    Raises
    ------
    RequestError
        No panel, an empty one, unequal lengths, or a value that is no probability.
    """
    if not panels:
        raise RequestError("at least one panel", "none", "give one an estimator")
    dots = [paired(panel.estimated, panel.simulated, panel.title) for panel in panels]
    end = axis_end(*(values for pair in dots for values in pair))
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(max(3.1 * columns + 0.6, 6.0), 3.5 * rows + 0.9), dpi=160,
                    layout=ConstrainedLayoutEngine(w_pad=0.1))
    FigureCanvasAgg(figure)
    for place, (panel, (across, up)) in enumerate(zip(panels, dots, strict=True)):
        axes = figure.add_subplot(rows, columns, place + 1)
        draw_dots(axes, across, up, end, size=2.0)
        _name(axes, panel)
        if panel.curve is not None:
            _draw_curve(axes, np.asarray(panel.curve, dtype=np.float64), end)
        axes.tick_params(labelbottom=place + columns >= len(panels),
                         labelleft=place % columns == 0)
    figure.suptitle("Predicted against simulated probabilities, one dot a stable pose",
                    fontsize=13)
    figure.supxlabel("probability predicted by the estimator", fontsize=12)
    figure.supylabel(f"simulated probability, n = {drops}", fontsize=12)
    return figure


def _name(axes: Axes, panel: Panel) -> None:
    """Name and error above the panel, the largest deviation in smaller print."""
    axes.set_title(f"{panel.title}, error {100.0 * panel.error:.1f} %", fontsize=12, color=INK,
                   pad=19.0)
    small = f"largest deviation {100.0 * panel.largest:.1f} %"
    if panel.curve is not None:
        small += ", curve: fitted"
    axes.annotate(small, (0.5, 1.0),
                  xycoords="axes fraction", xytext=(0.0, 6.0), textcoords="offset points",
                  ha="center", va="bottom", fontsize=9.5, color=REFERENCE)


def _draw_curve(axes: Axes, curve: Array, end: float) -> None:
    """A solid line, as far as the axes go."""
    across, up = curve[:, curve[0] <= end]
    axes.plot(across, up, color="#000000", linewidth=1.8, zorder=3)
