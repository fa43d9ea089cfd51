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

"""Probabilities against simulated ones, one dot a stable pose: the paper's Figs. 2 and
4.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import ArrayLike

from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.plots.figures import BLUE, INK, REFERENCE, new_figure

COLUMNS = 3


class Panel(NamedTuple):
    """One estimator.

    Attributes
    ----------
    title : str
        Its name.
    estimated, simulated : (N,) array
        Probabilities, 0 to 1; one value of each a stable pose.
    error : float
        Eq. 4, as a fraction of 1.
    largest : float
        Largest deviation of a prediction from the simulation, as a fraction of 1.
    curve : (x, y) or None
        Two (k,) arrays, 0 to 1: a function fitted to the dots, Eq. 6.
    """

    title: str
    estimated: ArrayLike
    simulated: ArrayLike
    error: float
    largest: float
    curve: tuple[ArrayLike, ArrayLike] | None = None


def estimators_figure(panels: Sequence[Panel], drops: int) -> Figure:
    """Draw what each estimator predicts against what was simulated.

    Parameters
    ----------
    panels : sequence of Panel
        At least one; three in a row.
    drops : int
        Of each part in the simulation.

    Returns
    -------
    Figure
        The same square axes in every panel.
    """
    dots = [
        (np.asarray(panel.estimated), np.asarray(panel.simulated)) for panel in panels
    ]
    end = axis_end(*(values for pair in dots for values in pair))
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = new_figure(
        max(3.1 * columns + 0.6, 6.0),
        3.5 * rows + 0.9,
        dpi=160,
        layout=ConstrainedLayoutEngine(w_pad=0.1),
    )
    for number, (panel, (x, y)) in enumerate(zip(panels, dots, strict=True)):
        axes = figure.add_subplot(rows, columns, number + 1)
        draw_dots(axes, x, y, end, size=2.0)
        _name(axes, panel)
        if panel.curve is not None:
            _draw_curve(axes, np.asarray(panel.curve, dtype=np.float64), end)
        axes.tick_params(
            labelbottom=number + columns >= len(panels), labelleft=number % columns == 0
        )
    figure.suptitle(
        "Predicted against simulated probabilities, one dot a stable pose", fontsize=13
    )
    figure.supxlabel("probability predicted by the estimator", fontsize=12)
    figure.supylabel(f"simulated probability, n = {drops}", fontsize=12)
    return figure


def _name(axes: Axes, panel: Panel) -> None:
    """Name and error above the panel, the largest deviation in smaller print."""
    axes.set_title(
        f"{panel.title}, error {100.0 * panel.error:.1f} %",
        fontsize=12,
        color=INK,
        pad=19.0,
    )
    small = f"largest deviation {100.0 * panel.largest:.1f} %"
    if panel.curve is not None:
        small += ", curve: fitted"
    axes.annotate(
        small,
        (0.5, 1.0),
        xycoords="axes fraction",
        xytext=(0.0, 6.0),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=9.5,
        color=REFERENCE,
    )


def _draw_curve(axes: Axes, curve: Array, end: float) -> None:
    """A solid line, as far as the axes go."""
    x, y = curve[:, curve[0] <= end]
    axes.plot(x, y, color="#000000", linewidth=1.8, zorder=3)


def noise_figure(
    redrawn: ArrayLike, simulated: ArrayLike, drops: int, noise: float
) -> Figure:
    """Draw simulated probabilities against what the same number of drops makes of them.

    Parameters
    ----------
    drawn : (N,) array
        Each simulated probability redrawn: a binomial count of `drops`, divided by
        them.
    simulated : (N,) array
        Probabilities, 0 to 1.
    drops : int
        Of each part; n of the paper.
    noise : float
        Root mean square of the noise, Eq. 3, as a fraction of 1.

    Returns
    -------
    Figure
        One dot a stable pose, square axes, the diagonal; the noise in the title,
        percent.
    """
    x = np.asarray(simulated)
    y = np.asarray(redrawn)
    figure = new_figure(6.0, 6.2, dpi=160, layout="constrained")
    axes = figure.add_subplot()
    draw_dots(axes, x, y, axis_end(x, y), size=3.0)
    axes.set_xlabel("simulated probability")
    axes.set_ylabel(f"redrawn from it, n = {drops}")
    axes.set_title(
        "What a perfect estimator would look like:\n"
        f"the noise of {drops} drops is {100.0 * noise:.1f} %",
        fontsize=12,
    )
    return figure


FAINTEST = 0.12
STRONGEST = 0.8
"""Opacity of a dot among many and among few."""

OPAQUE_IN_ALL = 2000.0
"""Sum of the opacities of all dots, from which the opacity of one follows, within its
bounds.
"""


def axis_end(*rows: Array) -> float:
    """Largest value, rounded up to the next tenth; at least 0.1."""
    largest = max(float(values.max()) for values in rows)
    return max(math.ceil(10.0 * largest - 1e-9), 1) / 10.0


def draw_dots(axes: Axes, x: Array, y: Array, end: float, size: float) -> None:
    """Draw the dots and the diagonal on square axes from 0 to `end`.

    Parameters
    ----------
    axes : Axes
    across, up : (N,) array
        Probabilities.
    end : float
        Of both axes.
    size : float
        Diameter of a dot, points (1/72 inch).
    """
    opacity = min(max(OPAQUE_IN_ALL / len(x), FAINTEST), STRONGEST)
    axes.plot(
        x,
        y,
        color=BLUE,
        linestyle="none",
        marker="o",
        markersize=size,
        markeredgewidth=0.0,
        alpha=opacity,
        clip_on=False,
        rasterized=True,
        zorder=1,
    )
    axes.plot(
        (0.0, end),
        (0.0, end),
        color=INK,
        linewidth=0.8,
        linestyle=(0, (5, 3)),
        zorder=2,
    )
    ticks = np.arange(0.0, end + 1e-9, 0.1 if end < 0.45 else 0.2)
    axes.set(
        xlim=(0.0, end), ylim=(0.0, end), aspect="equal", xticks=ticks, yticks=ticks
    )
    axes.xaxis.set_major_formatter("{x:.1f}")
    axes.yaxis.set_major_formatter("{x:.1f}")
    axes.spines[["top", "right"]].set_visible(False)
