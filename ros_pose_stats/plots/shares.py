"""Probabilities of the poses as bars with their intervals, an estimate beside a simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..records import PoseStatistics
from .style import INK, REFERENCE, new_figure, open_axes

MOST = 8
"""Most poses with a bar, the most probable ones."""

BAR = 0.36
"""Thickness of a bar, as a fraction of the distance of two poses."""

ASIDE = 0.08
"""Room for the numbers beside the longest bar, as a fraction of the axes' width."""

STYLES = (("#0072B2", ""), ("#c9dfee", "////"))
"""Colour and hatching, so that nobody needs to see colours."""


def shares_figure(found: Sequence[PoseStatistics], size: tuple[float, float] = (5.2, 4.6)
                  ) -> Figure:
    """Draw the probability of each pose by one or two methods.

    `found`: one or two of the same part; the poses are in the order of the first. Returns bars in
    percent with 90 % intervals, the most probable pose at the top.
    """
    figure = new_figure(*size, layout="constrained")
    axes = figure.add_subplot()
    shown = [pose.index for pose in found[0].poses[:MOST]]
    for place, (one, style) in enumerate(zip(found, STYLES, strict=False)):
        _draw_bars(axes, one, shown, (place - 0.5 * (len(found) - 1)) * BAR, style)
    axes.set_yticks(range(len(shown)), [f"pose {index}" for index in shown], fontsize=9.5)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlim(0.0, (1.0 + ASIDE) * axes.get_xlim()[1])
    axes.set_xlabel("probability, %; the lines are 90 % intervals", fontsize=9.5)
    axes.tick_params(axis="y", length=0)
    open_axes(axes, "#e5e5e5", 0.6, "x")
    axes.legend(frameon=False, fontsize=9, labelcolor=INK, loc="lower right")
    return figure


def name_method(found: PoseStatistics) -> str:
    """Where probabilities come from, in two words."""
    return f"{found.drops} drops" if found.drops else f"estimate ({found.method})"


def _draw_bars(axes: Axes, found: PoseStatistics, shown: Sequence[int], aside: float,
               style: tuple[str, str]) -> None:
    color, hatch = style
    poses = {pose.index: pose for pose in found.poses}
    places = [place + aside for place in range(len(shown))]
    axes.barh(places, [100.0 * poses[index].probability for index in shown], height=0.9 * BAR,
              color=color, hatch=hatch, edgecolor="#4f7f9f" if hatch else color, linewidth=0.5,
              label=name_method(found))
    for place, index in zip(places, shown, strict=True):
        low, high = poses[index].probability_low, poses[index].probability_high
        if math.isfinite(low) and math.isfinite(high):
            axes.errorbar(50.0 * (low + high), place, xerr=50.0 * (high - low), color="#111111",
                          elinewidth=1.1, capsize=2.2, zorder=3)
        end = max(poses[index].probability, high if math.isfinite(high) else 0.0)
        axes.annotate(f"{100.0 * poses[index].probability:.1f} %", (100.0 * end, place),
                      xytext=(4.0, 0.0), textcoords="offset points", va="center", fontsize=7.5,
                      color=INK if not hatch else REFERENCE)
