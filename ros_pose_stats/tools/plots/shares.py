"""Charts of shares: of poses as bars, alone and in a picture of all; accepted parts over kicks."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ...base.text import name_poses, shortened
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
ABOVE: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
}  # clear of all data
BAR = 0.36  # thickness of a bar, as a fraction of the distance of two poses
ASIDE = 0.08  # room for the numbers beside the longest bar, as a fraction of the axes' width

STYLES = (("#0072B2", ""), ("#c9dfee", "////"))
"""Colour and hatching, so that nobody needs to see colours."""


def shares_figure(
    found: Sequence[PoseStatistics], size: tuple[float, float] = (5.2, 4.6)
) -> Figure:
    """Draw the probability of each pose, or group of like poses, by one or two methods.

    Bars in percent with 90 % intervals, the most probable of the first method at the top.
    """
    figure = new_figure(*size, layout="constrained")
    axes = figure.add_subplot()
    shown = [group.indices for group in pose_groups.pose_groups(found[0])[:MOST]]
    for place, (one, style) in enumerate(zip(found, STYLES, strict=False)):
        _draw_bars(axes, one, shown, (place - 0.5 * (len(found) - 1)) * BAR, style)
    axes.set_yticks(
        range(len(shown)),
        [shortened(name_poses(some), 16) for some in shown],
        fontsize=9.5,
    )
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlim(0.0, (1.0 + ASIDE) * axes.get_xlim()[1])
    axes.set_xlabel("probability, %; the lines are 90 % intervals", fontsize=9.5)
    axes.tick_params(axis="y", length=0)
    open_axes(axes, "#e5e5e5", 0.6, "x")
    axes.legend(frameon=False, fontsize=9, labelcolor=INK, ncols=2, **ABOVE)
    return figure


def _draw_bars(
    axes: Axes,
    found: PoseStatistics,
    shown: Sequence[tuple[int, ...]],
    aside: float,
    style: tuple[str, str],
) -> None:
    color, hatch = style
    groups = {group.indices: group for group in pose_groups.pose_groups(found)}
    places = [place + aside for place in range(len(shown))]
    axes.barh(
        places,
        [100.0 * groups[indices].probability for indices in shown],
        height=0.9 * BAR,
        color=color,
        hatch=hatch,
        edgecolor="#4f7f9f" if hatch else color,
        linewidth=0.5,
        label=poses.name_source(found),
    )
    for place, indices in zip(places, shown, strict=True):
        group = groups[indices]
        low = group.probability_low
        high = group.probability_high
        if math.isfinite(low) and math.isfinite(high):
            axes.errorbar(
                50.0 * (low + high),
                place,
                xerr=50.0 * (high - low),
                color="#111111",
                elinewidth=1.1,
                capsize=2.2,
                zorder=3,
            )
        end = max(group.probability, high if math.isfinite(high) else 0.0)
        axes.annotate(
            f"{100.0 * group.probability:.1f} %",
            (100.0 * end, place),
            xytext=(4.0, 0.0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color=INK if not hatch else REFERENCE,
        )


LEAST = 4.2  # least width, and height, of the bars, inches
TITLE = 0.34  # height of a title, inches


def key_picture(
    part: Part, found: Sequence[PoseStatistics], root: SplittingNode
) -> Picture:
    """Draw a part's poses, their probabilities and the splitting graph as one picture.

    `found`: by one or two methods; the first is that of the pictures and the graph.
    """
    first = found[0]
    above = poses.poses_figure(part, first)
    across, _ = above.get_size_inches()
    graph = (
        splitting.splitting_figure(with_shares(root, first.poses), first.poses)
        if root.level is not None
        else None
    )
    beside, high = graph.get_size_inches() if graph is not None else (0.0, 0.0)
    bars = shares_figure(found, (max(LEAST, across - beside), max(LEAST, high)))
    below = [_titled("Probability of each pose", bars)]
    if graph is not None:
        below.append(
            _titled(
                "Splitting graph: the sets of poses as energy is lost, "
                f"{poses.name_source(first)}",
                graph,
            )
        )
    beside_each_other = _stacked([one.transpose(1, 0, 2) for one in below]).transpose(
        1, 0, 2
    )
    return _stacked([_pixels(above), beside_each_other])


def _titled(words: str, figure: Figure) -> Picture:
    """A figure under a title."""
    title = Figure(figsize=(float(figure.get_figwidth()), TITLE))
    title.text(0.5, 0.5, words, fontsize=10.5, color=INK, ha="center", va="center")
    return _stacked([_pixels(title), _pixels(figure)])


def _pixels(figure: Figure) -> Picture:
    """Pixels of a figure."""
    figure.set_dpi(RASTER)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    shown = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
    return np.asarray(shown)[:, :, :3].copy()


def _stacked(pictures: Sequence[Picture]) -> Picture:
    """Join pictures one below the other, the narrower ones centred on white."""
    wide = max(one.shape[1] for one in pictures)
    spare = [wide - one.shape[1] for one in pictures]
    return np.concatenate(
        [
            np.pad(
                one,
                ((0, 0), (left // 2, left - left // 2), (0, 0)),
                constant_values=255,
            )
            for one, left in zip(pictures, spare, strict=True)
        ]
    )


BEST = "#D55E00"
SIDES = (
    "left",
    "center",
    "right",
)  # of the numbers of the best kick, by the third where it lies
TICKS = (1.0, 2.0, 5.0)
ROOM = 1.1  # height of the axes over that of what is drawn, so that the best one's numbers fit in


def kick_figure(
    part_id: str,
    rate: float,
    cycle_time: float,
    without: feeding.Bounded,
    kicks: Sequence[tuple[float, feeding.Bounded]],
) -> Figure:
    """Draw the parts a minute that a feeder gets over the kick height; the best is marked.

    `rate`: parts dropped a minute; `cycle_time`: seconds from kick to kick; `without`: what it
    gets without kicks; `kicks`: by height, metres.
    """
    figure = new_figure(6.4, 3.9, layout="constrained")
    axes = figure.add_subplot()
    axes.axhline(
        without.value,
        color=REFERENCE,
        linewidth=1.2,
        linestyle=(0, (5, 2)),
        zorder=2,
        label="not kicked",
    )
    axes.axhspan(
        without.low, without.high, color=REFERENCE, alpha=0.18, linewidth=0.0, zorder=1
    )
    height = np.array([1e3 * kick for kick, _ in kicks])
    value, low, high = np.array([per_minute for _, per_minute in kicks]).T
    known = np.isfinite(low) & np.isfinite(high)
    ends = np.stack((value - low, high - value))[:, known].tolist()
    axes.plot(height, value, color=BLUE, linewidth=1.4, zorder=3)
    axes.errorbar(
        height[known],
        value[known],
        ends,
        fmt="o",
        color=BLUE,
        markersize=4.0,
        elinewidth=1.1,
        capsize=2.2,
        zorder=4,
        label="kicked",
    )
    axes.plot(
        height[~known],
        value[~known],
        "x",
        color=BLUE,
        markersize=5.0,
        zorder=4,
        clip_on=False,
    )
    best = int(value.argmax())
    axes.plot(
        height[best],
        value[best],
        "o",
        markersize=11.0,
        markerfacecolor="none",
        markeredgecolor=BEST,
        markeredgewidth=1.6,
        zorder=5,
    )
    axes.annotate(
        f"{in_digits(height[best], 3)} mm: {value[best]:.3g} a minute",
        (height[best], high[best] if known[best] else value[best]),
        xytext=(0.0, 8.0),
        textcoords="offset points",
        ha=SIDES[3 * best // len(kicks)],
        va="bottom",
        fontsize=9,
        color=BEST,
    )
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda at, _: in_digits(at, 3)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(0.0, ROOM * max(axes.get_ylim()[1], value[best]))
    axes.set_title(
        f"{shortened(part_id, 28)}: {rate:g} parts dropped a minute, {cycle_time:g} s "
        "a kick",
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
    axes.legend(frameon=False, fontsize=9, labelcolor=INK, ncols=2, **ABOVE)
    return figure
