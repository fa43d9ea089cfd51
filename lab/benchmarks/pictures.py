"""The figures of the page on speed, and the sections that they belong to.

They show the time of a part or of a drop against the number of vertices, on logarithmic axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from ros_pose_stats.tools.plots.figures import INK, REFERENCE, apart, new_figure
from study.output import save_figure

from .growth import STAGES, family
from .results import Section

Array = NDArray[np.float64]

# Okabe and Ito's colours for the colour-blind, each with its own marker, so that nobody needs to
# see colours.
STYLES = (
    ("#000000", "-", "o"),
    ("#0072B2", "--", "s"),
    ("#D55E00", "-", "^"),
    ("#009E73", "-.", "D"),
    ("#CC79A7", "--", "v"),
    ("#E69F00", "-", "P"),
)
LABEL_GAP = 0.052  # of the axes' height


class Picture(NamedTuple):
    """A figure of a section.

    Attributes
    ----------
    file : Path
        Relative to the folder of documents.
    says : str
        Description of the figure, for those who do not see it.
    figure : callable
    """

    file: Path
    says: str
    figure: Callable[[Section], Figure]


def draw(section: Section, docs: Path) -> None:
    """Draw a section's figure, if it has one, into a folder of documents."""
    if section.name in PICTURES:
        picture = PICTURES[section.name]
        save_figure(picture.figure(section), docs / picture.file)


def _stages(growth: Section) -> Figure:
    """Stages of the first family of bodies in the rows."""
    first = family(growth.rows[0])
    cells = [row.cells for row in growth.rows if family(row) == first]
    stages = [(stage, [float(each[stage]) for each in cells]) for stage in STAGES]
    return cost_figure([int(each["vertices"]) for each in cells], stages, growth.title)


def _families(growth: Section) -> Figure:
    """Every family of bodies, time of a drop."""
    names = dict.fromkeys(map(family, growth.rows))
    cells = {
        name: [row.cells for row in growth.rows if family(row) == name]
        for name in names
    }
    return drop_cost_figure(
        [
            (
                name,
                [float(each["vertices"]) for each in cells[name]],
                [float(each["µs a drop"]) for each in cells[name]],
            )
            for name in names
        ],
        growth.title,
    )


def cost_figure(
    vertices: ArrayLike, stages: Sequence[tuple[str, ArrayLike]], title: str = ""
) -> Figure:
    """Draw the time of each stage against the number of vertices.

    Parameters
    ----------
    vertices : (k,) array
        Rising.
    stages : sequence of (label, (k,) array)
        Milliseconds; at most as many as there are styles.
    title : str

    Returns
    -------
    Figure
        Log-log, a label at the end of each line, and a line of slope 1 to compare with.
    """
    count = np.asarray(vertices, dtype=np.float64)
    times = [(label, np.asarray(values, dtype=np.float64)) for label, values in stages]
    figure, axes = _log_log("time, ms", title)
    for (_, values), (colour, dash, marker) in zip(times, STYLES, strict=False):
        axes.plot(
            count,
            values,
            color=colour,
            linestyle=dash,
            marker=marker,
            markersize=4.5,
            linewidth=1.6,
        )
    low = min(float(values.min()) for _, values in times) / 1.6
    high = max(float(values.max()) for _, values in times) * 1.6
    axes.set_xlim(count[0] / 1.25, count[-1] * 1.25)
    axes.set_ylim(low, high)
    _slope_one(axes, count[-1] / 60.0, count[-1] / 1.5, 1.7 * low)
    _label_ends(axes, times)
    return figure


def _log_log(quantity: str, title: str) -> tuple[Figure, Axes]:
    """A figure with logarithmic axes over the number of vertices."""
    figure = new_figure(8.0, 5.2, layout="constrained")
    axes = figure.add_subplot()
    axes.set(
        xscale="log", yscale="log", xlabel="hull vertices", ylabel=quantity, title=title
    )
    axes.xaxis.set_major_formatter(_plain)
    axes.yaxis.set_major_formatter(_plain)
    axes.grid(which="major", color="#dddddd", linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _plain(value: float, _: float) -> str:
    """Tick label without an exponent, thousands apart."""
    return f"{value:,g}".replace(",", " ")


def _slope_one(axes: Axes, begin: float, end: float, low: float) -> None:
    """A thin line proportional to the number of vertices, below the data."""
    ends = np.array((begin, end))
    axes.plot(ends, low * ends / begin, color=REFERENCE, linewidth=1.0, linestyle=":")
    axes.annotate(
        "slope 1",
        (begin, low),
        xytext=(-5, 0),
        textcoords="offset points",
        ha="right",
        va="center",
        color=REFERENCE,
        fontsize=9,
    )


def _label_ends(axes: Axes, times: Sequence[tuple[str, Array]]) -> None:
    """Name each line at its right end, pushed apart where they would overlap."""
    low, high = np.log(axes.get_ylim())
    ends = np.array([(np.log(values[-1]) - low) / (high - low) for _, values in times])
    heights = apart(ends, LABEL_GAP)
    for number, (label, _) in enumerate(times):
        axes.annotate(
            label,
            (1.0, ends[number]),
            xycoords="axes fraction",
            xytext=(1.03, heights[number]),
            textcoords="axes fraction",
            color=INK,
            fontsize=10,
            va="center",
            arrowprops={
                "arrowstyle": "-",
                "color": STYLES[number][0],
                "linewidth": 1.2,
                "shrinkA": 0.0,
                "shrinkB": 0.0,
            },
        )


def drop_cost_figure(
    families: Sequence[tuple[str, ArrayLike, ArrayLike]], title: str = ""
) -> Figure:
    """Draw the time of a drop against the number of vertices.

    Parameters
    ----------
    families : sequence of (label, (k,) array, (k,) array)
        Vertices, rising, and microseconds; at most as many as there are styles.
    title : str

    Returns
    -------
    Figure
        Log-log, a legend, and a line of slope 1 to compare with.
    """
    curves = [
        (label, np.asarray(count, dtype=np.float64), np.asarray(cost, dtype=np.float64))
        for label, count, cost in families
    ]
    figure, axes = _log_log("time of a drop, µs", title)
    for (label, count, cost), (colour, dash, marker) in zip(
        curves, STYLES, strict=False
    ):
        axes.plot(
            count,
            cost,
            color=colour,
            linestyle=dash,
            marker=marker,
            markersize=4.5,
            linewidth=1.6,
            label=label,
        )
    axes.legend(loc="upper left", frameon=False, fontsize=10, labelcolor=INK)
    everything = np.concatenate([cost for _, _, cost in curves])
    axes.set_ylim(float(everything.min()) / 2.0, float(everything.max()) * 2.0)
    most = max(float(count.max()) for _, count, _ in curves)
    _slope_one(axes, most / 12.0, most, 0.75 * float(everything.min()))
    return figure


FIGURES = Path("figures")
PICTURES = {
    "growth": Picture(
        FIGURES / "cost_against_vertices.png",
        "Time of each stage against hull vertices, log-log",
        _stages,
    ),
    "drop_growth": Picture(
        FIGURES / "drops_against_vertices.png",
        "Time of a drop against hull vertices, log-log",
        _families,
    ),
}
