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

"""Charts of shares: of poses as bars, in a picture of all, and over kicks."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from ...base.text import name_poses, shortened
from ...core.planning.feeder_cell import FeederCell, KickPlan
from ...core.planning.feeding_plan import FeedingPlan
from ...core.records import Part, PoseStatistics
from ...core.resting.splitting_graph import SplittingNode, with_shares
from ...core.statistics import feeding, pose_groups
from . import poses, splitting
from .figures import (
    BLUE,
    INK,
    RASTER,
    REFERENCE,
    Picture,
    in_digits,
    new_figure,
    open_axes,
)

MOST = 8  # most poses with a bar, the most probable ones
BAR = 0.36  # thickness of a bar, as a fraction of the distance of two poses

SPARE_WIDTH = 0.08
"""Room for the numbers beside the longest bar, as a fraction of the axes' width."""

LEGEND: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),  # above all data
    "frameon": False,
    "fontsize": 9,
    "labelcolor": INK,
    "ncols": 2,
}

STYLES = (("#0072B2", ""), ("#c9dfee", "////"))
"""Colour and hatching, so that nobody needs to see colours."""


def shares_figure(
    statistics: Sequence[PoseStatistics], size: tuple[float, float] = (5.2, 4.6)
) -> Figure:
    """Draw the probability of each pose, or group of like poses, by one or two methods.

    Bars in percent with 90 % intervals, the most probable of the first method at the
    top.
    """
    figure = new_figure(*size, layout="constrained")
    axes = figure.add_subplot()
    drawn_groups = [
        group.indices for group in pose_groups.pose_groups(statistics[0])[:MOST]
    ]
    for row, (method_statistics, style) in enumerate(
        zip(statistics, STYLES, strict=False)
    ):
        _draw_bars(
            axes,
            method_statistics,
            drawn_groups,
            (row - 0.5 * (len(statistics) - 1)) * BAR,
            style,
        )
    axes.set_yticks(
        range(len(drawn_groups)),
        [shortened(name_poses(poses), 16) for poses in drawn_groups],
        fontsize=9.5,
    )
    axes.set_ylim(len(drawn_groups) - 0.4, -0.6)
    axes.set_xlim(0.0, (1.0 + SPARE_WIDTH) * axes.get_xlim()[1])
    axes.set_xlabel("probability, %; the lines are 90 % intervals", fontsize=9.5)
    axes.tick_params(axis="y", length=0)
    open_axes(axes, "#e5e5e5", 0.6, "x")
    axes.legend(**LEGEND)
    return figure


def _draw_bars(
    axes: Axes,
    statistics: PoseStatistics,
    drawn_groups: Sequence[tuple[int, ...]],
    offset: float,
    style: tuple[str, str],
) -> None:
    color, hatch = style
    groups = {group.indices: group for group in pose_groups.pose_groups(statistics)}
    rows = [row + offset for row in range(len(drawn_groups))]
    axes.barh(
        rows,
        [100.0 * groups[indices].probability for indices in drawn_groups],
        height=0.9 * BAR,
        color=color,
        hatch=hatch,
        edgecolor="#4f7f9f" if hatch else color,
        linewidth=0.5,
        label=poses.name_source(statistics),
    )
    for y, indices in zip(rows, drawn_groups, strict=True):
        group = groups[indices]
        low = group.probability_low
        high = group.probability_high
        if math.isfinite(low) and math.isfinite(high):
            axes.errorbar(
                50.0 * (low + high),
                y,
                xerr=50.0 * (high - low),
                color="#111111",
                elinewidth=1.1,
                capsize=2.2,
                zorder=3,
            )
        end = max(group.probability, high if math.isfinite(high) else 0.0)
        axes.annotate(
            f"{100.0 * group.probability:.1f} %",
            (100.0 * end, y),
            xytext=(4.0, 0.0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color=INK if not hatch else REFERENCE,
        )


LEAST = 4.2  # least width, and height, of the bars, inches
TITLE = 0.34  # height of a title, inches


def key_picture(
    part: Part, statistics: Sequence[PoseStatistics], root: SplittingNode
) -> Picture:
    """Draw a part's poses, their probabilities and the splitting graph as one picture.

    `statistics`: by one or two methods; the first is that of the pictures and the
    graph.
    """
    first = statistics[0]
    pose_row = poses.poses_figure(part, first)
    width, _ = pose_row.get_size_inches()
    graph = None
    graph_width = graph_height = 0.0
    if root.level is not None:
        graph = splitting.splitting_figure(with_shares(root, first.poses), first.poses)
        graph_width, graph_height = graph.get_size_inches()
    bars = shares_figure(
        statistics, (max(LEAST, width - graph_width), max(LEAST, graph_height))
    )
    panels = [_titled("Probability of each pose", bars)]
    if graph is not None:
        panels.append(
            _titled(
                "Splitting graph: the sets of poses as energy is lost, "
                f"{poses.name_source(first)}",
                graph,
            )
        )
    # Stacked upright, so that they stand side by side.
    upright = [panel.transpose(1, 0, 2) for panel in panels]
    return _stacked([_pixels(pose_row), _stacked(upright).transpose(1, 0, 2)])


def _titled(words: str, figure: Figure) -> Picture:
    """A figure under a title."""
    title = Figure(figsize=(figure.get_figwidth(), TITLE))
    title.text(0.5, 0.5, words, fontsize=10.5, color=INK, ha="center", va="center")
    return _stacked([_pixels(title), _pixels(figure)])


def _pixels(figure: Figure) -> Picture:
    """Pixels of a figure."""
    figure.set_dpi(RASTER)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    buffer = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
    return np.asarray(buffer)[:, :, :3].copy()


def _stacked(pictures: Sequence[Picture]) -> Picture:
    """Join pictures one below the other, the narrower ones centred on white."""
    width = max(picture.shape[1] for picture in pictures)
    spare = [width - picture.shape[1] for picture in pictures]
    return np.concatenate(
        [
            np.pad(
                picture,
                ((0, 0), (padding // 2, padding - padding // 2), (0, 0)),
                constant_values=255,
            )
            for picture, padding in zip(pictures, spare, strict=True)
        ]
    )


BEST = "#D55E00"
SIDES = ("left", "center", "right")
"""Of the numbers of the best kick, by the third where it lies."""

TICKS = (1.0, 2.0, 5.0)
ROOM = 1.1
"""Height of the axes over that of the data, so that the best kick's numbers fit in."""


def kick_figure(part_id: str, cell: FeederCell, plan: FeedingPlan) -> Figure:
    """Draw the parts a minute of a cell over the kick height; mark the best."""
    figure = new_figure(6.4, 3.9, layout="constrained")
    axes = figure.add_subplot()
    without_kick, *kicked = plan.options
    _draw_unkicked(axes, without_kick.per_minute, not plan.best.is_kicking)
    _draw_kicks(axes, kicked, plan.best)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.xaxis.set_major_formatter(lambda length, _: in_digits(length, 3))
    axes.xaxis.set_minor_formatter(NullFormatter())
    most = plan.best.per_minute.value
    axes.set_ylim(0.0, ROOM * max(axes.get_ylim()[1], most))
    axes.set_title(
        f"{shortened(part_id, 28)}: {cell.rate:g} parts dropped a minute, "
        f"{cell.cycle_seconds:g} s a kick\n{cell.describe_plate()}",
        fontsize=9.5,
        color=INK,
        loc="left",
        parse_math=False,
        pad=24.0,
    )
    axes.set_xlabel(
        "kick height, mm: how high it would throw the part without turning it",
        fontsize=9.5,
    )
    axes.set_ylabel("parts a minute", fontsize=9.5)
    open_axes(axes, "#e5e5e5", 0.6)
    axes.legend(**LEGEND)
    return figure


def _draw_unkicked(axes: Axes, per_minute: feeding.Bounded, is_best: bool) -> None:
    """A line, and a band for the interval."""
    best = f", the best: {per_minute.value:.3g} a minute" if is_best else ""
    axes.axhline(
        per_minute.value,
        color=BEST if is_best else REFERENCE,
        linewidth=1.2,
        linestyle=(0, (5, 2)),
        zorder=2,
        label=f"not kicked{best}",
    )
    axes.axhspan(
        per_minute.low,
        per_minute.high,
        color=REFERENCE,
        alpha=0.18,
        linewidth=0.0,
        zorder=1,
    )


def _draw_kicks(axes: Axes, options: Sequence[KickPlan], best: KickPlan) -> None:
    """Draw what kicks give, and mark the best if it is among them."""
    heights = np.array([1e3 * option.kick_height for option in options])
    value, low, high = np.array([option.per_minute for option in options]).T
    is_bounded = np.isfinite(low) & np.isfinite(high)
    errors = np.stack((value - low, high - value))[:, is_bounded].tolist()
    axes.plot(heights, value, color=BLUE, linewidth=1.4, zorder=3)
    axes.errorbar(
        heights[is_bounded],
        value[is_bounded],
        errors,
        fmt="o",
        color=BLUE,
        markersize=4.0,
        elinewidth=1.1,
        capsize=2.2,
        zorder=4,
        label="kicked",
    )
    axes.plot(
        heights[~is_bounded],
        value[~is_bounded],
        "x",
        color=BLUE,
        markersize=5.0,
        zorder=4,
        clip_on=False,
    )
    if not best.is_kicking:
        return
    index = options.index(best)
    axes.plot(
        heights[index],
        value[index],
        "o",
        markersize=11.0,
        markerfacecolor="none",
        markeredgecolor=BEST,
        markeredgewidth=1.6,
        zorder=5,
    )
    axes.annotate(
        f"{in_digits(heights[index], 3)} mm: {value[index]:.3g} a minute",
        (heights[index], high[index] if is_bounded[index] else value[index]),
        xytext=(0.0, 8.0),
        textcoords="offset points",
        ha=SIDES[3 * index // len(heights)],
        va="bottom",
        fontsize=9,
        color=BEST,
    )
