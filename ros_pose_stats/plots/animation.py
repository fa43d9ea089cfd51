"""A drop in motion: the part falling, bouncing and settling, beside its energy over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

from ..mesh.decimation import visible_triangles
from ..mesh.vectors import rotation_matrices
from ..records import Part, Trajectory
from ..resting.splitting_graph import SplittingNode, levels_above, poses_within
from ..simulation.frames import DropFrames
from .rendering import View, rendered
from .style import INK, REFERENCE, new_figure
from .trajectory import component_name, draw_energy, energy_heights

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

SIZE, DPI = (6.8, 3.4), 100
"""Width and height of the animation, inches, and dots an inch."""

SCENE = (0.0, 0.0, 0.44, 0.86)
"""Place of the part in the picture: left, bottom, width, height, as fractions."""

WIDE = 3.3
"""Width of the scene, in radii."""

FOLLOWED = 1.7
"""Height of the centre of mass above which the view rises with it, in radii."""


class Stage(NamedTuple):
    """The parts of the figure that stay the same in every frame."""

    figure: Figure
    axes: Axes  # axes of the energy
    words: Text  # text about the poses that can still be reached
    clock: Text
    box: tuple[int, int, int, int]  # left, top, width and height of the scene, pixels


def animation_frames(part: Part, trajectory: Trajectory, frames: DropFrames,
                     root: SplittingNode) -> Iterator[Picture]:
    """Draw a drop, frame by frame.

    `root`: splitting graph of the part. Yields (height, width, 3) uint8: the part on the left, in
    a view that rises with it; on the right its energy over weight, with the levels of the
    splitting graph, and what can still be reached.
    """
    stage = _stage(trajectory, frames, root)
    canvas = FigureCanvasAgg(stage.figure)
    (point,) = stage.axes.plot([], [], marker="o", markersize=8, color="#D55E00",
                               markeredgecolor="#000000", zorder=6, animated=True,
                               clip_on=False)
    # matplotlib's canvas has no annotations
    canvas.draw()  # type: ignore[no-untyped-call]
    background = canvas.copy_from_bbox(stage.figure.bbox)  # type: ignore[no-untyped-call]
    levels = levels_above(root, trajectory.pose)
    triangles = visible_triangles(part) - part.center_of_mass
    turns = rotation_matrices(frames.orientations)
    energy = energy_heights(trajectory)
    for k, time in enumerate(frames.times):
        canvas.restore_region(background)  # type: ignore[no-untyped-call]
        now = float(frames.energies[k]) * (energy[0] / trajectory.energies[0])
        point.set_data([min(time, frames.end)], [1e3 * now])
        reached = poses_within(levels, now, root.poses)
        stage.words.set_text(_reached(reached, root.poses))
        still = k >= frames.rest
        stage.clock.set_text("at rest" if still else f"{time:.2f} s")
        for artist in (point, stage.words, stage.clock):
            stage.figure.draw_artist(artist)
        drawn = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
        picture = np.asarray(drawn)[:, :, :3].copy()
        left, top, wide, high = stage.box
        placed = triangles @ turns[k].T + np.array([0.0, 0.0, frames.heights[k]])
        picture[top:top + high, left:left + wide] = rendered(
            placed, _view(trajectory.radius, float(frames.heights[k]), (wide, high)))
        yield picture


def _reached(poses: Sequence[int], every: Sequence[int]) -> str:
    if len(poses) == len(every):
        return "within reach: every pose"
    return f"within reach: {component_name(poses)}"


def _stage(trajectory: Trajectory, frames: DropFrames, root: SplittingNode) -> Stage:
    figure = new_figure(*SIZE, dpi=DPI)
    axes = figure.add_axes((0.55, 0.15, 0.245, 0.69))
    draw_energy(axes, trajectory, root, frames.end)
    axes.set_xlim(frames.begin, frames.end + 0.02 * (frames.end - frames.begin))
    axes.set_xlabel("time since release, s", fontsize=9.5)
    axes.set_ylabel("energy / weight, mm", fontsize=9.5)
    axes.tick_params(labelsize=8.5)
    words = axes.annotate("", (0.0, 1.05), xycoords="axes fraction", fontsize=10.5, color=INK,
                          animated=True)
    where = f"pose {trajectory.pose}" if trajectory.pose >= 0 else "no pose"
    figure.text(0.02, 0.945, f"{trajectory.part_id}: {trajectory.scene}", fontsize=9.5, color=INK)
    figure.text(0.02, 0.88, f"into {where}, {_pace(frames.slower)}", fontsize=9.5,
                color=REFERENCE)
    clock = figure.text(0.985, 0.945, "", fontsize=10.5, color=REFERENCE, ha="right",
                        animated=True)
    wide, high = (int(inches * DPI) for inches in SIZE)
    left, bottom, across, up = SCENE
    box = (int(left * wide), high - int((bottom + up) * high), 2 * int(0.5 * across * wide),
           2 * int(0.5 * up * high))
    return Stage(figure, axes, words, clock, box)


def _pace(slower: float) -> str:
    """The speed of the film, in words."""
    if slower == 1.0:
        return "in true time"
    return f"slowed {slower:g} times" if slower > 1.0 else f"{1.0 / slower:g} times as fast"


def _view(radius: float, height: float, pixels: tuple[int, int]) -> View:
    """View of the plate; it rises with a part that is high up."""
    above = max(0.0, height - FOLLOWED * radius)
    return View(np.array([0.0, 0.0, 1.02 * radius + above]), WIDE * radius, pixels,
                plate=1.15 * radius)
