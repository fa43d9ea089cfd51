"""The sphere of poses: contours of r(u) and R(u), basins (Fig. 1C), and reachable sets (Eq. 7)."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import withStroke

from ...core.records import Array, Index
from ...core.resting import pose_sphere, splitting_graph
from .figures import INK, REFERENCE, in_digits, new_figure

CONTOURS = 12
COLORS = "cividis"
"""Colour map from dark to light as in the paper, readable for the colour-blind and in grey."""

MOST_BORDERS = 60
"""Most poses whose basins have borders; the facets of a curve would be nothing but borders."""


def sphere_figure(
    sphere: pose_sphere.PoseSphere,
    function: splitting_graph.Function = "R",
    root: splitting_graph.SplittingNode | None = None,
) -> Figure:
    """Draw r or R over all poses, with basins, stable poses, saddles and peaks (Fig. 1C).

    Two discs, the hemispheres of the directions that point down, in equal-area projection, seen
    from outside; lighter is higher. `root`: splitting graph, for the saddles where it splits.
    """
    values = 1e3 * (sphere.r if function == "r" else sphere.R)
    low = float(np.nanmin(values))
    high = float(np.nanmax(values))
    span = max(high - low, 1e-12)
    bordered = 1 < len(sphere.downs) <= MOST_BORDERS
    figure, discs = two_discs(1, 0.0, 1.1)
    for hemisphere, axes in enumerate(discs[0]):
        # Drawn as an image, since the outlines of the bands would have thousands of corners.
        bands = np.clip(
            np.floor(CONTOURS * (values[hemisphere] - low) / span), 0, CONTOURS - 1
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
        if bordered:
            _draw_borders(axes, sphere.pose[hemisphere])
    mark(discs[0], sphere, root)
    high_page = figure.get_figheight()
    bar = figure.colorbar(
        ScalarMappable(
            Normalize(low, high),
            ListedColormap(colormaps[COLORS](np.linspace(0.0, 1.0, CONTOURS))),
        ),
        orientation="horizontal",
        cax=figure.add_axes((0.08, 0.98 / high_page, 0.84, 0.13 / high_page)),
    )
    what = (
        "distance from the centre of mass to the surface"
        if function == "r"
        else "height of the centre of mass with u down"
    )
    bar.set_label(f"{function}(u), {what}, mm", fontsize=9)
    bar.ax.tick_params(labelsize=8.5)
    keys = [
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
    if bordered:
        keys.append(
            Line2D([], [], color="black", linewidth=0.9, label="border of a basin")
        )
    drawn = {
        name: mark
        for axes in discs[0]
        for mark, name in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles=[*keys, *drawn.values()],
        loc="lower center",
        ncols=2,
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handlelength=1.6,
    )
    return figure


def _draw_borders(axes: Axes, pose: Index) -> None:
    """Lines between basins, seen on dark and light alike."""
    across = pose_sphere.across_disc(len(pose))
    for index in np.unique(pose[pose >= 0])[1:]:
        # Only the rows and columns of the basin, which saves most of the time.
        places = [np.flatnonzero((pose == index).any(axis=axis)) for axis in (1, 0)]
        rows, columns = (
            slice(max(int(one[0]) - 1, 0), int(one[-1]) + 2) for one in places
        )
        near = pose[rows, columns]
        inside = np.where(near >= 0, (near == index).astype(float), np.nan)
        with rc_context(
            {"path.effects": [withStroke(linewidth=2.2, foreground="#ffffff")]}
        ):
            axes.contour(
                across[columns],
                across[rows],
                inside,
                [0.5],
                colors="#000000",
                linewidths=0.9,
                zorder=2,
            )


DISC = 2.3  # distance of the discs, inches
SIDES = ("around the part's -z", "around the part's +z")
MOST_MARKS = 40  # most saddles or peaks that are marked; more would cover the map
MOST_LABELS = 60  # most poses that are numbered, the lowest ones

FEW = 20
NAMED = 3
"""A label names up to three poses; where a part has more poses than this, it names the first."""

NEAR = (0.26, 0.19)
FAR = (0.38, 0.19)
"""Size of a label, in radii of the disc, of few poses and of many: poses within it share one."""


def two_discs(rows: int, above: float, below: float) -> tuple[Figure, list[list[Axes]]]:
    """Rows of two discs, with inches left above each row and below all."""
    high = rows * (DISC + above) + below
    figure = new_figure(2.0 * DISC, high)
    found = []
    for row in range(rows):
        bottom = high - (row + 1) * (DISC + above)
        found.append(
            [
                figure.add_axes((0.5 * hemisphere, bottom / high, 0.5, DISC / high))
                for hemisphere in range(2)
            ]
        )
        for hemisphere, axes in enumerate(found[-1]):
            axes.set(xlim=(-1.35, 1.35), ylim=(-1.42, 1.28), aspect="equal")
            axes.set_axis_off()
            axes.add_patch(
                Circle(
                    (0.0, 0.0), 1.0, fill=False, edgecolor=INK, linewidth=1.0, zorder=3
                )
            )
            _name_rim(axes, hemisphere)
    return figure, found


def _name_rim(axes: Axes, hemisphere: int) -> None:
    """Write the axes of the part at the rim, and that of the middle below the disc."""
    right = "-x" if hemisphere == 0 else "+x"
    left = "+x" if hemisphere == 0 else "-x"
    for text, x, y in ((right, 1.13, 0.0), (left, -1.13, 0.0), ("+y", 0.0, 1.11)):
        axes.text(
            x,
            y,
            text.replace("-", "\N{MINUS SIGN}"),
            fontsize=8,
            color=REFERENCE,
            ha="left" if x > 0 else "right" if x < 0 else "center",
            va="bottom" if y > 0 else "center",
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


def mark(
    row: Sequence[Axes],
    sphere: pose_sphere.PoseSphere,
    root: splitting_graph.SplittingNode | None,
) -> None:
    """Draw peaks, saddles of the splitting graph, and the poses with their numbers."""
    if root is not None:
        saddles = [node.saddle for node in root.walk() if node.saddle is not None]
        for kind, points in (
            ("^", sphere.peaks),
            ("x", np.array(saddles).reshape(-1, 3)),
        ):
            if len(points) <= MOST_MARKS:
                _scatter(row, points, kind)
    named = NAMED if len(sphere.downs) <= FEW else 1
    for hemisphere, place, numbers in _labels(sphere.downs):
        text = ",".join(map(str, numbers[:named])) + (
            "..." if len(numbers) > named else ""
        )
        row[hemisphere].annotate(
            text,
            place,
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


def _scatter(row: Sequence[Axes], directions: Array, kind: str) -> None:
    hemisphere, place = pose_sphere.on_map(directions)
    for number, axes in enumerate(row):
        there = place[hemisphere == number]
        if not len(there):
            continue
        if kind == "x":
            axes.plot(
                *there.T,
                linestyle="none",
                marker="x",
                markersize=6.0,
                color="#ffffff",
                markeredgewidth=3.0,
                zorder=4,
            )
        axes.plot(
            *there.T,
            linestyle="none",
            marker=kind,
            markersize=6.0 if kind == "x" else 4.5,
            color="#d7301f" if kind == "x" else "#000000",
            markeredgecolor=None if kind == "x" else "#ffffff",
            markeredgewidth=1.5 if kind == "x" else 0.5,
            zorder=4,
            label="saddle of the splitting graph"
            if kind == "x"
            else "maximum (balanced)",
        )


def _labels(downs: Array) -> Iterator[tuple[int, tuple[float, float], list[int]]]:
    """Places of the poses on the page; those that would cover each other share one."""
    hemisphere, place = pose_sphere.on_map(downs)
    reach = NEAR if len(downs) <= FEW else FAR
    left = list(range(min(len(downs), MOST_LABELS)))
    while left:
        first = left[0]
        near = [
            one
            for one in left
            if hemisphere[one] == hemisphere[first]
            and (np.abs(place[one] - place[first]) < reach).all()
        ]
        yield (
            int(hemisphere[first]),
            (float(place[first, 0]), float(place[first, 1])),
            near,
        )
        left = [one for one in left if one not in near]


DRAWN = 3  # energies whose reachable sets are drawn
APART = 0.03  # least difference of the energies that are drawn, as a fraction
BELOW = (
    1e-3  # how far below a split the reachable set is drawn, as a fraction of its level
)

SHADES = ("#74a9cf", "#fee0b6", "#a1d99b", "#cbc9e2", "#fcbba1", "#f0f0f0")
"""Shades of components, different in lightness too as far as dark labels allow."""

UNREACHED = "#4d4d4d"


def reachable_figure(
    sphere: pose_sphere.PoseSphere,
    root: splitting_graph.SplittingNode,
    energies: Sequence[float],
) -> Figure:
    """Draw the poses that can still be reached at some energies (Eq. 7, Figs. 3D-F).

    `energies`: mechanical energy over weight, metres; a row of two discs each. Reachable poses are
    light, a shade a component, the others dark.
    """
    figure, discs = two_discs(len(energies), 0.25, 0.3)
    across = pose_sphere.across_disc(sphere.R.shape[1])
    for row, energy in zip(discs, energies, strict=True):
        parts = components_at(root, energy, sphere.heights)
        component = np.full(len(sphere.downs), -1)
        for number, poses in enumerate(parts):
            component[list(poses)] = number
        for hemisphere, axes in enumerate(row):
            inside = sphere.pose[hemisphere] >= 0
            reached = inside & (sphere.R[hemisphere] <= energy)
            shade = np.where(
                reached, 1 + component[sphere.pose[hemisphere]] % len(SHADES), 0
            )
            axes.imshow(
                np.where(inside, shade, np.nan),
                origin="lower",
                extent=(-1, 1, -1, 1),
                interpolation="nearest",
                vmin=0,
                vmax=len(SHADES),
                cmap=ListedColormap([UNREACHED, *SHADES]),
            )
            height = np.where(inside, sphere.R[hemisphere], np.nan)
            if np.nanmin(height) < energy < np.nanmax(height):
                axes.contour(
                    across, across, height, [energy], colors="#000000", linewidths=0.9
                )
        mark(row, sphere, None)
        several = (
            f"{len(parts)} separate sets" if len(parts) > 1 else "one connected set"
        )
        row[0].annotate(
            f"energy / weight {in_digits(1e3 * energy, 4)} mm: {several}",
            (0.02, 1.0),
            xycoords="axes fraction",
            fontsize=9.5,
            color=INK,
            va="bottom",
        )
    figure.legend(
        handles=[
            Patch(
                facecolor=SHADES[0],
                edgecolor="black",
                label="can still be reached (a shade a set)",
            ),
            Patch(facecolor=UNREACHED, label="out of reach"),
        ],
        loc="lower center",
        ncols=2,
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handlelength=1.6,
    )
    return figure


def components_at(
    root: splitting_graph.SplittingNode, energy: float, heights: Array
) -> list[tuple[int, ...]]:
    """Poses of each connected component that an energy over weight, metres, leaves in reach."""
    found = []
    waiting = [root]
    while waiting:
        node = waiting.pop()
        if node.level is None or node.level <= energy:
            if heights[list(node.poses)].min() <= energy:
                found.append(node.poses)
        else:
            waiting.extend(reversed(node.parts))
    return found


def telling_energies(root: splitting_graph.SplittingNode) -> list[float]:
    """Energies over weight, metres, just below the most probable splits, from the top down."""
    splits = {
        node.level: min(part.probability for part in node.parts)
        for node in root.walk()
        if node.level is not None
    }
    chosen: list[float] = []
    for level in sorted(splits, key=lambda level: -splits[level]):
        if len(chosen) < DRAWN and all(
            abs(level - one) > APART * one for one in chosen
        ):
            chosen.append(level)
    return [level * (1.0 - BELOW) for level in sorted(chosen, reverse=True)]
