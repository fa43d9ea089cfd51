"""Square prisms: estimators, simulation and measured dice over length/width (Fig.
5).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from numpy.typing import ArrayLike, NDArray

from ros_pose_stats.tools.plots.figures import INK, REFERENCE, new_figure, open_axes

from .curves import LINES, Curves, merge_curves

Array = NDArray[np.float64]

TICKS = (0.3, 0.5, 1.0, 2.0, 3.0)
LIMITS = (0.28, 3.2)
GREYS = ("#ffffff", "#a6a6a6", "#222222", "#d9d9d9", "#666666")
"""Filling of the simulation's diamonds."""
DICE = "#D55E00"
OFFSET = 1.03
"""Factor of length/width between the bars of neighbouring restitutions."""


def prisms_figure(
    ratios: ArrayLike,
    panels: Sequence[tuple[str, Curves]],
    simulated: Sequence[tuple[str, ArrayLike]] = (),
    dice: ArrayLike | None = None,
    title: str = "",
    note: str = "",
) -> Figure:
    """Draw the probability of the four sides of square prisms over length/width.

    Parameters
    ----------
    ratios : (k,) array
        Length over width of the curves, rising, 0.3 to 3.
    panels : sequence of (title, curves)
        One panel each, at least one; curves are pairs of a label and probabilities
        (k,), 0 to 1. Equal curves of a panel are drawn as one. Styles repeat after
        twelve lines.
    simulated : sequence of (label, (m, 4) array)
        Rows of length over width, probability, and the bounds of its interval; drawn in
        every panel as diamonds, the lighter the earlier, at most five. Set apart
        sideways a little so that no bar covers another. An empty one is left out.
    dice : (m, 4) array, optional
        Such rows, measured; drawn in every panel as squares.
    title : str
    note : str
        A line below the panels.

    Returns
    -------
    Figure
        Logarithmic in length/width, in percent; a legend of curves and of points to a
        panel.
    """
    figure = new_figure(6.2 * len(panels), 5.6, layout="constrained")
    all_axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    styles = cycle(LINES)
    for axes, (name, curves) in zip(all_axes, panels, strict=True):
        _prepare(axes, name)
        lines = _draw_curves(axes, np.asarray(ratios, dtype=np.float64), curves, styles)
        points = _draw_points(axes, simulated, dice)
        _legends(axes, lines, points)
    all_axes[0].set_ylabel("probability of the four sides together, %")
    figure.suptitle(title, fontsize=12, color=INK)
    figure.supxlabel(note, fontsize=9, color=REFERENCE)
    return figure


def _prepare(axes: Axes, title: str) -> None:
    axes.set(
        xscale="log",
        xlim=LIMITS,
        ylim=(-2.0, 102.0),
        xlabel="length / width of the prism",
    )
    axes.set_title(title, fontsize=11, color=INK)
    axes.xaxis.set_major_locator(FixedLocator(TICKS))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_yticks(range(0, 101, 20))
    axes.yaxis.set_tick_params(labelleft=True)
    open_axes(axes, "#dddddd", 0.7)


def _draw_curves(
    axes: Axes, ratios: Array, curves: Curves, styles: Iterator[tuple[str, object]]
) -> list[object]:
    """Lines, the highest at the right end first, as they lie beside the legend."""
    ordered = sorted(merge_curves(curves), key=lambda curve: -curve[1][-1])
    lines: list[object] = []
    for label, values in ordered:
        colour, dashes = next(styles)
        lines += axes.plot(
            ratios,
            100.0 * values,
            color=colour,
            linestyle=dashes,
            linewidth=2.0,
            label=label,
            zorder=2.0,
        )
    return lines


def _draw_points(
    axes: Axes, simulated: Sequence[tuple[str, ArrayLike]], dice: ArrayLike | None
) -> list[object]:
    series = [
        (label, rows) for label, samples in simulated if (rows := _rows(samples)).size
    ]
    artists: list[object] = []
    for number, (label, rows) in enumerate(series):
        shift = OFFSET ** (number - 0.5 * (len(series) - 1))
        artists.append(_bars(axes, rows, shift, label, "D", GREYS[number], INK, 0.8))
    if dice is not None and _rows(dice).size:
        # Hollow, so that points beneath can be seen.
        artists.append(
            _bars(axes, _rows(dice), 1.0, "measured dice", "s", "none", DICE, 1.5)
        )
    return artists


def _rows(samples: ArrayLike) -> Array:
    return np.asarray(samples, dtype=np.float64).reshape(-1, 4)


def _bars(
    axes: Axes,
    rows: Array,
    shift: float,
    label: str,
    marker: str,
    filling: str,
    edge: str,
    thickness: float,
) -> object:
    ratio, probability, low, high = rows.T
    # A bar must not be shorter than 0, not even by a rounding.
    lengths = 100.0 * np.maximum((probability - low, high - probability), 0.0)
    return axes.errorbar(
        ratio * shift,
        100.0 * probability,
        lengths,
        label=label,
        fmt=marker,
        markersize=4.8,
        markerfacecolor=filling,
        markeredgecolor=edge,
        markeredgewidth=thickness,
        ecolor=edge,
        elinewidth=1.1,
        zorder=3.0,
    )


def _legends(axes: Axes, lines: Sequence[object], points: Sequence[object]) -> None:
    """Curves in the lower right corner and points in the upper left: both are empty."""
    common = {"frameon": False, "fontsize": 9.5, "labelcolor": INK, "alignment": "left"}
    if points:
        axes.add_artist(axes.legend(handles=points, loc="upper left", **common))
    axes.legend(handles=lines, loc="lower right", handlelength=4.2, **common)
