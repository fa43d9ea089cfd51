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

"""A part on the plate as pixels: orthographic, with edges and a shadow.

The nearest triangle of each pixel is seen, so that concave parts come out right; a
picture takes a few hundredths of a second.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.records import Array, Index, Mask

LIGHT = np.array([-0.25, -0.5, 0.8]) / np.linalg.norm([-0.25, -0.5, 0.8])
PART = np.array([0.42, 0.64, 0.92])
PLATE = 0.925
RIM = 0.72
SHADOW = 0.70
"""Greys of the plate, its border and the shadow straight below the part."""

LINE = 0.28  # brightness left on an edge

CREASE = np.cos(np.radians(25.0))
"""Angle between two triangles above which an edge is drawn between them."""

STEP = 0.02  # of depth that makes an outline, as a fraction of the picture's width
FINENESS = 2  # samples of a pixel in each direction


class View(NamedTuple):
    """The part of the plate frame that a picture shows, and the viewer's direction."""

    center: Array  # (3,); point in the middle of the picture, metres
    width: float  # metres across the picture
    pixels: tuple[int, int]  # width and height
    elevation: float = 22.0  # of the viewer, degrees
    azimuth: float = -62.0
    plate: float = 0.0  # half the side of the plate around the origin, metres


def rendered(triangles: Array, view: View, color: Array = PART) -> NDArray[np.uint8]:
    """Draw triangles (t, 3, 3) above the plate z = 0, as pixels (height, width, 3).

    In the plate frame, metres, counter-clockwise seen from outside; `color`: of the
    part, or of each triangle, 0 to 1.
    """
    width, height = (FINENESS * side for side in view.pixels)
    normals = triangle_normals(triangles)
    right, upwards, towards = view_axes(view)
    scale = width / view.width
    frame = np.stack([scale * right, -scale * upwards, scale * towards], axis=1)
    shift = np.array([0.5 * width, 0.5 * height, 0.0]) - view.center @ frame
    is_visible = normals @ towards > 1e-9
    nearest, depth = nearest_triangles(
        triangles[is_visible] @ frame + shift, width, height
    )
    plate, level = _plate(frame, shift, view.plate, width, height)
    plate &= ~(depth > level)
    parts = int(is_visible.sum())
    nearest[plate] = parts
    depth[plate] = level[plate]
    bright = 0.38 + 0.68 * (0.5 + 0.5 * normals[is_visible] @ LIGHT) ** 1.5
    colors = np.broadcast_to(color, (len(triangles), 3))[is_visible]
    shades = np.concatenate(
        [bright[:, None] * colors, np.full((1, 3), PLATE), np.ones((1, 3))]
    )
    picture = shades[np.where(nearest < 0, parts + 1, nearest)]
    lit = triangles[normals[:, 2] > 1e-9] * (1.0, 1.0, 0.0) @ frame + shift
    picture[plate & (nearest_triangles(lit, width, height)[0] >= 0)] *= SHADOW / PLATE
    facing = np.concatenate([normals[is_visible], [[0.0, 0.0, 1.0]], np.zeros((1, 3))])
    picture *= _edges(nearest, depth, facing, parts, STEP * width)[..., None]
    picture = np.clip(picture, 0.0, 1.0)
    samples = [
        picture[i::FINENESS, j::FINENESS]
        for i in range(FINENESS)
        for j in range(FINENESS)
    ]
    return np.asarray(sum(samples) * (255.0 / len(samples)) + 0.5, dtype=np.uint8)


def triangle_normals(triangles: Array) -> Array:
    """Unit normals (t, 3) of triangles (t, 3, 3); zero where a triangle has no area."""
    normals = np.cross(
        triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    )
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    return np.asarray(normals / lengths[:, None])


def view_axes(view: View) -> tuple[Array, Array, Array]:
    """Right and up in the picture, and the direction to the viewer."""
    elevation, azimuth = np.radians((view.elevation, view.azimuth))
    towards = np.array(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ]
    )
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return right, np.cross(towards, right), towards


def _plate(
    frame: Array, shift: Array, side: float, width: int, height: int
) -> tuple[Mask, Array]:
    """Which pixels show the bare plate, and its depth (height, width)."""
    x, y = np.meshgrid(
        np.arange(width) + 0.5 - shift[0], np.arange(height) + 0.5 - shift[1]
    )
    # The picture's two axes as seen from points of z = 0.
    inverse = np.linalg.inv(frame[:2, :2])
    east, north = (x * inverse[0, k] + y * inverse[1, k] for k in range(2))
    is_inside = (np.abs(east) <= side) & (np.abs(north) <= side)
    return is_inside, east * frame[0, 2] + north * frame[1, 2] + shift[2]


def _edges(
    nearest: Index, depth: Array, facing: Array, parts: int, step: float
) -> Array:
    """Brightness (height, width): dark on creases and outlines, grey at the rim."""
    bright = np.ones(nearest.shape)
    for first, second in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        is_different = np.nonzero(nearest[first] != nearest[second])
        first_triangle = nearest[first][is_different]
        second_triangle = nearest[second][is_different]
        is_part = ((first_triangle >= 0) & (first_triangle < parts)) | (
            (second_triangle >= 0) & (second_triangle < parts)
        )
        is_bent = (facing[first_triangle] * facing[second_triangle]).sum(
            axis=1
        ) < CREASE
        with np.errstate(invalid="ignore"):
            is_jump = ~(
                np.abs(depth[first][is_different] - depth[second][is_different]) < step
            )
        brightness = np.where(
            is_part & (is_bent | is_jump), LINE, np.where(~is_part & is_bent, RIM, 1.0)
        )
        for side in (first, second):
            bright[side][is_different] = np.minimum(
                bright[side][is_different], brightness
            )
    return bright


AT_ONCE = 3_000_000  # most pixels of triangles in memory at a time


def nearest_triangles(corners: Array, width: int, height: int) -> tuple[Index, Array]:
    """The triangle in every pixel, -1 for none, and its depth at the middle.

    `corners` (t, 3, 3): across and down the picture in pixels, and towards the viewer.
    """
    nearest = np.full(width * height, -1, dtype=np.int64)
    depth = np.full(width * height, -np.inf)
    owner, y, begin, end = _spans(corners, width, height)
    span = end - begin
    # Rise of the depth across and down each triangle; none where it is seen edge-on.
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    edge_on = np.abs(normal[:, 2:]) < 1e-9
    slope = np.where(
        edge_on, 0.0, -normal[:, :2] / np.where(edge_on, 1.0, normal[:, 2:])
    )
    covers = np.flatnonzero(span)
    portions = np.cumsum(span[covers]) // AT_ONCE
    lowest = corners[:, :, 2].min(axis=1)
    highest = corners[:, :, 2].max(axis=1)
    for portion in np.split(covers, np.flatnonzero(np.diff(portions)) + 1):
        row, position = _stretches(span[portion])
        row = portion[row]
        x = begin[row] + position
        triangle = owner[row]
        pixel = y[row] * width + x
        origin = corners[triangle, 0]
        distance = (
            origin[:, 2]
            + (x + 0.5 - origin[:, 0]) * slope[triangle, 0]
            + (y[row] + 0.5 - origin[:, 1]) * slope[triangle, 1]
        )
        distance = np.clip(distance, lowest[triangle], highest[triangle])
        np.maximum.at(depth, pixel, distance)
        is_nearest = distance >= depth[pixel]
        nearest[pixel[is_nearest]] = triangle[is_nearest]
    return nearest.reshape(height, width), depth.reshape(height, width)


def _spans(
    corners: Array, width: int, height: int
) -> tuple[Index, Index, Index, Index]:
    """Triangle, row, first column and end of every covered stretch of pixels."""
    low = _first_pixel(corners[:, :, 1].min(axis=1), height)
    top = _first_pixel(corners[:, :, 1].max(axis=1), height)
    owner, position = _stretches(top - low)
    y = low[owner] + position
    # Where the middle of the row crosses the three sides, (n, 3).
    p_x, p_y = np.moveaxis(corners[owner, :, :2], 2, 0)
    q_x, q_y = np.roll((p_x, p_y), -1, axis=2)
    middle = y[:, None] + 0.5
    crosses = (p_y <= middle) != (q_y <= middle)
    share = np.divide(middle - p_y, q_y - p_y, np.zeros(p_y.shape), where=crosses)
    x = p_x + share * (q_x - p_x)
    begin = _first_pixel(np.where(crosses, x, np.inf).min(axis=1), width)
    end = _first_pixel(np.where(crosses, x, -np.inf).max(axis=1), width)
    return owner, y, begin, np.maximum(end, begin)


def _stretches(lengths: Index) -> tuple[Index, Index]:
    """Number of the stretch of each of their elements, and its position in it."""
    owner = np.repeat(np.arange(len(lengths)), lengths)
    return owner, np.arange(len(owner)) - (np.cumsum(lengths) - lengths)[owner]


def _first_pixel(position: Array, limit: int) -> Index:
    """First pixel whose middle lies behind a position, from 0 to a limit."""
    return np.clip(np.ceil(position - 0.5), 0, limit).astype(np.int64)
