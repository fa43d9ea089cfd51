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

"""How a node learns a plate: probabilities over the parts that a camera saw."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.records import Array, PoseStatistics
from ros_pose_stats.tools.plots.figures import BLUE, INK, new_figure, open_axes

MOST_POSES = 6
"""Poses with axes of their own, those that are most probable on the plate."""

COLUMNS = 3
TICKS = (1.0, 2.0, 5.0)
PREDICTED = "#D55E00"
LEAST_SPAN = 0.05
"""Of the axes of a probability, so that small errors look small."""


def learning_figure(results: Sequence[PoseStatistics], truth: PoseStatistics) -> Figure:
    """Draw what was predicted, what is true and what was learned, pose by pose.

    `results`: of one part in the order in which they came: the first is the prediction,
    those with `counted_parts` above 0 were learned; `truth`: of the same part on the
    plate itself. Returns axes of equal span for each pose; the band is the 90 %
    interval of what was learned. Raises RequestError if nothing was learned.
    """
    learned = [statistics for statistics in results if statistics.counted_parts]
    if not learned:
        raise RequestError(
            "results with the method observed",
            "none",
            "wait until the camera has seen some parts",
        )
    poses = [pose.index for pose in truth.poses[:MOST_POSES]]
    curves = {pose: _learning_curve(pose, learned, results[0], truth) for pose in poses}
    rows = -(-len(poses) // COLUMNS)
    figure = new_figure(9.0, 0.7 + 2.5 * rows, layout="constrained")
    grid = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False)
    parts_seen = np.array([statistics.counted_parts for statistics in learned])
    ranges = [curve.range() for curve in curves.values()]
    span = max(LEAST_SPAN, *(1.08 * (high - low) for low, high in ranges))
    for axes, pose in zip(grid.flat, poses, strict=False):
        _draw_curve(axes, parts_seen, curves[pose])
        middle = 0.5 * sum(curves[pose].range())
        bottom = max(0.0, middle - 0.5 * span)
        axes.set_ylim(100.0 * bottom, 100.0 * (bottom + span))
        axes.set_title(f"pose {pose}", fontsize=9.5, color=INK, loc="left")
    for axes in grid.flat[len(poses) :]:
        axes.set_axis_off()
    for axes in grid.flat[max(0, len(poses) - COLUMNS) : len(poses)]:
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


class LearningCurve(NamedTuple):
    """Probabilities of a pose."""

    learned: Array  # (n, 3); after so many parts, and its interval
    predicted: float
    true: float

    def range(self) -> tuple[float, float]:
        """Least and greatest probability that is drawn."""
        return (
            float(min(np.nanmin(self.learned), self.predicted, self.true)),
            float(max(np.nanmax(self.learned), self.predicted, self.true)),
        )


def _learning_curve(
    pose: int,
    learned: Sequence[PoseStatistics],
    prediction: PoseStatistics,
    truth: PoseStatistics,
) -> LearningCurve:
    return LearningCurve(
        np.array([_interval(statistics, pose) for statistics in learned]),
        _interval(prediction, pose)[0],
        _interval(truth, pose)[0],
    )


def _interval(statistics: PoseStatistics, index: int) -> tuple[float, float, float]:
    """Probability of a pose and its interval."""
    pose = statistics.by_index[index]
    return pose.probability, pose.probability_low, pose.probability_high


def _draw_curve(axes: Axes, parts_seen: Array, curve: LearningCurve) -> None:
    probability, low, high = 100.0 * curve.learned.T
    axes.plot(
        parts_seen,
        probability,
        color=BLUE,
        linewidth=1.5,
        marker=".",
        markersize=3.5,
        label="learned from what the camera saw",
    )
    axes.fill_between(
        parts_seen,
        low,
        high,
        color=BLUE,
        alpha=0.18,
        linewidth=0.0,
        label="its 90 % interval",
    )
    axes.axhline(
        100.0 * curve.predicted,
        color=PREDICTED,
        linewidth=1.3,
        dashes=(5, 2),
        label="predicted by the model",
    )
    axes.axhline(
        100.0 * curve.true, color="#111111", linewidth=1.2, label="true on this plate"
    )
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0f}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=8.5, colors=INK)
    open_axes(axes, "#e5e5e5", 0.6)
