"""One drop over time, as a figure and in motion: energy on the levels of the splitting graph."""

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
from .figures import INK, REFERENCE, Picture, apart, new_figure, open_axes
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
LONGEST = 8  # characters that name the poses of a component; there is no room for more
MOST_LEVELS = (
    8  # most levels that are drawn; there is no room for more beside the curve
)

SETTLED = 2e-3
"""Energy over that at rest, in weight times radius, below which no motion can be seen."""


def trajectory_figure(trajectory: Trajectory, root: SplittingNode) -> Figure:
    """Draw a drop: energy over weight, height of the centre of mass, and what happened when.

    Dashed lines are the levels at which the set that holds the final pose splits off, the eight
    that part most. From release to where nothing moves that can be seen; below, a row for each
    kind of event, with how many of all there are.
    """
    end = float(trajectory.times[first_still(trajectory, SETTLED)])
    figure = new_figure(6.4, 4.6, layout="constrained")
    rows = _rows(trajectory, root, end)
    high = 0.25 + ROW * len(rows)
    energy, events = figure.subplots(2, 1, sharex=True, height_ratios=(3.6, high))
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
    where = (
        f"comes to rest in pose {trajectory.pose}"
        if trajectory.pose >= 0
        else "not settled"
    )
    figure.suptitle(
        f"{shortened(trajectory.part_id, 30)}: {trajectory.impacts} impacts, {where}",
        fontsize=11,
        color=INK,
        parse_math=False,
    )
    return figure


def draw_energy(
    axes: Axes, trajectory: Trajectory, root: SplittingNode, end: float
) -> None:
    """Draw the energy over weight of a drop, and the levels on its way, until a time."""
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
    bottom = min(float(energy[-1]), 1e3 * float(trajectory.heights.min()))
    axes.set(
        yscale="log", xlim=(0.0, end), ylim=(0.88 * bottom, 1.25 * float(energy[0]))
    )
    axes.set_ylabel("mm above the plate", fontsize=10)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    open_axes(axes, "#e5e5e5", 0.6)
    low, high = np.log(axes.get_ylim())
    true = np.array([(np.log(1e3 * level) - low) / (high - low) for level, _ in levels])
    shown = apart(true, 0.052, 0.0, 1.0) if len(levels) else true
    for place, (level, poses) in enumerate(levels):
        axes.axhline(
            1e3 * level, color=REFERENCE, linewidth=0.8, linestyle="--", zorder=1
        )
        axes.annotate(
            f"below: {component_name(poses)}",
            (1.0, true[place]),
            xycoords="axes fraction",
            xytext=(1.03, shown[place]),
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
    """Those of the levels below which the most poses get out of reach, and always the last."""
    before = [poses, *(len(left) for _, left in levels)]
    lost = [before[k] - before[k + 1] for k in range(len(levels))]
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
    named = " ".join(map(str, poses))
    return f"poses {named}" if len(named) <= LONGEST else f"{len(poses)} poses"


def _rows(
    trajectory: Trajectory, root: SplittingNode, end: float
) -> list[tuple[str, str, str, Array]]:
    """Name, marker, colour and times of the kinds of events that happen before a time."""
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
            np.array([one.time for one in trajectory.events if one.kind == kind[0]]),
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
        shown = int((times <= end).sum())
        told = f"{shown} of {len(times)}" if shown < len(times) else f"{shown}"
        axes.annotate(
            told,
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


SIZE = (6.8, 3.4)
DPI = 100  # width and height of the animation, inches, and dots an inch

SCENE = (0.0, 0.0, 0.44, 0.86)
"""Place of the part in the picture: left, bottom, width, height, as fractions."""

WIDE = 3.3  # width of the scene, in radii
FOLLOWED = (
    1.7  # height of the centre of mass above which the view rises with it, in radii
)


def animation_frames(
    part: Part, trajectory: Trajectory, frames: DropFrames, root: SplittingNode
) -> Iterator[Picture]:
    """Draw a drop, frame by frame, as pixels (height, width, 3).

    The part on the left, in a view that rises with it; on the right its energy over weight, with
    the levels of the splitting graph, and what can still be reached.
    """
    figure, axes, words, clock = _stage(trajectory, frames, root)
    wide, high = (int(inches * DPI) for inches in SIZE)
    left, bottom, across, up = SCENE
    left = int(left * wide)
    top = high - int((bottom + up) * high)
    wide = 2 * int(0.5 * across * wide)
    high = 2 * int(0.5 * up * high)
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
    turns = vectors.rotation_matrices(frames.orientations)
    energy = energy_heights(trajectory)
    radius = trajectory.radius
    for k, time in enumerate(frames.times):
        canvas.restore_region(background)  # type: ignore[no-untyped-call]
        now = float(frames.energies[k]) * (energy[0] / trajectory.energies[0])
        point.set_data([min(time, frames.end)], [1e3 * now])
        reached = poses_within(levels, now, root.poses)
        named = (
            component_name(reached) if len(reached) < len(root.poses) else "every pose"
        )
        words.set_text(f"within reach: {named}")
        clock.set_text("at rest" if k >= frames.rest_frame else f"{time:.2f} s")
        for artist in (point, words, clock):
            figure.draw_artist(artist)
        drawn = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
        picture = np.asarray(drawn)[:, :, :3].copy()
        placed = triangles @ turns[k].T + np.array([0.0, 0.0, frames.heights[k]])
        above = max(0.0, float(frames.heights[k]) - FOLLOWED * radius)
        picture[top : top + high, left : left + wide] = rendered(
            placed,
            View(
                np.array([0.0, 0.0, 1.02 * radius + above]),
                WIDE * radius,
                (wide, high),
                plate=1.15 * radius,
            ),
        )
        yield picture


def _stage(
    trajectory: Trajectory, frames: DropFrames, root: SplittingNode
) -> tuple[Figure, Axes, Text, Text]:
    """What stays the same in every frame; axes of the energy; what is within reach; the time."""
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
    where = f"pose {trajectory.pose}" if trajectory.pose >= 0 else "no pose"
    pace = (
        "in true time"
        if frames.slowing == 1.0
        else f"slowed {frames.slowing:g} times"
        if frames.slowing > 1.0
        else f"{1.0 / frames.slowing:g} times as fast"
    )
    figure.text(
        0.02,
        0.945,
        f"{shortened(trajectory.part_id, 22)}: {trajectory.scene}",
        fontsize=9.5,
        color=INK,
        parse_math=False,
    )
    figure.text(0.02, 0.88, f"into {where}, {pace}", fontsize=9.5, color=REFERENCE)
    clock = figure.text(
        0.985, 0.945, "", fontsize=10.5, color=REFERENCE, ha="right", animated=True
    )
    return figure, axes, words, clock
