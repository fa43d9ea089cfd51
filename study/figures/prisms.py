# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Square prisms: estimators, simulation and measured dice over length/width (Fig.
5).
"""

from collections.abc import Iterator, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from numpy.typing import ArrayLike

from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.plots.figures import INK

from .curves import LINES, Curves, Marker, draw_bars, merge_curves, row_of_panels

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
    figure, all_axes = row_of_panels(
        [name for name, _ in panels],
        5.6,
        title,
        "probability of the four sides together, %",
        note,
    )
    styles = cycle(LINES)
    for axes, (_, curves) in zip(all_axes, panels, strict=True):
        _prepare(axes)
        lines = _draw_curves(axes, np.asarray(ratios, dtype=np.float64), curves, styles)
        points = _draw_points(axes, simulated, dice)
        _legends(axes, lines, points)
    return figure


def _prepare(axes: Axes) -> None:
    axes.set(
        xscale="log",
        xlim=LIMITS,
        ylim=(-2.0, 102.0),
        xlabel="length / width of the prism",
    )
    axes.xaxis.set_major_locator(FixedLocator(TICKS))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_yticks(range(0, 101, 20))


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
        x = OFFSET ** (number - 0.5 * (len(series) - 1)) * rows[:, 0]
        diamond = Marker("D", GREYS[number], INK, 4.8, 0.8, 1.1)
        artists.append(draw_bars(axes, x, rows[:, 1:].T, label, diamond))
    if dice is not None and (rows := _rows(dice)).size:
        # Hollow, so that points beneath can be seen.
        square = Marker("s", "none", DICE, 4.8, 1.5, 1.1)
        artists.append(
            draw_bars(axes, rows[:, 0], rows[:, 1:].T, "measured dice", square)
        )
    return artists


def _rows(samples: ArrayLike) -> Array:
    return np.asarray(samples, dtype=np.float64).reshape(-1, 4)


def _legends(axes: Axes, lines: Sequence[object], points: Sequence[object]) -> None:
    """Curves in the lower right corner and points in the upper left: both are empty."""
    common = {"frameon": False, "fontsize": 9.5, "labelcolor": INK, "alignment": "left"}
    if points:
        axes.add_artist(axes.legend(handles=points, loc="upper left", **common))
    axes.legend(handles=lines, loc="lower right", handlelength=4.2, **common)
