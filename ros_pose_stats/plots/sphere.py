"""The sphere of poses: contours of r(u) and R(u), and the basins of the poses (Fig. 1C)."""

from __future__ import annotations

from typing import Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from ..resting.pose_sphere import PoseSphere
from ..resting.splitting_graph import SplittingNode
from .discs import across_disc, mark, two_discs
from .study.cost import INK

Array = NDArray[np.float64]
Function = Literal["r", "R"]

CONTOURS = 12
COLORS = "cividis"
"""From dark to light as in the paper, also for the colour-blind and in grey."""

MOST_BORDERS = 40
"""Basins whose borders are drawn; the facets of a curve would be all borders."""


def sphere_figure(sphere: PoseSphere, function: Function = "R",
                  root: SplittingNode | None = None) -> Figure:
    """Draw r or R over all poses, with basins, stable poses, saddles and peaks (Fig. 1C).

    Parameters
    ----------
    sphere : PoseSphere
    function : {'r', 'R'}
    root : SplittingNode, optional
        Splitting graph of the part, for the saddles where the reachable set splits.

    Returns
    -------
    Figure
        Two discs, the hemispheres of the directions that point down, in equal-area
        projection, seen from outside; lighter is higher.
    """
    values = 1e3 * (sphere.r if function == "r" else sphere.R)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    span = max(high - low, 1e-12)
    figure, discs = two_discs(1, 0.0, 1.1)
    for hemisphere, axes in enumerate(discs[0]):
        # As an image: outlines of the bands would be thousands of corners.
        bands = np.clip(np.floor(CONTOURS * (values[hemisphere] - low) / span), 0, CONTOURS - 1)
        axes.imshow(bands, origin="lower", extent=(-1, 1, -1, 1), vmin=0,
                    vmax=CONTOURS - 1, cmap=COLORS, interpolation="nearest")
        _draw_borders(axes, sphere.pose[hemisphere])
    mark(discs[0], sphere, root)
    high_page = figure.get_figheight()
    bar = figure.colorbar(ScalarMappable(Normalize(low, high), ListedColormap(
        _colors(CONTOURS))), orientation="horizontal",
        cax=figure.add_axes((0.08, 0.98 / high_page, 0.84, 0.13 / high_page)))
    what = ("distance from the centre of mass to the surface" if function == "r"
            else "height of the centre of mass with u down")
    bar.set_label(f"{function}(u), {what}, mm", fontsize=9)
    bar.ax.tick_params(labelsize=8.5)
    figure.legend(handles=_legend(root is not None), loc="lower center", ncols=2, frameon=False,
                  fontsize=8.5, labelcolor=INK, handlelength=1.6)
    return figure


def _colors(count: int) -> Array:
    from matplotlib import colormaps

    return np.asarray(colormaps[COLORS](np.linspace(0.0, 1.0, count)))


def _draw_borders(axes: Axes, pose: NDArray[np.int64]) -> None:
    """Lines between basins, seen on dark and light alike."""
    there = np.unique(pose[pose >= 0])
    if len(there) > MOST_BORDERS:
        return
    across = across_disc(len(pose))
    for index in there[1:]:
        # Only where the basin is, which saves most of the time.
        rows, columns = (_around(np.flatnonzero((pose == index).any(axis=axis)))
                         for axis in (1, 0))
        near = pose[rows, columns]
        inside = np.where(near >= 0, (near == index).astype(float), np.nan)
        with rc_context({"path.effects": [withStroke(linewidth=2.2, foreground="#ffffff")]}):
            axes.contour(across[columns], across[rows], inside, [0.5], colors="#000000",
                         linewidths=0.9, zorder=2)


def _around(places: NDArray[np.int64]) -> slice:
    return slice(max(int(places[0]) - 1, 0), int(places[-1]) + 2)


def _legend(saddles: bool) -> list[Line2D]:
    found = [Line2D([], [], linestyle="none", marker="o", markersize=8, markerfacecolor="white",
                    markeredgecolor="black", label="stable pose (number)"),
             Line2D([], [], color="black", linewidth=0.9, label="border of a basin")]
    if saddles:
        found += [Line2D([], [], linestyle="none", marker="x", color="#d7301f",
                         markeredgewidth=1.5, label="saddle of the splitting graph"),
                  Line2D([], [], linestyle="none", marker="^", color="black", markersize=5,
                         label="maximum (balanced)")]
    return found
