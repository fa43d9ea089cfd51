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

"""Curves of several methods in one figure: colours, dashes, and common names of equal
ones.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.plots.figures import INK, REFERENCE, new_figure, open_axes

Curves = Sequence[tuple[str, ArrayLike]]

EQUAL = 1e-9
"""Largest difference of two curves that are drawn as one line with both names."""

# For the colour-blind: four of Okabe and Ito's, eight of Tol's "muted", none near the
# dice's vermilion. Neighbours have different dashes too, so that nobody needs to see
# colours.
LINES: tuple[tuple[str, object], ...] = (
    ("#0072B2", "-"),
    ("#E69F00", (0, (6, 1.6))),
    ("#009E73", (0, (5, 1.4, 1, 1.4))),
    ("#CC79A7", (0, (1.2, 1.0))),
    ("#332288", "-"),
    ("#999933", (0, (6, 1.6))),
    ("#44AA99", (0, (5, 1.4, 1, 1.4))),
    ("#882255", (0, (1.2, 1.0))),
    ("#661100", "-"),
    ("#88CCEE", (0, (6, 1.6))),
    ("#117733", (0, (5, 1.4, 1, 1.4))),
    ("#DDCC77", (0, (1.2, 1.0))),
)


def merge_curves(curves: Curves) -> list[tuple[str, Array]]:
    """Join equal curves under a common label, since one would hide the other."""
    joined: list[tuple[str, Array]] = []
    for label, samples in curves:
        values = np.asarray(samples, dtype=np.float64)
        for row, (names, curve) in enumerate(joined):
            if np.abs(values - curve).max() < EQUAL:
                joined[row] = f"{names} = {label}", curve
                break
        else:
            joined.append((label, values))
    return joined


def row_of_panels(
    titles: Sequence[str], height: float, title: str, label: str, note: str
) -> tuple[Figure, Sequence[Axes]]:
    """A figure of panels side by side with one vertical axis; `note`: a line below."""
    figure = new_figure(6.2 * len(titles), height, layout="constrained")
    all_axes = figure.subplots(1, len(titles), sharey=True, squeeze=False)[0]
    for axes, name in zip(all_axes, titles, strict=True):
        axes.set_title(name, fontsize=11, color=INK)
        axes.yaxis.set_tick_params(labelleft=True)
        open_axes(axes, "#dddddd", 0.7)
    all_axes[0].set_ylabel(label)
    figure.suptitle(title, fontsize=12, color=INK)
    figure.supxlabel(note, fontsize=9, color=REFERENCE)
    return figure, all_axes


class Marker(NamedTuple):
    """How points with bars are drawn; lengths in points (1/72 inch)."""

    shape: str = "D"
    filling: str = "#ffffff"
    edge: str = INK
    size: float = 4.2
    thickness: float = 0.9
    bar: float = 1.0


def draw_bars(
    axes: Axes, x: Array, shares: Array, label: str, marker: Marker
) -> object:
    """Draw markers at shares (3, n), 0 to 1, and the bars of their intervals."""
    middle, low, high = 100.0 * shares
    # A bar must not be shorter than 0, not even by a rounding.
    lengths = np.maximum((middle - low, high - middle), 0.0)
    return axes.errorbar(
        x,
        middle,
        lengths,
        label=label,
        fmt=marker.shape,
        markersize=marker.size,
        markerfacecolor=marker.filling,
        markeredgecolor=marker.edge,
        markeredgewidth=marker.thickness,
        ecolor=marker.edge,
        elinewidth=marker.bar,
        zorder=3.0,
    )
