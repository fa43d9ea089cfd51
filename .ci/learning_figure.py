"""How a node learns a plate: probabilities over the number of parts that a camera has seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.records import PoseStatistics
from ros_pose_stats.tools.plots.figures import BLUE, INK, new_figure, open_axes

Array = NDArray[np.float64]

MOST = 6
"""Most poses with axes of their own, those that are most probable on the plate."""

COLUMNS = 3
TICKS = (1.0, 2.0, 5.0)
PREDICTED = "#D55E00"
LEAST_SPAN = 0.05
"""Of the axes of a probability, so that small errors look small."""


def learning_figure(results: Sequence[PoseStatistics], truth: PoseStatistics) -> Figure:
    """Draw what was predicted, what is true and what was learned, pose by pose.

    `results`: of one part in the order in which they came: the first is the prediction, those with
    `observed` above 0 were learned; `truth`: of the same part on the plate itself. Returns axes of
    equal span for each pose; the band is the 90 % interval of what was learned. Raises
    RequestError if nothing was learned.
    """
    learned = [one for one in results if one.observed]
    if not learned:
        raise RequestError(
            "results with the method observed",
            "none",
            "wait until the camera has seen some parts",
        )
    shown = [pose.index for pose in truth.poses[:MOST]]
    tables = {index: np.array([_row(one, index) for one in learned]) for index in shown}
    known = {
        index: (_row(results[0], index)[0], _row(truth, index)[0]) for index in shown
    }
    rows = -(-len(shown) // COLUMNS)
    figure = new_figure(9.0, 0.7 + 2.5 * rows, layout="constrained")
    grid = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False)
    seen = np.array([one.observed for one in learned])
    ranges = {index: _drawn_range(tables[index], known[index]) for index in shown}
    span = max(LEAST_SPAN, *(1.08 * (high - low) for low, high in ranges.values()))
    for axes, index in zip(grid.flat, shown, strict=False):
        _draw_pose(axes, seen, tables[index], *known[index])
        middle = 0.5 * sum(ranges[index])
        bottom = max(0.0, middle - 0.5 * span)
        axes.set_ylim(100.0 * bottom, 100.0 * (bottom + span))
        axes.set_title(f"pose {index}", fontsize=9.5, color=INK, loc="left")
    for axes in grid.flat[len(shown) :]:
        axes.set_axis_off()
    for axes in grid.flat[max(0, len(shown) - COLUMNS) : len(shown)]:
        axes.tick_params(labelbottom=True)
    figure.supxlabel("parts seen", fontsize=9.5)
    figure.supylabel("probability, %", fontsize=9.5)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper left",
        ncols=len(labels),
        frameon=False,
        fontsize=9,
        labelcolor=INK,
    )
    return figure


def _row(one: PoseStatistics, index: int) -> tuple[float, float, float]:
    """Probability of a pose and its interval."""
    pose = next(pose for pose in one.poses if pose.index == index)
    return pose.probability, pose.probability_low, pose.probability_high


def _drawn_range(learned: Array, known: tuple[float, float]) -> tuple[float, float]:
    """Least and greatest probability that is drawn of a pose."""
    return float(min(np.nanmin(learned), *known)), float(
        max(np.nanmax(learned), *known)
    )


def _draw_pose(
    axes: Axes, seen: Array, learned: Array, predicted: float, true: float
) -> None:
    value, low, high = 100.0 * learned.T
    axes.plot(
        seen,
        value,
        color=BLUE,
        linewidth=1.5,
        marker=".",
        markersize=3.5,
        label="learned from what the camera saw",
    )
    axes.fill_between(
        seen,
        low,
        high,
        color=BLUE,
        alpha=0.18,
        linewidth=0.0,
        label="its 90 % interval",
    )
    axes.axhline(
        100.0 * predicted,
        color=PREDICTED,
        linewidth=1.3,
        dashes=(5, 2),
        label="predicted by the model",
    )
    axes.axhline(
        100.0 * true, color="#111111", linewidth=1.2, label="true on this plate"
    )
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda at, _: f"{at:.0f}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=8.5, colors=INK)
    open_axes(axes, "#e5e5e5", 0.6)
