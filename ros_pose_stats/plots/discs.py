"""Two discs for the sphere of poses, the part's axes at their rims, and what is marked on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from ..resting.pose_sphere import PoseSphere, on_map
from ..resting.splitting_graph import SplittingNode
from .study.cost import INK, REFERENCE

Array = NDArray[np.float64]

DISC = 2.3
"""Inches from disc to disc."""

SIDES = ("around the part's -z", "around the part's +z")

MOST_MARKS = 40
"""Saddles or peaks that are marked; more would cover the map."""

MOST_LABELS = 60
"""Poses that are numbered, the lowest ones."""

FEW, NAMED = 20, 3
"""Up to so many poses, a label names three; of more it names the first one."""

NEAR, FAR = 0.13, 0.3
"""Poses nearer than this on the page share a label, in radii of the disc: of few and of many."""


def two_discs(rows: int, above: float, below: float) -> tuple[Figure, list[list[Axes]]]:
    """Rows of two discs, with inches left above each row and below all."""
    high = rows * (DISC + above) + below
    figure = Figure(figsize=(2.0 * DISC, high))
    FigureCanvasAgg(figure)
    found = []
    for row in range(rows):
        bottom = high - (row + 1) * (DISC + above)
        found.append([figure.add_axes((0.5 * hemisphere, bottom / high, 0.5, DISC / high))
                      for hemisphere in range(2)])
        for hemisphere, axes in enumerate(found[-1]):
            axes.set(xlim=(-1.35, 1.35), ylim=(-1.42, 1.28), aspect="equal")
            axes.set_axis_off()
            axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor=INK, linewidth=1.0,
                                  zorder=3))
            _name_rim(axes, hemisphere)
    return figure, found


def _name_rim(axes: Axes, hemisphere: int) -> None:
    """Axes of the part at the rim, and the one in the middle below."""
    right = "-x" if hemisphere == 0 else "+x"
    left = "+x" if hemisphere == 0 else "-x"
    for text, x, y in ((right, 1.13, 0.0), (left, -1.13, 0.0), ("+y", 0.0, 1.11)):
        axes.text(x, y, text.replace("-", "\N{MINUS SIGN}"), fontsize=8, color=REFERENCE,
                  ha="left" if x > 0 else "right" if x < 0 else "center",
                  va="bottom" if y > 0 else "center")
    axes.text(0.0, -1.15, SIDES[hemisphere].replace("-", "\N{MINUS SIGN}"), fontsize=8.5,
              color=REFERENCE, ha="center", va="top")


def across_disc(pixels: int) -> Array:
    """Middles (n,) of the pixels across a disc of radius 1."""
    return np.asarray((2.0 * np.arange(pixels) + 1.0) / pixels - 1.0)


def mark(row: Sequence[Axes], sphere: PoseSphere, root: SplittingNode | None) -> None:
    """Peaks, saddles of the splitting graph, and the poses with their numbers."""
    if root is not None:
        saddles = [node.saddle for node in root.walk() if node.saddle is not None]
        for kind, points in (("^", sphere.peaks), ("x", np.array(saddles).reshape(-1, 3))):
            if len(points) <= MOST_MARKS:
                _scatter(row, points, kind)
    named = NAMED if len(sphere.downs) <= FEW else 1
    for hemisphere, place, numbers in _labels(sphere.downs):
        text = ",".join(map(str, numbers[:named])) + ("..." if len(numbers) > named else "")
        row[hemisphere].annotate(
            text, place, ha="center", va="center", fontsize=8, color="#000000", zorder=5,
            bbox={"boxstyle": "round,pad=0.22", "facecolor": "#ffffff", "edgecolor": "#000000",
                  "linewidth": 0.8})


def _scatter(row: Sequence[Axes], directions: Array, kind: str) -> None:
    hemisphere, place = on_map(directions)
    for number, axes in enumerate(row):
        there = place[hemisphere == number]
        if kind == "x":
            axes.plot(*there.T, linestyle="none", marker="x", markersize=6.0, color="#ffffff",
                      markeredgewidth=3.0, zorder=4)
        axes.plot(*there.T, linestyle="none", marker=kind, markersize=6.0 if kind == "x" else 4.5,
                  color="#d7301f" if kind == "x" else "#000000", markeredgecolor=None
                  if kind == "x" else "#ffffff", markeredgewidth=1.5 if kind == "x" else 0.5,
                  zorder=4)


def _labels(downs: Array) -> Iterator[tuple[int, tuple[float, float], list[int]]]:
    """Places of the poses on the page; those that would cover each other share one."""
    hemisphere, place = on_map(downs)
    reach = NEAR if len(downs) <= FEW else FAR
    left = list(range(min(len(downs), MOST_LABELS)))
    while left:
        first = left[0]
        near = [one for one in left if hemisphere[one] == hemisphere[first]
                and float(np.linalg.norm(place[one] - place[first])) < reach]
        yield int(hemisphere[first]), (float(place[first, 0]), float(place[first, 1])), near
        left = [one for one in left if one not in near]
