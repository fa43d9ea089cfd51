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

"""The chart of speed against accuracy, on two logarithmic axes."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.plots.figures import INK, REFERENCE, new_figure, open_axes

from .labels import write_names
from .points import (
    KINDS,
    ChartPanel,
    ChartPoint,
    key_label,
    series_of,
    stair,
)

SUBTITLE = (
    "Time: of one core, median over parts. Error: root mean square over poses, pooled "
    "over the coefficients of restitution {}, against the limit of the "
    "drop simulation for ever more drops; noise of the reference removed."
)
"""Says what time and error are of, at which restitutions."""

WIDTH = 10.0
PANEL = 4.1
GAP = 0.68
HEAD = 1.65
FOOT = 0.62
"""Of the figure, of a panel with what is above it, of the latter alone, and of what is
above and below all panels, inches.
"""

LEFT = 0.085
RIGHT = 0.985
"""Ends of the axes, fractions of the width."""

NAMES = 110.0
LAST = 62.0
"""Room left of the first point and right of the last, points (1/72 inch)."""


def speed_accuracy_figure(
    panels: Sequence[ChartPanel], level: float, subtitle: str
) -> Figure:
    """Draw the error of each way to get the probabilities against its time.

    Parameters
    ----------
    panels : sequence of ChartPanel
        At least one; drawn one below the other.
    level : float
        Chance that a bar encloses the error, 0 to 1; it is written behind the subtitle.
    subtitle : str
        What is measured, at most two lines.

    Returns
    -------
    Figure
        Logarithmic axes, the same in all panels: time, and percentage points. Every
        point is named; a stair runs along those that no other beats in both.
    """
    height = HEAD + PANEL * len(panels) - GAP + FOOT
    figure = new_figure(WIDTH, height, dpi=160)
    figure.subplots_adjust(
        left=LEFT,
        right=RIGHT,
        top=1.0 - HEAD / height,
        bottom=FOOT / height,
        hspace=GAP / (PANEL - GAP),
    )
    points = [point for panel in panels for point in panel.points]
    _head(figure, f"{subtitle} Bars: {100.0 * level:g} % interval.", points)
    seconds = time_range(points, 72.0 * WIDTH * (RIGHT - LEFT), NAMES, LAST)
    for number, panel in enumerate(panels):
        axes = figure.add_subplot(len(panels), 1, number + 1)
        prepare(axes, seconds, error_range(points))
        axes.set_title(
            panel.title, loc="left", fontsize=11.5, fontweight="bold", color=INK
        )
        write_names(axes, panel.points, _draw(axes, panel.points))
    figure.axes[-1].set_xlabel("time of a part on one core", fontsize=11, color=INK)
    figure.supylabel(
        "error of a probability, percentage points",
        fontsize=11,
        color=INK,
        x=0.012,
        y=0.5 + 0.5 * (FOOT - HEAD) / height,
    )
    return figure


def _head(figure: Figure, subtitle: str, points: Sequence[ChartPoint]) -> None:
    """Title, subtitle and the key to the markers."""
    inch = 1.0 / figure.get_figheight()
    figure.text(
        0.015,
        1.0 - 0.12 * inch,
        "Speed against accuracy",
        fontsize=15,
        va="top",
        color=INK,
    )
    figure.text(
        0.015,
        1.0 - 0.44 * inch,
        subtitle,
        fontsize=9.5,
        va="top",
        color=INK,
        linespacing=1.35,
    )
    markers = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=KINDS[kind].marker,
            markersize=KINDS[kind].size,
            color=KINDS[kind].colour,
            label=key_label(kind, points),
        )
        for kind in KINDS
        if any(point.kind == kind for point in points)
    ]
    figure.legend(
        handles=markers,
        loc="upper left",
        bbox_to_anchor=(0.009, 1.0 - 0.86 * inch),
        ncols=math.ceil(len(markers) / 2),
        frameon=False,
        fontsize=9.5,
        labelcolor=INK,
        borderaxespad=0.0,
        borderpad=0.2,
        handletextpad=0.3,
        columnspacing=2.0,
    )


def _draw(axes: Axes, points: Sequence[ChartPoint]) -> tuple[Array, Array]:
    """Draw stair, lines, bars and markers; returns the corners of the stair."""
    bottom, top = axes.get_ylim()
    seconds, error = stair(points, axes.get_xlim()[1], top / 100.0)
    corners = seconds, 100.0 * error
    axes.plot(
        *corners,
        color=REFERENCE,
        linewidth=1.1,
        linestyle=(0, (4, 2)),
        zorder=2,
        label="nothing is both faster and more exact",
    )
    axes.legend(loc="lower left", frameon=False, fontsize=9.5, labelcolor=REFERENCE)
    for _, members in series_of(points):
        axes.plot(
            [point.seconds for point in members],
            [100.0 * point.error for point in members],
            color=KINDS[members[0].kind].colour,
            linewidth=0.9,
            alpha=0.7,
            zorder=2,
        )
    for name, kind in KINDS.items():
        mine = [point for point in points if point.kind == name]
        across = [point.seconds for point in mine]
        bars = np.array([(point.low, point.high) for point in mine]).reshape(-1, 2)
        axes.vlines(
            across,
            *np.maximum(100.0 * bars.T, bottom),
            color=kind.colour,
            linewidth=1.3,
            zorder=3,
        )
        axes.plot(
            across,
            [100.0 * point.error for point in mine],
            linestyle="none",
            marker=kind.marker,
            markersize=kind.size,
            color=kind.colour,
            zorder=4,
            markeredgecolor="white",
            markeredgewidth=0.6,
        )
    return corners


Range = tuple[float, float]

UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
STEPS = (1.0, 2.0, 5.0)
ABOVE = 1.25
BELOW = 1.45
"""Room over the highest bar and under the lowest point, as factors."""


def time_range(
    points: Sequence[ChartPoint], width: float, left_margin: float, right_margin: float
) -> Range:
    """Limits in seconds with room for labels on both sides of the points.

    Parameters
    ----------
    points : sequence of ChartPoint
    width : float
        Of the axes, in the unit of `left` and `right`.
    left, right : float
        Room between the axes' ends and the nearest point; together less than `width`.
    """
    ends = [math.log10(pick(point.seconds for point in points)) for pick in (min, max)]
    decades = max(ends[1] - ends[0], 1.0)
    per_width = decades / (width - left_margin - right_margin)
    return (
        float(10.0 ** (ends[0] - left_margin * per_width)),
        float(10.0 ** (ends[0] + decades + right_margin * per_width)),
    )


def error_range(points: Sequence[ChartPoint]) -> Range:
    """Limits in percentage points: all points and the upper ends of their bars lie
    within.
    """
    return (
        100.0 * min(point.error for point in points) / BELOW,
        100.0 * max(max(point.error, point.high) for point in points) * ABOVE,
    )


def prepare(axes: Axes, seconds: Range, error: Range) -> None:
    """Set scales, limits, ticks and grid."""
    axes.set(xscale="log", yscale="log", xlim=seconds, ylim=error)
    decades = range(
        math.ceil(math.log10(seconds[0])), math.floor(math.log10(seconds[1])) + 1
    )
    axes.xaxis.set_major_locator(FixedLocator([10.0**k for k in decades]))
    low, high = (math.floor(math.log10(value)) for value in error)
    axes.yaxis.set_major_locator(
        FixedLocator(
            [
                value
                for k in range(low, high + 1)
                for step in STEPS
                if error[0] <= (value := step * 10.0**k) <= error[1]
            ]
        )
    )
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: time_label(value)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.tick_params(labelsize=10, labelcolor=INK)
    open_axes(axes, "#e4e4e4", 0.7)


def time_label(seconds: float) -> str:
    """Such as "10 µs", "1 ms" or "100 s"."""
    unit, name = next(
        (scale for scale in UNITS if seconds >= scale[0] * (1.0 - 1e-9)), UNITS[-1]
    )
    return f"{round(seconds / unit, 6):,g} {name}".replace(",", " ")
