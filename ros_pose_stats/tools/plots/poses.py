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

"""Pictures of a part in its poses: side by side, with another part, small."""

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from ...base import methods, text
from ...core.mesh import decimation, vectors
from ...core.records import Array, Part, PoseStatistics, StablePose
from ...core.statistics.pose_groups import pose_groups
from .figures import INK, REFERENCE, Picture, in_digits, new_figure
from .rendering import View, rendered, view_axes

COLUMNS = 4
MOST = 8  # poses that are drawn, the most probable ones
PIXELS = 400  # pixels across a picture
HEAD = 0.62  # height of the text of a picture, inches
TITLE = 0.65  # height of the two lines above all pictures, inches
WIDTH = 3.0
PLATE = 1.05  # width of a picture, and half the side of the plate, in radii


def poses_figure(part: Part, statistics: PoseStatistics) -> Figure:
    """Draw the eight most probable poses of a part; those alike by symmetry as one."""
    groups = pose_groups(statistics)
    drawn_groups = groups[:MOST]
    columns = min(COLUMNS, len(drawn_groups))
    rows = -(-len(drawn_groups) // columns)
    pictures = pose_pictures(
        part, [group.first for group in drawn_groups], statistics.radius
    )
    aspect = pictures[0].shape[0] / pictures[0].shape[1]
    width = 2.9
    cell_height = 2.9 * aspect + HEAD
    figure = new_figure(max(width * columns, 6.2), cell_height * rows + TITLE)
    page_width, page_height = figure.get_size_inches()
    margin = 0.5 * (page_width - width * columns)
    for number, (group, picture) in enumerate(zip(drawn_groups, pictures, strict=True)):
        row, column = divmod(number, columns)
        x = margin + width * column
        bottom = page_height - TITLE - cell_height * (row + 1) + 0.3
        axes = figure.add_axes(
            (
                x / page_width,
                bottom / page_height,
                width / page_width,
                (cell_height - HEAD) / page_height,
            )
        )
        axes.imshow(picture, interpolation="antialiased")
        axes.set_axis_off()
        axes.set_title(
            f"{text.shortened(text.name_poses(group.indices), 30)}: "
            f"{100.0 * group.probability:.1f} %",
            fontsize=10.5,
            color=INK,
            pad=3.0,
        )
        axes.annotate(
            f"centre of mass {in_digits(1e3 * group.first.height, 3)} mm up",
            (0.5, 0.0),
            xycoords="axes fraction",
            ha="center",
            va="top",
            fontsize=9,
            color=REFERENCE,
        )
    hidden = sum(group.size for group in groups[MOST:])
    note = f"; {hidden} less probable poses not shown" if hidden else ""
    figure.suptitle(
        f"{text.shortened(statistics.part_id, int(4.5 * page_width))}: "
        "resting probabilities, "
        f"{name_source(statistics)}{note}\n{statistics.scene}",
        fontsize=12,
        color=INK,
        y=1.0 - 0.1 / page_height,
        parse_math=False,
    )
    return figure


def name_source(statistics: PoseStatistics) -> str:
    """Where probabilities come from, in a few words."""
    if statistics.method == methods.SIMULATION:
        return f"{statistics.drops} drops"
    return (
        f"{statistics.method}, {statistics.drops} drops"
        if statistics.drops
        else f"estimate ({statistics.method})"
    )


def pose_pictures(
    part: Part, poses: Sequence[StablePose], radius: float, pixels: int = PIXELS
) -> list[Picture]:
    """Pictures of a part of a radius (metres) on the plate, at one scale."""
    triangles = decimation.visible_triangles(part) - part.center_of_mass
    placed = [_place(triangles, _rotation(pose.orientation), pose) for pose in poses]
    view = resting_view(placed, radius, pixels)
    return [rendered(resting, view) for resting in placed]


def resting_view(placed: Sequence[Array], radius: float, pixels: int) -> View:
    """View of the plate that is high enough for the part in each of the poses."""
    sample = View(np.zeros(3), WIDTH * radius, (2, 2), plate=PLATE * radius)
    elevation, azimuth = np.radians((sample.elevation, sample.azimuth))
    _, upwards, _ = view_axes(sample)
    front = (
        PLATE
        * radius
        * (abs(np.sin(azimuth)) + abs(np.cos(azimuth)))
        * np.sin(elevation)
    )
    upper = max([front, *((triangles @ upwards).max() for triangles in placed)])
    margin = 0.05 * radius
    height = 2 * round(0.5 * pixels * (upper + front + 2.0 * margin) / sample.width)
    middle = np.array([0.0, 0.0, 0.5 * (upper - front) / np.cos(elevation)])
    return sample._replace(center=middle, pixels=(pixels, height))


def _rotation(quaternion: Array) -> Array:
    return np.asarray(vectors.rotation_matrices(quaternion[None, :])[0])


def _place(triangles: Array, rotation: Array, pose: StablePose) -> Array:
    """Turn triangles (t, 3, 3) about the centre of mass and lay them on the plate."""
    return np.asarray(triangles @ rotation.T + np.array([0.0, 0.0, pose.height]))


BESIDE_PIXELS = 320  # pixels across a picture


def pictures_beside(
    parts: tuple[Part, Part],
    turn: Array | None,
    rows: Sequence[Sequence[StablePose | None]],
    radius: float,
) -> list[list[Picture | None]]:
    """Pictures of corresponding poses of two parts, on the plate and at one scale.

    `turn` (3, 3): from the frame of the first to that of the second, None where they
    are equal; `radius`: of the larger part, metres. The second is turned about the
    vertical as the first is.
    """
    first, second = (
        decimation.visible_triangles(part) - part.center_of_mass for part in parts
    )
    first_turn = np.eye(3) if turn is None else turn.T
    pairs: list[tuple[Array | None, Array | None]] = []
    for first_pose, second_pose in rows:
        first_placed = None
        second_placed = None
        if first_pose is not None:
            rotation = _rotation(first_pose.orientation)
            first_placed = _place(first, rotation, first_pose)
        if second_pose is not None:
            second_rotation = _rotation(second_pose.orientation)
            if first_pose is not None:
                # The smallest turn of the first that lays the second on its own face.
                down = first_turn @ second_pose.down
                tilt = _smallest_turn(down, first_pose.down)
                second_rotation = rotation @ tilt @ first_turn
            second_placed = _place(second, second_rotation, second_pose)
        pairs.append((first_placed, second_placed))
    placed = [
        triangles for pair in pairs for triangles in pair if triangles is not None
    ]
    view = resting_view(placed, radius, BESIDE_PIXELS)
    return [
        [None if triangles is None else rendered(triangles, view) for triangles in pair]
        for pair in pairs
    ]


def _smallest_turn(source: Array, target: Array) -> Array:
    """Smallest rotation of one unit vector onto another, however they lie."""
    quaternion = np.append(np.cross(source, target), 1.0 + source @ target)
    if quaternion[3] < 1e-12:
        axis = np.eye(3)[np.abs(source).argmin()]
        quaternion = np.append(np.cross(source, axis), 0.0)
    quaternion /= np.linalg.norm(quaternion)
    return _rotation(quaternion)


SMALL_PIXELS = 176  # pixels across: twice those that a table shows, for fine screens
SMALL_COLORS = 24  # more make the file larger than the eye sees at this size


def pose_thumbnail(part: Part, pose: StablePose, radius: float) -> bytes:
    """A part of a radius (metres) in a pose, as a PNG file of two kilobytes."""
    (picture,) = pose_pictures(part, [pose], radius, SMALL_PIXELS)
    flat = Image.fromarray(picture).quantize(SMALL_COLORS, dither=Image.Dither.NONE)
    file = io.BytesIO()
    flat.save(file, format="PNG", optimize=True)
    return file.getvalue()
