"""The stable poses of a part side by side, each resting on the plate."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from ..geometry.decimation import decimated_hull
from ..geometry.orientation import rotation_matrices
from ..records import Part, PoseStatistics, StablePose

Array = NDArray[np.float64]

COLUMNS = 4
MOST = 8
"""Poses drawn, the most probable ones."""

FINEST = 4000
"""Triangles; a larger mesh is drawn as its decimated hull."""

LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
BLUE = np.array([0.50, 0.70, 0.95])
VIEW = (22.0, -62.0)
"""Elevation and azimuth, degrees."""


def poses_figure(part: Part, found: PoseStatistics) -> Figure:
    """Draw the most probable poses of a part.

    Parameters
    ----------
    part : Part
    found : PoseStatistics
        Of that part.

    Returns
    -------
    Figure
    """
    shown = found.poses[:MOST]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    triangles = _triangles(part)
    figure = Figure(figsize=(max(3.0 * columns, 5.0), 2.9 * rows + 0.6))
    FigureCanvasAgg(figure)
    for place, pose in enumerate(shown):
        axes = figure.add_subplot(rows, columns, place + 1, projection="3d")
        _draw(axes, triangles, pose, found.radius)
        axes.set_title(_title(pose), fontsize=10, y=0.92)
    figure.suptitle(_heading(found, len(shown)), fontsize=12)
    figure.subplots_adjust(left=0.0, right=1.0, bottom=0.01, wspace=0.0, hspace=0.08,
                           top=1.0 - 0.55 / figure.get_figheight())
    return figure


def _heading(found: PoseStatistics, shown: int) -> str:
    how = f"{found.drops} drops" if found.drops else f"estimated ({found.method})"
    rest = len(found.poses) - shown
    more = f"; {rest} less probable poses not shown" if rest else ""
    return f"{found.part_id}: resting probabilities, {how}{more}"


def _title(pose: StablePose) -> str:
    text = f"pose {pose.index}: {100.0 * pose.probability:.1f} %"
    if math.isfinite(pose.standard_error):
        text += f" ± {100.0 * pose.standard_error:.1f}"
    return text + f"\ncentre of mass {1e3 * pose.height:.3g} mm up"


def _towards_viewer() -> Array:
    up, round_about = np.radians(VIEW)
    return np.array([np.cos(up) * np.cos(round_about), np.cos(up) * np.sin(round_about),
                     np.sin(up)])


def _triangles(part: Part) -> Array:
    """Corners (t, 3, 3) in the part frame, about the centre of mass, metres."""
    if len(part.surface_triangles) <= FINEST:
        corners = part.surface_vertices[part.surface_triangles]
    else:
        corners = decimated_hull(part, FINEST)
    return np.asarray(corners - part.center_of_mass)


def _draw(axes: Axes3D, triangles: Array, pose: StablePose, radius: float) -> None:
    rotation = rotation_matrices(pose.orientation[None, :])[0]
    placed = triangles @ rotation.T + np.array([0.0, 0.0, pose.height])
    normals = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    seen = normals @ _towards_viewer() > 1e-9 * lengths  # what faces away only gets in the way
    placed, normals = placed[seen], normals[seen] / lengths[seen, None]
    shade = 0.42 + 0.58 * (0.5 + 0.5 * normals @ LIGHT) ** 1.5
    colors = shade[:, None] * BLUE
    size = 1.15 * radius
    plate = size * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    axes.add_collection3d(Poly3DCollection([plate], facecolors=[(0.93, 0.93, 0.91)],
                                           edgecolors=[(0.75, 0.75, 0.72)], linewidths=0.6,
                                           zorder=0))
    axes.add_collection3d(Poly3DCollection(placed, facecolors=colors, edgecolors=colors,
                                           linewidths=0.2, zorder=1))
    axes.set_xlim(-size, size)
    axes.set_ylim(-size, size)
    axes.set_zlim(-0.15 * size, 1.85 * size)
    axes.set_box_aspect((1, 1, 1), zoom=1.35)
    axes.set_proj_type("ortho")
    axes.computed_zorder = False
    axes.view_init(*VIEW)
    axes.set_axis_off()
