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

"""The stability study: probabilities along a walk, and expected errors against true
ones.
"""

from collections.abc import Iterator, Sequence
from itertools import cycle
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.plots.figures import (
    BLUE,
    INK,
    REFERENCE,
    new_figure,
    open_axes,
)

from .curves import LINES, Marker, draw_bars, merge_curves, row_of_panels

JUMP = "#D55E00"
PALE = "#b9bfc4"
MARGIN = 0.03
LABEL = 44
"""Characters of a line beside the axis."""
FEW_DECADES = 10.5
"""Natural logarithm of a range whose tick labels need no exponents."""


class WalkCurve(NamedTuple):
    """A method along a walk.

    Attributes
    ----------
    label : str
    values : (k,) array
        Probabilities, 0 to 1.
    jumps : sequence of (value, size)
        Place and size of each jump.
    """

    label: str
    values: ArrayLike
    jumps: Sequence[tuple[float, float]] = ()


class WalkPanel(NamedTuple):
    """Curves of one panel.

    Attributes
    ----------
    title : str
    curves : sequence of WalkCurve
        Equal ones are drawn as one.
    behind : sequence of WalkCurve
        Curves drawn pale behind them, under one name.
    behind_name : str
    """

    title: str
    curves: Sequence[WalkCurve]
    background: Sequence[WalkCurve] = ()
    behind_name: str = ""


def walk_figure(
    parameter: ArrayLike,
    panels: Sequence[WalkPanel],
    simulated: ArrayLike,
    label: str,
    quantity: str,
    *,
    logarithmic: bool,
    mark: float | None = None,
    title: str = "",
    note: str = "",
) -> Figure:
    """Draw probabilities over a parameter.

    Parameters
    ----------
    parameter : (k,) array
        Rising; above 0 where the axis is logarithmic.
    panels : sequence of WalkPanel
        At least one.
    simulated : (3, k) array
        Probability and the bounds of its interval, drawn in every panel.
    label, quantity : str
        Of the axes.
    logarithmic : bool
    mark : float, optional
        Value of the parameter at which a vertical line is drawn.
    title, note : str
        Above and below the panels.

    Returns
    -------
    Figure
        A cross where a curve jumps; probabilities in percent, from 0 to what is needed.
    """
    x = np.asarray(parameter, dtype=np.float64)
    points = np.asarray(simulated, dtype=np.float64)
    curves = [curve for panel in panels for curve in (*panel.background, *panel.curves)]
    figure, all_axes = row_of_panels(
        [panel.title for panel in panels],
        5.2,
        title,
        fill(f"probability of {quantity}, %", LABEL),
        note,
    )
    top = max(
        float(points[2].max()), *(float(np.max(curve.values)) for curve in curves)
    )
    styles = cycle(LINES)
    for axes, panel in zip(all_axes, panels, strict=True):
        axes.set(
            xscale="log" if logarithmic else "linear",
            xlabel=label,
            ylim=(-2.0 * top, 104.0 * top),
        )
        _set_limits(axes, x, logarithmic)
        _draw_curves(axes, x, panel, iter(LINES) if panel.background else styles)
        _draw_jumps(axes, x, panel.curves)
        draw_bars(axes, x, points, "drop simulation", Marker())
        if mark is not None:
            axes.axvline(mark, color=REFERENCE, linewidth=0.9, linestyle=":")
        axes.legend(
            frameon=False,
            fontsize=9,
            labelcolor=INK,
            handlelength=3.6,
            loc="upper center",
            bbox_to_anchor=(0.5, -0.16),
            ncols=3,
        )
    return figure


def _draw_curves(
    axes: Axes, x: Array, panel: WalkPanel, styles: Iterator[tuple[str, object]]
) -> None:
    for number, walk_curve in enumerate(panel.background):
        axes.plot(
            x,
            100.0 * np.asarray(walk_curve.values),
            color=PALE,
            linewidth=1.1,
            zorder=1.5,
            label="_" if number else panel.behind_name,
        )
    for names, curve in merge_curves(
        [(walk_curve.label, walk_curve.values) for walk_curve in panel.curves]
    ):
        colour, dashes = next(styles)
        axes.plot(
            x,
            100.0 * curve,
            color=colour,
            linestyle=dashes,
            label=names,
            zorder=2.0,
            linewidth=2.6 if panel.background else 1.9,
        )


def _set_limits(axes: Axes, x: Array, logarithmic: bool) -> None:
    """As wide as the walk, and a little more."""
    ends = np.log(x[[0, -1]]) if logarithmic else x[[0, -1]]
    room = MARGIN * (ends[1] - ends[0])
    limits = ends[0] - room, ends[1] + room
    axes.set_xlim(*(np.exp(limits) if logarithmic else limits))
    if logarithmic and limits[1] - limits[0] < FEW_DECADES:
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")


def _draw_jumps(axes: Axes, x: Array, curves: Sequence[WalkCurve]) -> None:
    """A cross in the middle of each jump."""
    crosses = [
        (position, float(np.interp(position, x, np.asarray(curve.values))))
        for curve in curves
        for position, _ in curve.jumps
    ]
    if crosses:
        jump_x, jump_y = np.array(crosses).T
        axes.plot(
            jump_x,
            100.0 * jump_y,
            linestyle="none",
            marker="x",
            markersize=8.0,
            markeredgewidth=1.8,
            color=JUMP,
            label="jump",
            zorder=4.0,
        )


COLUMNS = 4


def reliability_figure(panels: Sequence[tuple[str, ArrayLike]]) -> Figure:
    """Draw true errors over expected ones, a panel for each method.

    Parameters
    ----------
    panels : sequence of (title, (k, 3) array)
        Rows of expected error, true error, and the standard error of the true one;
        fractions.

    Returns
    -------
    Figure
        In percentage points; the diagonal is where both are the same.
    """
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = new_figure(2.7 * columns + 0.5, 2.8 * rows + 0.9, layout="constrained")
    for number, (title, rows_of_bins) in enumerate(panels):
        axes = figure.add_subplot(rows, columns, number + 1)
        _draw(
            axes,
            title,
            100.0 * np.asarray(rows_of_bins, dtype=np.float64).reshape(-1, 3),
        )
    figure.suptitle(
        "Does a larger expected error mean a larger true one? Parts in ten bins of "
        "rising expected error",
        fontsize=12,
        color=INK,
    )
    figure.supxlabel("expected error, percentage points", fontsize=11)
    figure.supylabel("true error, percentage points", fontsize=11)
    return figure


def _draw(axes: Axes, title: str, rows: Array) -> None:
    expected, true, error = rows.T
    end = 1.08 * float(max(expected.max(), (true + error).max()))
    axes.plot((0.0, end), (0.0, end), color=REFERENCE, linewidth=0.9, linestyle=":")
    axes.errorbar(
        expected, true, 2.0 * error, fmt="o", markersize=4.0, color=BLUE, elinewidth=1.1
    )
    axes.set(xlim=(0.0, end), ylim=(0.0, end), aspect="equal")
    axes.set_title(title, fontsize=11, color=INK)
    open_axes(axes, "#e5e5e5", 0.6)
