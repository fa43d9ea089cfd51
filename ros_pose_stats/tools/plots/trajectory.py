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

"""One drop over time, as a figure and in motion: energy over the levels."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, NullLocator

from ...base.text import shortened
from ...core.mesh import decimation, vectors
from ...core.records import Array, Part, Trajectory
from ...core.resting.splitting_graph import SplittingNode, levels_above, poses_within
from ...core.simulation.frames import DropFrames, first_still
from .figures import INK, REFERENCE, Picture, new_figure, open_axes, separate
from .rendering import View, rendered

ENERGY = "#0072B2"
HEIGHT = "#D55E00"
EVENTS = (
    ("impact", "|", "#222222"),
    ("stop", "s", "#009E73"),
    ("lift-off", "^", "#CC79A7"),
)
SPLIT = ("split", "v", "#222222")
"""Row of the splits of the reachable set, at which the energy passes a level."""

ROW = 0.3  # height of the row of a kind of event, inches
LONGEST = 8  # characters that name the poses of a component
MOST_LEVELS = 8  # that are drawn: there is no room for more beside the curve

SETTLED = 2e-3
"""Energy over that at rest, in weight times radius, below which no motion can be
seen."""


def trajectory_figure(trajectory: Trajectory, root: SplittingNode) -> Figure:
    """Draw a drop: energy over weight, height of the centre of mass, events.

    Dashed lines are the levels at which the set that holds the final pose splits off,
    the eight that part most. From release to where nothing moves that can be seen;
    below, a row for each kind of event, with how many of all there are.
    """
    end = trajectory.times[first_still(trajectory, SETTLED)]
    figure = new_figure(6.4, 4.6, layout="constrained")
    rows = _rows(trajectory, root, end)
    events_height = 0.25 + ROW * len(rows)
    energy, events = figure.subplots(
        2, 1, sharex=True, height_ratios=(3.6, events_height)
    )
    draw_energy(energy, trajectory, root, end)
    energy.plot(
        trajectory.times,
        1e3 * trajectory.heights,
        color=HEIGHT,
        linewidth=1.2,
        linestyle=(0, (4, 1.2)),
        label="height of the centre of mass",
        zorder=2,
    )
    energy.legend(frameon=False, fontsize=9, labelcolor=INK, loc="upper right")
    _draw_events(events, rows, end)
    events.set_xlabel("time since release, s", fontsize=10)
    outcome = (
        f"comes to rest in pose {trajectory.pose}"
        if trajectory.pose >= 0
        else "not settled"
    )
    figure.suptitle(
        f"{shortened(trajectory.part_id, 30)}: {trajectory.impacts} impacts, {outcome}",
        fontsize=11,
        color=INK,
        parse_math=False,
    )
    return figure


def draw_energy(
    axes: Axes, trajectory: Trajectory, root: SplittingNode, end: float
) -> None:
    """Draw the energy over weight of a drop and the levels on its way."""
    energy = 1e3 * energy_heights(trajectory)
    axes.plot(
        trajectory.times,
        energy,
        color=ENERGY,
        linewidth=1.8,
        label="energy / weight",
        zorder=3,
    )
    levels = telling_levels(levels_above(root, trajectory.pose), len(root.poses))
    bottom = min(energy[-1], 1e3 * trajectory.heights.min())
    axes.set(yscale="log", xlim=(0.0, end), ylim=(0.88 * bottom, 1.25 * energy[0]))
    axes.set_ylabel("mm above the plate", fontsize=10)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    open_axes(axes, "#e5e5e5", 0.6)
    low, high = np.log(axes.get_ylim())
    level_heights = np.array(
        [(np.log(1e3 * level) - low) / (high - low) for level, _ in levels]
    )
    label_heights = separate(level_heights, 0.052, 0.0, 1.0)
    for number, (level, poses) in enumerate(levels):
        axes.axhline(
            1e3 * level, color=REFERENCE, linewidth=0.8, linestyle="--", zorder=1
        )
        axes.annotate(
            f"below: {component_name(poses)}",
            (1.0, level_heights[number]),
            xycoords="axes fraction",
            xytext=(1.03, label_heights[number]),
            textcoords="axes fraction",
            fontsize=8.5,
            color=INK,
            va="center",
            arrowprops={
                "arrowstyle": "-",
                "color": REFERENCE,
                "linewidth": 0.7,
                "relpos": (0.0, 0.5),
                "shrinkA": 0.0,
                "shrinkB": 0.0,
            },
        )


def telling_levels(
    levels: Sequence[tuple[float, tuple[int, ...]]], poses: int
) -> list[tuple[float, tuple[int, ...]]]:
    """The levels below which the most poses get out of reach, and always the last."""
    sizes = [poses, *(len(reachable) for _, reachable in levels)]
    lost = [sizes[k] - sizes[k + 1] for k in range(len(levels))]
    first = sorted(range(len(levels) - 1), key=lambda k: -lost[k])[: MOST_LEVELS - 1]
    return [levels[k] for k in sorted(first)] + list(levels[-1:])


def energy_heights(trajectory: Trajectory) -> Array:
    """Mechanical energy over weight (n,), metres; the part is released at rest."""
    return np.asarray(
        trajectory.energies * (trajectory.heights[0] / trajectory.energies[0])
    )


def component_name(poses: Sequence[int]) -> str:
    """The poses of a component in few words."""
    if len(poses) == 1:
        return f"pose {poses[0]} only"
    numbers = " ".join(map(str, poses))
    return f"poses {numbers}" if len(numbers) <= LONGEST else f"{len(poses)} poses"


def _rows(
    trajectory: Trajectory, root: SplittingNode, end: float
) -> list[tuple[str, str, str, Array]]:
    """Name, marker, colour and times of each kind of event before a time."""
    energy = energy_heights(trajectory)
    # Energy never rises, so that the first sample below a level is where it was passed.
    passed = [
        trajectory.times[np.argmax(energy < level)]
        for level, _ in levels_above(root, trajectory.pose)
        if energy[-1] < level
    ]
    rows = [
        (
            *kind,
            np.array(
                [event.time for event in trajectory.events if event.kind == kind[0]]
            ),
        )
        for kind in EVENTS
    ]
    rows.append((*SPLIT, np.array(passed)))
    return [row for row in rows if (row[-1] <= end).any()]


def _draw_events(
    axes: Axes, rows: Sequence[tuple[str, str, str, Array]], end: float
) -> None:
    for row, (_, marker, color, times) in enumerate(rows):
        axes.plot(
            times,
            np.full(len(times), -row),
            linestyle="none",
            marker=marker,
            color=color,
            markersize=7.0 if marker == "|" else 5.0,
            clip_on=True,
        )
        count = int((times <= end).sum())
        label = f"{count} of {len(times)}" if count < len(times) else f"{count}"
        axes.annotate(
            label,
            (1.03, -row),
            xycoords=("axes fraction", "data"),
            fontsize=8.5,
            color=INK,
            va="center",
            annotation_clip=False,
        )
    axes.set_yticks(
        [-row for row in range(len(rows))], [name for name, *_ in rows], fontsize=9
    )
    axes.set_ylim(-len(rows) + 0.4, 0.6)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", color="#e5e5e5", linewidth=0.6)


SIZE = (6.8, 3.4)  # width and height of the animation, inches
DPI = 100

SCENE = (0.0, 0.0, 0.44, 0.86)
"""Place of the part in the picture: left, bottom, width, height, as fractions."""

WIDE = 3.3  # width of the scene, in radii
FOLLOWED = 1.7
"""Height of the centre of mass above which the view rises with it, in radii."""


def animation_frames(
    part: Part, trajectory: Trajectory, frames: DropFrames, root: SplittingNode
) -> Iterator[Picture]:
    """Draw a drop, frame by frame, as pixels (height, width, 3).

    The part on the left, in a view that rises with it; on the right its energy over
    weight, with the levels of the splitting graph, and what can still be reached.
    """
    figure, axes, reach, clock = _stage(trajectory, frames, root)
    canvas = FigureCanvasAgg(figure)
    (point,) = axes.plot(
        [],
        [],
        marker="o",
        markersize=8,
        color="#D55E00",
        zorder=6,
        markeredgecolor="#000000",
        animated=True,
        clip_on=False,
    )
    # matplotlib's canvas has no annotations
    canvas.draw()  # type: ignore[no-untyped-call]
    background = canvas.copy_from_bbox(figure.bbox)  # type: ignore[no-untyped-call]
    levels = levels_above(root, trajectory.pose)
    triangles = decimation.visible_triangles(part) - part.center_of_mass
    rotations = vectors.rotation_matrices(frames.orientations)
    scale = energy_heights(trajectory)[0] / trajectory.energies[0]
    for k, time in enumerate(frames.times):
        canvas.restore_region(background)  # type: ignore[no-untyped-call]
        energy = frames.energies[k] * scale
        point.set_data([min(time, frames.end)], [1e3 * energy])
        poses = poses_within(levels, energy, root.poses)
        name = component_name(poses) if len(poses) < len(root.poses) else "every pose"
        reach.set_text(f"within reach: {name}")
        clock.set_text("at rest" if k >= frames.rest_frame else f"{time:.2f} s")
        for artist in (point, reach, clock):
            figure.draw_artist(artist)
        buffer = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
        picture = np.asarray(buffer)[:, :, :3].copy()
        position = np.array([0.0, 0.0, frames.heights[k]])
        _draw_part(
            picture,
            triangles @ rotations[k].T + position,
            position[2],
            trajectory.radius,
        )
        yield picture


def _draw_part(
    picture: Picture, triangles: Array, height: float, radius: float
) -> None:
    """Draw the part into its place; `height`: of its centre of mass, metres."""
    page_width, page_height = (int(inches * DPI) for inches in SIZE)
    left, bottom, width, tall = SCENE
    column = int(left * page_width)
    row = page_height - int((bottom + tall) * page_height)
    pixels = (2 * int(0.5 * width * page_width), 2 * int(0.5 * tall * page_height))
    rise = max(0.0, height - FOLLOWED * radius)
    view = View(
        np.array([0.0, 0.0, 1.02 * radius + rise]),
        WIDE * radius,
        pixels,
        plate=1.15 * radius,
    )
    window = np.s_[row : row + pixels[1], column : column + pixels[0]]
    picture[window] = rendered(triangles, view)


def _stage(
    trajectory: Trajectory, frames: DropFrames, root: SplittingNode
) -> tuple[Figure, Axes, Text, Text]:
    """The figure of all frames: with axes of the energy, the set in reach, the time."""
    figure = new_figure(*SIZE, dpi=DPI)
    axes = figure.add_axes((0.55, 0.15, 0.245, 0.69))
    draw_energy(axes, trajectory, root, frames.end)
    axes.set_xlim(frames.begin, frames.end + 0.02 * (frames.end - frames.begin))
    axes.set_xlabel("time since release, s", fontsize=9.5)
    axes.set_ylabel("energy / weight, mm", fontsize=9.5)
    axes.tick_params(labelsize=8.5)
    words = axes.annotate(
        "",
        (0.0, 1.05),
        xycoords="axes fraction",
        fontsize=10.5,
        color=INK,
        animated=True,
    )
    outcome = f"pose {trajectory.pose}" if trajectory.pose >= 0 else "no pose"
    pace = "in true time"
    if frames.slowing > 1.0:
        pace = f"slowed {frames.slowing:g} times"
    elif frames.slowing < 1.0:
        pace = f"{1.0 / frames.slowing:g} times as fast"
    figure.text(
        0.02,
        0.945,
        f"{shortened(trajectory.part_id, 22)}: {trajectory.scene}",
        fontsize=9.5,
        color=INK,
        parse_math=False,
    )
    figure.text(0.02, 0.88, f"into {outcome}, {pace}", fontsize=9.5, color=REFERENCE)
    clock = figure.text(
        0.985, 0.945, "", fontsize=10.5, color=REFERENCE, ha="right", animated=True
    )
    return figure, axes, words, clock
