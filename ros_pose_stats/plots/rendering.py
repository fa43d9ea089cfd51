"""A part on the plate as pixels: orthographic, with hidden surfaces, edges and a shadow.

The nearest triangle of each pixel is seen, so that concave parts come out right; a picture takes a
few hundredths of a second.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rasters import nearest_triangles

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LIGHT = np.array([-0.25, -0.5, 0.8]) / np.linalg.norm([-0.25, -0.5, 0.8])
PART = np.array([0.42, 0.64, 0.92])
PLATE, RIM, SHADOW = 0.925, 0.72, 0.70
"""Greys of the plate, its border and the shadow straight below the part."""

LINE = 0.28
"""Brightness left on an edge."""

CREASE = np.cos(np.radians(25.0))
"""Two triangles that meet at a larger angle have an edge between them."""

STEP = 0.02
"""Jump of depth that counts as an outline, as a fraction of the picture's width."""

FINENESS = 2
"""Samples a pixel, each way."""


class View(NamedTuple):
    """What a picture shows of the plate's frame.

    Attributes
    ----------
    center : (3,) array
        In the middle of the picture, metres.
    width : float
        Metres across the picture.
    pixels : (int, int)
        Width and height.
    elevation, azimuth : float
        Of the viewer, degrees.
    plate : float
        Half the side of the plate around the origin, metres.
    """

    center: Array
    width: float
    pixels: tuple[int, int]
    elevation: float = 22.0
    azimuth: float = -62.0
    plate: float = 0.0


def rendered(triangles: Array, view: View, color: Array = PART) -> NDArray[np.uint8]:
    """Draw triangles above the plate z = 0.

    Parameters
    ----------
    triangles : (t, 3, 3) array
        Corners in the plate frame, metres, counter-clockwise seen from outside.
    view : View
    color : (3,) array
        Of the part, 0 to 1.

    Returns
    -------
    (height, width, 3) array of uint8
        White where there is nothing.
    """
    wide, high = (FINENESS * side for side in view.pixels)
    normals = _normals(triangles)
    right, up, towards = view_axes(view)
    scale = wide / view.width
    frame = np.stack([scale * right, -scale * up, scale * towards], axis=1)
    shift = np.array([0.5 * wide, 0.5 * high, 0.0]) - view.center @ frame
    seen = normals @ towards > 1e-9
    nearest, depth = nearest_triangles(triangles[seen] @ frame + shift, wide, high)
    plate, level = _plate(frame, shift, view.plate, wide, high)
    plate &= ~(depth > level)
    parts = int(seen.sum())
    nearest[plate], depth[plate] = parts, level[plate]
    bright = _brightness(normals[seen])
    shades = np.concatenate([bright[:, None] * color, np.full((1, 3), PLATE), np.ones((1, 3))])
    picture = shades[np.where(nearest < 0, parts + 1, nearest)]
    lit = triangles[normals[:, 2] > 1e-9] * (1.0, 1.0, 0.0) @ frame + shift
    picture[plate & (nearest_triangles(lit, wide, high)[0] >= 0)] *= SHADOW / PLATE
    facing = np.concatenate([normals[seen], [[0.0, 0.0, 1.0]], np.zeros((1, 3))])
    picture *= _edges(nearest, depth, facing, parts, STEP * wide)[..., None]
    picture = np.clip(picture, 0.0, 1.0)
    samples = [picture[i::FINENESS, j::FINENESS] for i in range(FINENESS) for j in range(FINENESS)]
    return np.asarray(sum(samples) * (255.0 / len(samples)) + 0.5, dtype=np.uint8)


def _normals(triangles: Array) -> Array:
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    return np.asarray(normals / lengths[:, None])


def view_axes(view: View) -> tuple[Array, Array, Array]:
    """Right and up in the picture, and the direction to the viewer."""
    up, about = np.radians((view.elevation, view.azimuth))
    towards = np.array([np.cos(up) * np.cos(about), np.cos(up) * np.sin(about), np.sin(up)])
    right = np.array([-np.sin(about), np.cos(about), 0.0])
    return right, np.cross(towards, right), towards


def _brightness(normals: Array) -> Array:
    return np.asarray(0.38 + 0.68 * (0.5 + 0.5 * normals @ LIGHT) ** 1.5)


def _plate(frame: Array, shift: Array, side: float, wide: int,
           high: int) -> tuple[NDArray[np.bool_], Array]:
    """Which pixels show the plate if nothing is on it, and its depth (high, wide)."""
    x, y = np.meshgrid(np.arange(wide) + 0.5 - shift[0], np.arange(high) + 0.5 - shift[1])
    # The picture's two axes as seen from points of z = 0.
    onto = np.linalg.inv(frame[:2, :2])
    east, north = (x * onto[0, k] + y * onto[1, k] for k in range(2))
    inside = (np.abs(east) <= side) & (np.abs(north) <= side)
    return inside, east * frame[0, 2] + north * frame[1, 2] + shift[2]


def _edges(nearest: Index, depth: Array, facing: Array, parts: int, step: float) -> Array:
    """Brightness (high, wide): dark where a crease or an outline runs, light grey at the rim."""
    bright = np.ones(nearest.shape)
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        differ = np.nonzero(nearest[here] != nearest[there])
        one, two = nearest[here][differ], nearest[there][differ]
        part = ((one >= 0) & (one < parts)) | ((two >= 0) & (two < parts))
        bend = (facing[one] * facing[two]).sum(axis=1) < CREASE
        with np.errstate(invalid="ignore"):
            jump = ~(np.abs(depth[here][differ] - depth[there][differ]) < step)
        value = np.where(part & (bend | jump), LINE, np.where(~part & bend, RIM, 1.0))
        for side in (here, there):
            bright[side][differ] = np.minimum(bright[side][differ], value)
    return bright
