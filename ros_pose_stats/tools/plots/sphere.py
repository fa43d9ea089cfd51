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

"""The sphere of poses: contours, basins (Fig. 1C), reachable sets (Eq. 7)."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import withStroke

from ...core.records import Array, Index, Mask
from ...core.resting import pose_sphere, splitting_graph
from .figures import INK, REFERENCE, in_digits, new_figure

CONTOURS = 12
COLORS = "cividis"
"""Colour map from dark to light as in the paper, readable for the colour-blind and in
grey."""

MOST_BORDERS = 60
"""Most poses whose basins have borders; the facets of a curve would be nothing but
borders."""


def sphere_figure(
    sphere: pose_sphere.PoseSphere,
    function: splitting_graph.Function = "R",
    root: splitting_graph.SplittingNode | None = None,
) -> Figure:
    """Draw r or R over all poses, with basins, saddles and peaks (Fig. 1C).

    Two discs, the hemispheres of the directions that point down, in equal-area
    projection, seen from outside; lighter is higher. `root`: splitting graph, for the
    saddles where it splits.
    """
    values = 1e3 * (sphere.r if function == "r" else sphere.R)
    lowest = np.nanmin(values)
    highest = np.nanmax(values)
    span = max(highest - lowest, 1e-12)
    has_borders = 1 < len(sphere.downs) <= MOST_BORDERS
    figure, discs = two_discs(1, 0.0, 1.1)
    for hemisphere, axes in enumerate(discs[0]):
        # An image, since the outlines of the bands would have thousands of corners.
        bands = np.clip(
            np.floor(CONTOURS * (values[hemisphere] - lowest) / span), 0, CONTOURS - 1
        )
        axes.imshow(
            bands,
            origin="lower",
            extent=(-1, 1, -1, 1),
            vmin=0,
            vmax=CONTOURS - 1,
            cmap=COLORS,
            interpolation="nearest",
        )
        if has_borders:
            _draw_borders(axes, sphere.pose[hemisphere])
    draw_marks(discs[0], sphere, root)
    _draw_scale(figure, function, lowest, highest)
    _draw_key(figure, discs[0], has_borders)
    return figure


def _draw_scale(
    figure: Figure, function: splitting_graph.Function, lowest: float, highest: float
) -> None:
    page_height = figure.get_figheight()
    bar = figure.colorbar(
        ScalarMappable(
            Normalize(lowest, highest),
            colormaps[COLORS].resampled(CONTOURS),
        ),
        orientation="horizontal",
        cax=figure.add_axes((0.08, 0.98 / page_height, 0.84, 0.13 / page_height)),
    )
    meaning = "height of the centre of mass with u down"
    if function == "r":
        meaning = "distance from the centre of mass to the surface"
    bar.set_label(f"{function}(u), {meaning}, mm", fontsize=9)
    bar.ax.tick_params(labelsize=8.5)


def _draw_key(figure: Figure, discs: Sequence[Axes], has_borders: bool) -> None:
    symbols = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker="o",
            markersize=8,
            markerfacecolor="white",
            markeredgecolor="black",
            label="stable pose (number)",
        )
    ]
    if has_borders:
        symbols.append(
            Line2D([], [], color="black", linewidth=0.9, label="border of a basin")
        )
    handles = {
        name: handle
        for axes in discs
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    _draw_legend(figure, [*symbols, *handles.values()])


def _draw_legend(figure: Figure, handles: Sequence[Artist]) -> None:
    figure.legend(
        handles=handles,
        loc="lower center",
        ncols=2,
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handlelength=1.6,
    )


def _draw_borders(axes: Axes, pose: Index) -> None:
    """Lines between basins, seen on dark and light alike."""
    coordinates = pose_sphere.across_disc(len(pose))
    for index in np.unique(pose[pose >= 0])[1:]:
        # Only the rows and columns of the basin, which saves most of the time.
        rows, columns = (_extent((pose == index).any(axis=axis)) for axis in (1, 0))
        window = pose[rows, columns]
        inside = np.where(window >= 0, (window == index).astype(float), np.nan)
        with rc_context(
            {"path.effects": [withStroke(linewidth=2.2, foreground="#ffffff")]}
        ):
            axes.contour(
                coordinates[columns],
                coordinates[rows],
                inside,
                [0.5],
                colors="#000000",
                linewidths=0.9,
                zorder=2,
            )


def _extent(is_inside: Mask) -> slice:
    """From one before the first pixel inside to one behind the last."""
    inside = np.flatnonzero(is_inside)
    return slice(max(inside[0] - 1, 0), inside[-1] + 2)


DISC = 2.3  # distance of the discs, inches
SIDES = ("around the part's -z", "around the part's +z")
MOST_MARKS = 40  # most saddles or peaks that are marked; more would cover the map
MOST_LABELS = 60  # most poses that are numbered, the lowest ones

PEAK: dict[str, Any] = {
    "marker": "^",
    "markersize": 4.5,
    "color": "#000000",
    "markeredgecolor": "#ffffff",
    "markeredgewidth": 0.5,
    "label": "maximum (balanced)",
}
SADDLE_RIM: dict[str, Any] = {
    "marker": "x",
    "markersize": 6.0,
    "color": "#ffffff",
    "markeredgewidth": 3.0,
}
SADDLE: dict[str, Any] = {
    **SADDLE_RIM,
    "color": "#d7301f",
    "markeredgewidth": 1.5,
    "label": "saddle of the splitting graph",
}
"""Red crosses with a white rim."""

FEW = 20
NAMED = 3
"""A label names up to three poses; where a part has more poses than this, it names the
first."""

NEAR = (0.26, 0.19)
FAR = (0.38, 0.19)
"""Size of a label, in radii of the disc, of few poses and of many: poses within it
share one."""


def two_discs(rows: int, head: float, foot: float) -> tuple[Figure, list[list[Axes]]]:
    """Rows of two discs, with so many inches above each row and below all."""
    height = rows * (DISC + head) + foot
    figure = new_figure(2.0 * DISC, height)
    discs = []
    for row in range(rows):
        bottom = height - (row + 1) * (DISC + head)
        discs.append(
            [
                figure.add_axes((0.5 * hemisphere, bottom / height, 0.5, DISC / height))
                for hemisphere in range(2)
            ]
        )
        for hemisphere, axes in enumerate(discs[-1]):
            axes.set(xlim=(-1.35, 1.35), ylim=(-1.42, 1.28), aspect="equal")
            axes.set_axis_off()
            axes.add_patch(
                Circle(
                    (0.0, 0.0), 1.0, fill=False, edgecolor=INK, linewidth=1.0, zorder=3
                )
            )
            _name_rim(axes, hemisphere)
    return figure, discs


def _name_rim(axes: Axes, hemisphere: int) -> None:
    """Write the axes of the part at the rim, and that of the middle below the disc."""
    right_axis = "-x" if hemisphere == 0 else "+x"
    left_axis = "+x" if hemisphere == 0 else "-x"
    for text, x, y, side, foot in (
        (right_axis, 1.13, 0.0, "left", "center"),
        (left_axis, -1.13, 0.0, "right", "center"),
        ("+y", 0.0, 1.11, "center", "bottom"),
    ):
        axes.text(
            x,
            y,
            text.replace("-", "\N{MINUS SIGN}"),
            fontsize=8,
            color=REFERENCE,
            ha=side,
            va=foot,
        )
    axes.text(
        0.0,
        -1.15,
        SIDES[hemisphere].replace("-", "\N{MINUS SIGN}"),
        fontsize=8.5,
        color=REFERENCE,
        ha="center",
        va="top",
    )


def draw_marks(
    row: Sequence[Axes],
    sphere: pose_sphere.PoseSphere,
    root: splitting_graph.SplittingNode | None,
) -> None:
    """Draw peaks, saddles of the splitting graph, and the poses with their numbers."""
    if root is not None:
        saddles = [node.saddle for node in root.walk() if node.saddle is not None]
        if len(sphere.peaks) <= MOST_MARKS:
            _draw_symbols(row, sphere.peaks, **PEAK)
        if len(saddles) <= MOST_MARKS:
            for style in (SADDLE_RIM, SADDLE):
                _draw_symbols(row, np.array(saddles).reshape(-1, 3), **style)
    limit = NAMED if len(sphere.downs) <= FEW else 1
    for hemisphere, position, numbers in _labels(sphere.downs):
        text = ",".join(map(str, numbers[:limit])) + (
            "..." if len(numbers) > limit else ""
        )
        row[hemisphere].annotate(
            text,
            position,
            ha="center",
            va="center",
            fontsize=8,
            color="#000000",
            zorder=5,
            bbox={
                "boxstyle": "round,pad=0.22",
                "facecolor": "#ffffff",
                "edgecolor": "#000000",
                "linewidth": 0.8,
            },
        )


def _draw_symbols(row: Sequence[Axes], directions: Array, **style: Any) -> None:
    """A symbol at each direction (k, 3), on the disc of its hemisphere."""
    hemisphere, positions = pose_sphere.on_map(directions)
    for number, axes in enumerate(row):
        points = positions[hemisphere == number]
        if len(points):
            axes.plot(*points.T, linestyle="none", zorder=4, **style)


def _labels(downs: Array) -> Iterator[tuple[int, tuple[float, float], list[int]]]:
    """Places of the poses on the page; those that would cover each other share one."""
    hemisphere, positions = pose_sphere.on_map(downs)
    reach = NEAR if len(downs) <= FEW else FAR
    unlabelled = list(range(min(len(downs), MOST_LABELS)))
    while unlabelled:
        first = unlabelled[0]
        covered = [
            pose
            for pose in unlabelled
            if hemisphere[pose] == hemisphere[first]
            and (np.abs(positions[pose] - positions[first]) < reach).all()
        ]
        x, y = positions[first]
        yield hemisphere[first], (x, y), covered
        unlabelled = [pose for pose in unlabelled if pose not in covered]


DRAWN = 3  # energies whose reachable sets are drawn
APART = 0.03  # least difference of the energies that are drawn, as a fraction
BELOW = 1e-3
"""How far below a split the reachable set is drawn, as a fraction of its level."""

SHADES = ("#74a9cf", "#fee0b6", "#a1d99b", "#cbc9e2", "#fcbba1", "#f0f0f0")
"""Shades of components, different in lightness too as far as dark labels allow."""

UNREACHED = "#4d4d4d"


def reachable_figure(
    sphere: pose_sphere.PoseSphere,
    root: splitting_graph.SplittingNode,
    energies: Sequence[float],
) -> Figure:
    """Draw the poses that can still be reached at some energies (Eq. 7, Figs. 3D-F).

    `energies`: mechanical energy over weight, metres; a row of two discs each.
    Reachable poses are light, a shade a component, the others dark.
    """
    figure, discs = two_discs(len(energies), 0.25, 0.3)
    coordinates = pose_sphere.across_disc(sphere.R.shape[1])
    for row, energy in zip(discs, energies, strict=True):
        components = components_at(root, energy, sphere.heights)
        component_of = np.full(len(sphere.downs), -1)
        for number, poses in enumerate(components):
            component_of[list(poses)] = number
        for hemisphere, axes in enumerate(row):
            is_inside = sphere.pose[hemisphere] >= 0
            is_reached = is_inside & (sphere.R[hemisphere] <= energy)
            shade = np.where(
                is_reached, 1 + component_of[sphere.pose[hemisphere]] % len(SHADES), 0
            )
            axes.imshow(
                np.where(is_inside, shade, np.nan),
                origin="lower",
                extent=(-1, 1, -1, 1),
                interpolation="nearest",
                vmin=0,
                vmax=len(SHADES),
                cmap=ListedColormap([UNREACHED, *SHADES]),
            )
            height = np.where(is_inside, sphere.R[hemisphere], np.nan)
            if np.nanmin(height) < energy < np.nanmax(height):
                axes.contour(
                    coordinates,
                    coordinates,
                    height,
                    [energy],
                    colors="#000000",
                    linewidths=0.9,
                )
        draw_marks(row, sphere, None)
        summary = (
            f"{len(components)} separate sets"
            if len(components) > 1
            else "one connected set"
        )
        row[0].annotate(
            f"energy / weight {in_digits(1e3 * energy, 4)} mm: {summary}",
            (0.02, 1.0),
            xycoords="axes fraction",
            fontsize=9.5,
            color=INK,
            va="bottom",
        )
    _draw_legend(
        figure,
        [
            Patch(
                facecolor=SHADES[0],
                edgecolor="black",
                label="can still be reached (a shade a set)",
            ),
            Patch(facecolor=UNREACHED, label="out of reach"),
        ],
    )
    return figure


def components_at(
    root: splitting_graph.SplittingNode, energy: float, heights: Array
) -> list[tuple[int, ...]]:
    """Poses of each connected component in reach of an energy over weight, m."""
    components = []
    nodes = [root]
    while nodes:
        node = nodes.pop()
        if node.level is None or node.level <= energy:
            if heights[list(node.poses)].min() <= energy:
                components.append(node.poses)
        else:
            nodes.extend(reversed(node.parts))
    return components


def telling_energies(root: splitting_graph.SplittingNode) -> list[float]:
    """Energies over weight, m, just below the most probable splits, falling."""
    splits = {
        node.level: min(part.probability for part in node.parts)
        for node in root.walk()
        if node.level is not None
    }
    chosen: list[float] = []
    for level in sorted(splits, key=lambda level: -splits[level]):
        if len(chosen) < DRAWN and all(
            abs(level - chosen_level) > APART * chosen_level for chosen_level in chosen
        ):
            chosen.append(level)
    return [level * (1.0 - BELOW) for level in sorted(chosen, reverse=True)]
