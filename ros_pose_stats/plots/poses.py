"""The stable poses of a part side by side, each resting on the plate."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..mesh.decimation import visible_triangles
from ..mesh.vectors import rotation_matrices
from ..records import Part, PoseStatistics, StablePose
from .rendering import View, rendered, view_axes
from .style import INK, REFERENCE, in_digits, new_figure

Array = NDArray[np.float64]

COLUMNS = 4
MOST = 8
"""Most poses that are drawn, the most probable ones."""

PIXELS = 400
"""Pixels across a picture."""

HEAD = 0.62
"""Height of the text of a picture, inches."""

TITLE = 0.65
"""Height of the two lines above all pictures, inches."""

WIDTH, PLATE = 3.0, 1.05
"""Width of a picture, and half the side of the plate, in radii."""


def poses_figure(part: Part, found: PoseStatistics) -> Figure:
    """Draw the most probable poses of a part.

    Returns all poses at one scale, most probable first, at most eight.
    """
    shown = found.poses[:MOST]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    pictures = pose_pictures(part, shown, found.radius)
    shape = pictures[0].shape[0] / pictures[0].shape[1]
    width, high = 2.9, 2.9 * shape + HEAD
    figure = new_figure(max(width * columns, 6.2), high * rows + TITLE)
    across, up = figure.get_size_inches()
    spare = 0.5 * (across - width * columns)
    for place, (pose, picture) in enumerate(zip(shown, pictures, strict=True)):
        row, column = divmod(place, columns)
        left, bottom = spare + width * column, up - TITLE - high * (row + 1) + 0.3
        axes = figure.add_axes((left / across, bottom / up, width / across,
                                (high - HEAD) / up))
        axes.imshow(picture, interpolation="antialiased")
        axes.set_axis_off()
        axes.set_title(pose_title(pose), fontsize=10.5, color=INK, pad=3.0)
        axes.annotate(f"centre of mass {in_digits(1e3 * pose.height, 3)} mm up", (0.5, 0.0),
                      xycoords="axes fraction", ha="center", va="top", fontsize=9, color=REFERENCE)
    figure.suptitle(_heading(found, len(shown)), fontsize=12, color=INK, y=1.0 - 0.1 / up)
    return figure


def pose_pictures(part: Part, poses: Sequence[StablePose], radius: float,
                  pixels: int = PIXELS) -> list[NDArray[np.uint8]]:
    """Pictures of a part in some of its poses, on the plate and at one scale.

    `radius`: of the part, metres. Returns high enough for the highest of the poses.
    """
    triangles = visible_triangles(part) - part.center_of_mass
    laid = [placed(triangles, pose) for pose in poses]
    view = resting_view(laid, radius, pixels)
    return [rendered(one, view) for one in laid]


def resting_view(laid: Sequence[Array], radius: float, pixels: int) -> View:
    """View of the plate that is high enough for the part in each of the poses."""
    sample = View(np.zeros(3), WIDTH * radius, (2, 2), plate=PLATE * radius)
    lean, about = np.radians((sample.elevation, sample.azimuth))
    _, up, _ = view_axes(sample)
    front = PLATE * radius * (abs(np.sin(about)) + abs(np.cos(about))) * np.sin(lean)
    above, below = max([front, *(float((one @ up).max()) for one in laid)]), front
    margin = 0.05 * radius
    high = 2 * round(0.5 * pixels * (above + below + 2.0 * margin) / sample.width)
    middle = np.array([0.0, 0.0, 0.5 * (above - below) / np.cos(lean)])
    return sample._replace(center=middle, pixels=(pixels, high))


def placed(triangles: Array, pose: StablePose) -> Array:
    """Turn triangles (t, 3, 3) about the centre of mass into a pose, in the plate frame."""
    rotation = rotation_matrices(pose.orientation[None, :])[0]
    return np.asarray(triangles @ rotation.T + np.array([0.0, 0.0, pose.height]))


def pose_title(pose: StablePose) -> str:
    """Number and probability, with its standard error where one is known."""
    text = f"pose {pose.index}: {100.0 * pose.probability:.1f} %"
    if math.isfinite(pose.standard_error):
        text += f" ± {100.0 * pose.standard_error:.1f}"
    return text


def _heading(found: PoseStatistics, shown: int) -> str:
    how = (f"{found.drops} drops, ± standard error" if found.drops
           else f"estimated ({found.method})")
    rest = len(found.poses) - shown
    more = f"; {rest} less probable poses not shown" if rest else ""
    return f"{found.part_id}: {found.scene}\nresting probabilities, {how}{more}"
