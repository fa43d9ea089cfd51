"""Rotations of resting parts, pose by pose."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed2
from ..compilation import entry_kernel

Array = NDArray[np.float64]

POLE = 1e-6
"""Closer than this to +z the axis of the smallest rotation would be rounding noise."""


@entry_kernel
def quaternions_down(downs: Fixed2) -> Array:
    """Quaternions (P, 4), x y z w, of the smallest rotations that take each of (P, 3) to -z."""
    found = np.zeros((downs.shape[0], 4))
    for i in range(downs.shape[0]):
        x, y, z = downs[i]
        if z > 0.0 and math.sqrt(x * x + y * y) < POLE:
            # Half a turn about x first, then the small rotation that is left from (x, -y, -z).
            found[i, 0], found[i, 2], found[i, 3] = 1.0 + z, -x, -y
        else:
            # 1 - z without losing digits near +z
            turn = (x * x + y * y) / (1.0 + z) if z > 0.0 else 1.0 - z
            found[i, 0], found[i, 1], found[i, 3] = -y, x, turn
        found[i] /= math.sqrt((found[i] * found[i]).sum())
    return found


@entry_kernel
def matrices_of(quaternions: Fixed2) -> Array:
    """Rotation matrices (P, 3, 3) of unit quaternions (P, 4), x y z w."""
    found = np.empty((quaternions.shape[0], 3, 3))
    for i in range(quaternions.shape[0]):
        x, y, z, w = quaternions[i]
        found[i, 0] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
        found[i, 1] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
        found[i, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    return found
