"""Orientation of a resting part in the plate frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..kernels.body.standing import matrices_of, quaternions_down

Array = NDArray[np.float64]


def resting_quaternions(downs: ArrayLike) -> Array:
    """Smallest rotations that take each `down` to -z.

    `downs` (P, 3): unit vectors in the part frame. Returns (P, 4): quaternions x y z w of the part
    frame in the plate frame. At +z the half turn about the part's x axis is taken.
    """
    return quaternions_down(_plain(downs))


def rotation_matrices(quaternions: ArrayLike) -> Array:
    """Rotation matrices (P, 3, 3) of unit quaternions (P, 4), x y z w."""
    return matrices_of(_plain(quaternions))


def _plain(rows: ArrayLike) -> Array:
    """Copy to the layout that the kernels were compiled for; views and constants differ."""
    return np.array(rows, dtype=np.float64, order="C")
