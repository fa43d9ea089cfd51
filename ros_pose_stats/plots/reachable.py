"""Reachable sets: the poses that a part can still get to at some energy (Eq. 7, Figs. 3D-F)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ..resting.pose_sphere import PoseSphere
from ..resting.splitting_graph import SplittingNode
from .sphere import across_disc, mark, two_discs
from .style import INK, in_digits

APART = 0.03
"""Least difference of the energies that are drawn, as a fraction."""

BELOW = 1e-3
"""How far below a split the reachable set is drawn, as a fraction of its level."""

SHADES = ("#74a9cf", "#fee0b6", "#a1d99b", "#cbc9e2", "#fcbba1", "#f0f0f0")
"""Shades of components, different in lightness too as far as dark labels allow."""

UNREACHED = "#4d4d4d"


def reachable_figure(sphere: PoseSphere, root: SplittingNode,
                     energies: Sequence[float]) -> Figure:
    """Draw the poses that can still be reached at some energies (Eq. 7, Figs. 3D-F).

    `energies`: mechanical energy over weight, metres; a row of two discs each. Returns reachable
    poses light, a shade a component, the others dark; poses as numbers.
    """
    figure, discs = two_discs(len(energies), 0.25, 0.3)
    across = across_disc(sphere.R.shape[1])
    for row, energy in zip(discs, energies, strict=True):
        parts = components_at(root, energy, sphere.heights)
        component = np.full(len(sphere.downs), -1)
        for number, poses in enumerate(parts):
            component[list(poses)] = number
        for hemisphere, axes in enumerate(row):
            inside = sphere.pose[hemisphere] >= 0
            reached = inside & (sphere.R[hemisphere] <= energy)
            shade = np.where(reached, 1 + component[sphere.pose[hemisphere]] % len(SHADES), 0)
            axes.imshow(np.where(inside, shade, np.nan), origin="lower",
                        extent=(-1, 1, -1, 1), interpolation="nearest", vmin=0,
                        vmax=len(SHADES), cmap=ListedColormap([UNREACHED, *SHADES]))
            height = np.where(inside, sphere.R[hemisphere], np.nan)
            if np.nanmin(height) < energy < np.nanmax(height):
                axes.contour(across, across, height, [energy], colors="#000000", linewidths=0.9)
        mark(row, sphere, None)
        several = f"{len(parts)} separate sets" if len(parts) > 1 else "one connected set"
        row[0].annotate(f"energy / weight {in_digits(1e3 * energy, 4)} mm: {several}", (0.02, 1.0),
                        xycoords="axes fraction", fontsize=9.5, color=INK, va="bottom")
    figure.legend(handles=[Patch(facecolor=SHADES[0], edgecolor="black",
                                 label="can still be reached (a shade a set)"),
                           Patch(facecolor=UNREACHED, label="out of reach")],
                  loc="lower center", ncols=2, frameon=False, fontsize=8.5, labelcolor=INK,
                  handlelength=1.6)
    return figure


def components_at(root: SplittingNode, energy: float,
                  heights: NDArray[np.float64]) -> list[tuple[int, ...]]:
    """Poses of each connected component of the reachable set.

    `energy`: over weight, metres; `heights` (P,): of the poses, metres: what lies above the energy
    is out of reach.
    """
    found, waiting = [], [root]
    while waiting:
        node = waiting.pop()
        if node.level is None or node.level <= energy:
            if heights[list(node.poses)].min() <= energy:
                found.append(node.poses)
        else:
            waiting.extend(reversed(node.parts))
    return found


def telling_energies(root: SplittingNode, most: int = 3) -> list[float]:
    """Energies over weight, metres, just below the most important splits, from the top down.

    A split is important where even its less probable component is probable.
    """
    splits = {node.level: min(part.probability for part in node.parts)
              for node in root.walk() if node.level is not None}
    chosen: list[float] = []
    for level in sorted(splits, key=lambda level: -splits[level]):
        if len(chosen) < most and all(abs(level - one) > APART * one for one in chosen):
            chosen.append(level)
    return [level * (1.0 - BELOW) for level in sorted(chosen, reverse=True)]
