"""Orientation of a resting part in the plate frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POLE = 1e-6
"""Closer than this to +z the axis of the smallest rotation would be rounding noise."""


def resting_quaternions(downs: Array) -> Array:
    """Smallest rotations that take each `down` to -z.

    Parameters
    ----------
    downs : (P, 3) array
        Unit vectors in the part frame.

    Returns
    -------
    (P, 4) array
        Quaternions x y z w of the part frame in the plate frame. At +z the half turn about
        the part's x axis is taken.
    """
    x, y, z = downs.T
    at_pole = (z > 0.0) & (np.hypot(x, y) < POLE)
    # 1 - z without losing digits near +z
    turn = np.where(z > 0.0, (x * x + y * y) / (1.0 + np.abs(z)), 1.0 - z)
    quaternion = np.stack([-y, x, np.zeros_like(x), turn], axis=1)
    # Half a turn about x first, then the small rotation that is left from (x, -y, -z).
    tilt = np.stack([y, x, np.zeros_like(x), 1.0 + z], axis=1)
    half_turn = np.stack([tilt[:, 3], tilt[:, 2], -tilt[:, 1], -tilt[:, 0]], axis=1)
    quaternion = np.where(at_pole[:, None], half_turn, quaternion)
    return np.asarray(quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True))


def rotation_matrices(quaternions: Array) -> Array:
    """Rotation matrices (P, 3, 3) of unit quaternions (P, 4), x y z w."""
    x, y, z, w = quaternions.T
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
            2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
            2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]
    return np.stack(rows, axis=1).reshape(-1, 3, 3)
