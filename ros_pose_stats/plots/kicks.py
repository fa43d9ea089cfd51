"""Accepted parts a minute over the height of the kick, with the kick that feeds fastest."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..planning.kick_sweep import KickSweep
from ..text import listed, shortened
from .style import BLUE, INK, REFERENCE, in_digits, new_figure, open_axes

BEST = "#D55E00"
TICKS = (1.0, 2.0, 5.0)
ROOM = 1.1
"""Height of the axes over that of what is drawn, so that the best one's numbers fit in."""


def kick_figure(sweep: KickSweep) -> Figure:
    """Draw a sweep.

    Returns accepted parts a minute with 90 % intervals over the kick height in millimetres, the
    best kick marked, and beside it what dropping afresh brings.
    """
    figure = new_figure(6.4, 3.9, layout="constrained")
    axes = figure.add_subplot()
    _draw_afresh(axes, sweep)
    height = np.array([1e3 * one.kick_height for one in sweep.kicks])
    value, low, high = np.array([one.feeding.per_minute for one in sweep.kicks]).T
    known = np.isfinite(low) & np.isfinite(high)
    axes.plot(height, value, color=BLUE, linewidth=1.4, zorder=3)
    axes.errorbar(height[known], value[known], [(value - low)[known], (high - value)[known]],
                  fmt="o", color=BLUE, markersize=4.0, elinewidth=1.1, capsize=2.2, zorder=4,
                  label="kicked where they lie wrong")
    axes.plot(height[~known], value[~known], "x", color=BLUE, markersize=5.0, zorder=4,
              clip_on=False)
    _mark_best(axes, sweep)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda at, _: in_digits(at, 3)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(0.0, ROOM * max(axes.get_ylim()[1], sweep.best.feeding.per_minute.value))
    axes.set_title(_title(sweep), fontsize=9.5, color=INK, loc="left")
    axes.set_xlabel("kick height, mm: how high it would throw the part without turning it",
                    fontsize=9.5)
    axes.set_ylabel("accepted parts a minute", fontsize=9.5)
    open_axes(axes, "#e5e5e5", 0.6)
    axes.legend(frameon=False, fontsize=9, labelcolor=INK, loc="lower right")
    return figure


def _title(sweep: KickSweep) -> str:
    flips, one = sweep.best.flips, len(sweep.wanted) == 1
    return (f"{shortened(flips.part_id, 30)}: pose{'' if one else 's'} "
            f"{shortened(listed(sweep.wanted), 30)} wanted, {sweep.rate:g} dropped a minute, "
            f"{sweep.cycle_time:g} s a kick")


def _draw_afresh(axes: Axes, sweep: KickSweep) -> None:
    """A line for dropping afresh, which knows no kick, and its interval as a band."""
    value, low, high = sweep.afresh.per_minute
    axes.axhline(value, color=REFERENCE, linewidth=1.2, linestyle=(0, (5, 2)), zorder=2,
                 label="dropped again")
    if np.isfinite(low) and np.isfinite(high):
        axes.axhspan(low, high, color=REFERENCE, alpha=0.18, linewidth=0.0, zorder=1)


def _mark_best(axes: Axes, sweep: KickSweep) -> None:
    """A ring around the best kick, and its numbers above."""
    best = sweep.best
    at, (value, _, high) = 1e3 * best.kick_height, best.feeding.per_minute
    above = high if np.isfinite(high) else value
    axes.plot([at], [value], "o", markersize=11.0, markerfacecolor="none", markeredgecolor=BEST,
              markeredgewidth=1.6, zorder=5)
    axes.annotate(f"{in_digits(at, 3)} mm: {value:.3g} a minute", (at, above), xytext=(0.0, 8.0),
                  textcoords="offset points", ha="center", va="bottom", fontsize=9, color=BEST)
