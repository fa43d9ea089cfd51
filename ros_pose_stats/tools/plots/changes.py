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

"""A part coloured by what changes of it do: where to add, and where to take away."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ...base.text import points, shortened
from ...core.mesh.decimation import visible_triangles
from ...core.records import Array, Index
from ...core.resting.convex_body import ConvexBody
from ..design import describe, sensitivity
from . import figures, rendering

ADD = np.array([0.0, 0.45, 0.70])
TAKE = np.array([0.84, 0.37, 0.0])
PLAIN = np.array([0.86, 0.86, 0.86])
FAINTEST = 0.35  # strength of the colour of a gain that is small beside the greatest

SIDES = (
    ("as in the part frame, from above", np.ones(3)),
    ("turned upside down about x", np.array([1.0, -1.0, -1.0])),
)
"""How the part is shown, with the light from above each time."""

ON_FACE = 0.01
SAME_NORMAL = 0.998
"""A triangle this close to a face of the hull, in radii, and as steep, is coloured like
it."""

PIXELS = 620
LISTED = 4

SHADES = (
    "the stronger the colour of a face, the more a step gains by drops; "
    "grey: drops show no gain"
)


def changes_figure(sensitivities: sensitivity.Sensitivity) -> Figure:
    """Draw a part from two sides: blue faces are better moved out, orange in.

    The stronger the colour, the more a step gains by drops; what they do not show to
    gain is grey. The arrow leads the centre of mass to where it is better.
    """
    figure = figures.new_figure(9.0, 5.6)
    space = sensitivities.space
    triangles = visible_triangles(space.part) - space.part.center_of_mass
    body = space.body
    shades = triangle_colors(sensitivities, triangles)
    view = rendering.View(
        np.zeros(3), 2.1 * body.radius, (PIXELS, PIXELS), elevation=28.0
    )
    for column, (title, mirror) in enumerate(SIDES):
        axes = figure.add_axes((0.01 + 0.49 * column, 0.2, 0.48, 0.68))
        axes.imshow(
            rendering.rendered(triangles * mirror, view, shades),
            interpolation="antialiased",
        )
        axes.set_axis_off()
        axes.set_title(title, fontsize=10, color=figures.REFERENCE)
        _draw_arrow(axes, view, _gradient(sensitivities) * mirror, body.radius)
    figure.suptitle(
        f"{shortened(space.part.part_id, 30)}: "
        f"wanted {shortened(sensitivities.goal.describe(), 40)}, "
        f"{100.0 * sensitivities.accepted.value:.1f} % by {sensitivities.method}",
        fontsize=12,
        color=figures.INK,
        parse_math=False,
    )
    figure.legend(
        handles=[
            Patch(color=tuple(ADD), label="add here"),
            Patch(color=tuple(TAKE), label="take away here"),
        ],
        loc="lower left",
        bbox_to_anchor=(0.02, 0.02),
        frameon=False,
        fontsize=10,
    )
    figure.text(0.26, 0.025, SHADES, fontsize=8, color=figures.REFERENCE)
    figure.text(
        0.26,
        0.165,
        "\n".join(_gain_lines(sensitivities)),
        fontsize=9,
        color=figures.INK,
        va="top",
    )
    return figure


def _gain_lines(sensitivities: sensitivity.Sensitivity) -> list[str]:
    """The greatest gains in words, or why there is none."""
    lines = [
        f"{points(check.value)} points ({points(check.low)} to {points(check.high)}): "
        f"{describe.name_step(sensitivities.space, effect.number, effect.step)}"
        for effect, check in sensitivities.gains[:LISTED]
    ]
    return lines or [sensitivities.describe_gain()]


def triangle_colors(sensitivities: sensitivity.Sensitivity, triangles: Array) -> Array:
    """Colours (t, 3), 0 to 1, of triangles (t, 3, 3) about the centre of mass."""
    faces = _faces_of(triangles, sensitivities.space.body)
    return np.asarray(face_colors(sensitivities)[faces])


def face_colors(sensitivities: sensitivity.Sensitivity) -> Array:
    """Colours (F + 1, 3) of the faces of the hull, and of what lies on none."""
    space = sensitivities.space
    colors = np.tile(PLAIN, (space.body.faces + 1, 1))
    faces = [
        (effect, check.value)
        for effect, check in sensitivities.gains
        if effect.feature.kind == "face"
    ]
    for effect, gain in faces:
        color = ADD if effect.step > 0.0 else TAKE
        strength = FAINTEST + (1.0 - FAINTEST) * gain / faces[0][1]
        for number in effect.alike:
            colors[space.features[number].planes] = (
                strength * color + (1.0 - strength) * PLAIN
            )
    return colors


def _faces_of(triangles: Array, body: ConvexBody) -> Index:
    """Face of the hull that each triangle (t, 3, 3) lies on; F for none."""
    normals = rendering.triangle_normals(triangles)
    centroids = triangles.mean(axis=1) / body.radius
    faces = np.empty(len(triangles), dtype=np.int64)
    for begin in range(0, len(triangles), 1000):
        portion = slice(begin, begin + 1000)
        alignment = normals[portion] @ body.arrays.normal.T
        distance = np.abs(
            centroids[portion] @ body.arrays.normal.T - body.arrays.distance
        )
        fits = (alignment > SAME_NORMAL) & (distance < ON_FACE)
        faces[portion] = np.where(
            fits.any(axis=1), np.where(fits, alignment, -2.0).argmax(axis=1), body.faces
        )
    return faces


def _gradient(sensitivities: sensitivity.Sensitivity) -> Array:
    """Direction (3,) to move the centre of mass in; zero where none is clear."""
    slope = np.zeros(3)
    for effect, check in sensitivities.gains:
        if effect.feature.kind == "centre":
            slope[effect.feature.axis] = math.copysign(check.value, effect.step)
    length = np.linalg.norm(slope)
    return slope / length if length else slope


def _draw_arrow(
    axes: Axes, view: rendering.View, direction: Array, radius: float
) -> None:
    if not direction.any():
        return
    right, upwards, _ = rendering.view_axes(view)
    scale = view.pixels[0] / view.width
    tip = 0.45 * radius * scale * np.array([direction @ right, -direction @ upwards])
    middle = 0.5 * np.array(view.pixels)
    axes.annotate(
        "",
        (middle + tip).tolist(),
        middle.tolist(),
        arrowprops={
            "arrowstyle": "-|>",
            "color": figures.INK,
            "linewidth": 2.0,
            "mutation_scale": 16,
        },
    )
    axes.plot(*middle, "o", color=figures.INK, markersize=4)
