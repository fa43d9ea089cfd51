"""The two logarithmic axes of the chart."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from ..cost import INK
from .points import ChartPoint

Range = tuple[float, float]

UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
STEPS = (1.0, 2.0, 5.0)
ABOVE, BELOW = 1.25, 1.45
"""Room over the highest bar and under the lowest point, as factors."""


def time_range(points: Sequence[ChartPoint], width: float, left: float, right: float) -> Range:
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
    per_width = decades / (width - left - right)
    return (float(10.0 ** (ends[0] - left * per_width)),
            float(10.0 ** (ends[0] + decades + right * per_width)))


def error_range(points: Sequence[ChartPoint]) -> Range:
    """Limits in percentage points: all points and the upper ends of their bars lie within."""
    return (100.0 * min(point.error for point in points) / BELOW,
            100.0 * max(max(point.error, point.high) for point in points) * ABOVE)


def prepare(axes: Axes, seconds: Range, error: Range) -> None:
    """Set scales, limits, ticks and grid."""
    axes.set(xscale="log", yscale="log", xlim=seconds, ylim=error)
    decades = range(math.ceil(math.log10(seconds[0])), math.floor(math.log10(seconds[1])) + 1)
    axes.xaxis.set_major_locator(FixedLocator([10.0 ** k for k in decades]))
    low, high = (math.floor(math.log10(value)) for value in error)
    axes.yaxis.set_major_locator(FixedLocator(
        [value for k in range(low, high + 1) for step in STEPS
         if error[0] <= (value := step * 10.0 ** k) <= error[1]]))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: time_label(value)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.tick_params(labelsize=10, labelcolor=INK)
    axes.grid(which="major", color="#e4e4e4", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def time_label(seconds: float) -> str:
    """Such as "10 µs", "1 ms" or "100 s"."""
    unit, name = next((each for each in UNITS if seconds >= each[0] * (1.0 - 1e-9)), UNITS[-1])
    return f"{round(seconds / unit, 6):,g} {name}".replace(",", " ")
