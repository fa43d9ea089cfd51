"""Pictures of a part in its stable poses: side by side, beside another part, and small."""

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
MOST = 8  # most poses that are drawn, the most probable ones
PIXELS = 400  # pixels across a picture
HEAD = 0.62  # height of the text of a picture, inches
TITLE = 0.65  # height of the two lines above all pictures, inches
WIDTH = 3.0
PLATE = 1.05  # width of a picture, and half the side of the plate, in radii


def poses_figure(part: Part, found: PoseStatistics) -> Figure:
    """Draw the eight most probable poses of a part; those alike by symmetry as one."""
    groups = pose_groups(found)
    shown = groups[:MOST]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    pictures = pose_pictures(part, [group.first for group in shown], found.radius)
    shape = pictures[0].shape[0] / pictures[0].shape[1]
    width = 2.9
    high = 2.9 * shape + HEAD
    figure = new_figure(max(width * columns, 6.2), high * rows + TITLE)
    across, up = figure.get_size_inches()
    spare = 0.5 * (across - width * columns)
    for place, (group, picture) in enumerate(zip(shown, pictures, strict=True)):
        row, column = divmod(place, columns)
        left = spare + width * column
        bottom = up - TITLE - high * (row + 1) + 0.3
        axes = figure.add_axes(
            (left / across, bottom / up, width / across, (high - HEAD) / up)
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
    rest = sum(group.size for group in groups[MOST:])
    more = f"; {rest} less probable poses not shown" if rest else ""
    figure.suptitle(
        f"{text.shortened(found.part_id, int(4.5 * across))}: resting probabilities, "
        f"{name_source(found)}{more}\n{found.scene}",
        fontsize=12,
        color=INK,
        y=1.0 - 0.1 / up,
        parse_math=False,
    )
    return figure


def name_source(found: PoseStatistics) -> str:
    """Where probabilities come from, in a few words."""
    if found.method == methods.SIMULATION:
        return f"{found.drops} drops"
    return (
        f"{found.method}, {found.drops} drops"
        if found.drops
        else f"estimate ({found.method})"
    )


def pose_pictures(
    part: Part, poses: Sequence[StablePose], radius: float, pixels: int = PIXELS
) -> list[Picture]:
    """Pictures of a part of a radius (metres) in some poses, on the plate and at one scale."""
    triangles = decimation.visible_triangles(part) - part.center_of_mass
    laid = [_placed(triangles, _rotation(pose), pose) for pose in poses]
    view = resting_view(laid, radius, pixels)
    return [rendered(one, view) for one in laid]


def resting_view(laid: Sequence[Array], radius: float, pixels: int) -> View:
    """View of the plate that is high enough for the part in each of the poses."""
    sample = View(np.zeros(3), WIDTH * radius, (2, 2), plate=PLATE * radius)
    lean, about = np.radians((sample.elevation, sample.azimuth))
    _, up, _ = view_axes(sample)
    front = PLATE * radius * (abs(np.sin(about)) + abs(np.cos(about))) * np.sin(lean)
    above = max([front, *(float((one @ up).max()) for one in laid)])
    below = front
    margin = 0.05 * radius
    high = 2 * round(0.5 * pixels * (above + below + 2.0 * margin) / sample.width)
    middle = np.array([0.0, 0.0, 0.5 * (above - below) / np.cos(lean)])
    return sample._replace(center=middle, pixels=(pixels, high))


def _rotation(pose: StablePose) -> Array:
    return np.asarray(vectors.rotation_matrices(pose.orientation[None, :])[0])


def _placed(triangles: Array, rotation: Array, pose: StablePose) -> Array:
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

    `turn` (3, 3): from the frame of the first to that of the second, None where they are equal;
    `radius`: of the larger part, metres. The second is turned about the vertical as the first is.
    """
    first, second = (
        decimation.visible_triangles(part) - part.center_of_mass for part in parts
    )
    back = np.eye(3) if turn is None else turn.T
    laid: list[tuple[Array | None, Array | None]] = []
    for one, other in rows:
        rotation = np.eye(3) if one is None else _rotation(one)
        left = None if one is None else _placed(first, rotation, one)
        right = None
        if other is not None:
            # Beside the first, the smallest turn of it that lays the second on its own face.
            turned = (
                _rotation(other)
                if one is None
                else rotation @ _smallest_turn(back @ other.down, one.down) @ back
            )
            right = _placed(second, turned, other)
        laid.append((left, right))
    view = resting_view(
        [one for pair in laid for one in pair if one is not None], radius, BESIDE_PIXELS
    )
    return [
        [None if one is None else rendered(one, view) for one in pair] for pair in laid
    ]


def _smallest_turn(source: Array, target: Array) -> Array:
    """Smallest rotation of one unit vector onto another; a half turn where they are opposite."""
    quaternion = np.append(np.cross(source, target), 1.0 + source @ target)
    if quaternion[3] < 1e-12:
        aside = np.eye(3)[int(np.abs(source).argmin())]
        quaternion = np.append(np.cross(source, aside), 0.0)
    quaternion /= np.linalg.norm(quaternion)
    return np.asarray(vectors.rotation_matrices(quaternion[None, :])[0])


SMALL_PIXELS = 176  # pixels across: twice those that a table shows, for fine screens
SMALL_COLORS = 24  # more make the file larger than the eye sees at this size


def pose_thumbnail(part: Part, pose: StablePose, radius: float) -> bytes:
    """Picture of a part of a radius (metres) in a pose, as a PNG file of some two kilobytes."""
    (picture,) = pose_pictures(part, [pose], radius, SMALL_PIXELS)
    flat = Image.fromarray(picture).quantize(SMALL_COLORS, dither=Image.Dither.NONE)
    file = io.BytesIO()
    flat.save(file, format="PNG", optimize=True)
    return file.getvalue()
