"""Poses of two variants of a part beside each other, seen from the same side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..mesh.decimation import visible_triangles
from ..mesh.vectors import rotation_matrices
from ..records import Part, StablePose
from .poses import resting_view
from .rendering import rendered

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

PIXELS = 320
"""Pixels across a picture."""


def pictures_beside(parts: tuple[Part, Part], turn: Array | None,
                    rows: Sequence[tuple[StablePose | None, StablePose | None]], radius: float,
                    pixels: int = PIXELS) -> list[tuple[Picture | None, Picture | None]]:
    """Pictures of corresponding poses of two parts, on the plate and all at one scale.

    `turn` (3, 3): from the frame of the first to that of the second; None where they are equal;
    `rows`: of the first part and of the second; None where there is none; `radius`: of the larger
    part, metres. Returns the second part is turned about the vertical as the first one is.
    """
    first, second = (visible_triangles(part) - part.center_of_mass for part in parts)
    back = np.eye(3) if turn is None else turn.T
    laid: list[tuple[Array | None, Array | None]] = []
    for one, other in rows:
        rotation = np.eye(3) if one is None else _rotation(one)
        left = None if one is None else _placed(first, rotation, one)
        right = None
        if other is not None:
            # Beside the first, the smallest turn of it that lays the second on its own face.
            turned = (_rotation(other) if one is None else
                      rotation @ _smallest_turn(back @ other.down, one.down) @ back)
            right = _placed(second, turned, other)
        laid.append((left, right))
    view = resting_view([one for pair in laid for one in pair if one is not None], radius, pixels)
    return [(None if left is None else rendered(left, view),
             None if right is None else rendered(right, view)) for left, right in laid]


def _rotation(pose: StablePose) -> Array:
    return np.asarray(rotation_matrices(pose.orientation[None, :])[0])


def _placed(triangles: Array, rotation: Array, pose: StablePose) -> Array:
    return np.asarray(triangles @ rotation.T + np.array([0.0, 0.0, pose.height]))


def _smallest_turn(source: Array, target: Array) -> Array:
    """Smallest rotation of one unit vector onto another; a half turn where they are opposite."""
    cosine = float(source @ target)
    axis = np.cross(source, target)
    if cosine < -1.0 + 1e-12:
        aside = np.eye(3)[int(np.abs(source).argmin())]
        across = np.cross(source, aside)
        across = across / np.linalg.norm(across)
        return np.asarray(2.0 * np.outer(across, across) - np.eye(3))
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + cosine))
