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

"""Which stable pose a part lies in, from its orientation as a camera measured it."""

import math

import numpy as np
from numpy.typing import ArrayLike

from ...base.errors import RequestError
from ..mesh.arrays import NOT_NUMBERS, number_or_nan, real_array
from ..records import Array, Index, Part
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES
from .poses import RestingPoses, resting_poses

DEFAULT_ANGLE = math.radians(15.0)
"""Three standard deviations of a camera that measures tilts to 5 degrees."""

DEVIATIONS = 3.0
"""Standard deviations of the camera's error within which an orientation is taken for a
pose; of errors that are normal about both horizontal axes 1.1 % are larger."""

SURELY = 1e6  # how many times as likely as any other pose a part's pose must be

UNIT_WITHIN = 0.01
"""Quaternions may be that far from unit length, for having been printed with two
digits."""

AT_ONCE = 2**21  # angles between orientations and faces that are held at once


def classify_orientations(
    part: Part,
    orientations: ArrayLike,
    angle: float = DEFAULT_ANGLE,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> Index:
    """Stable pose that each observed orientation of a part belongs to.

    Only the direction that an orientation says is down counts; yaw is free. A pose of
    several faces, as one that rolls, is met by any of its `members`. Poses of one
    `group` look alike: of them the nearest is named, which for a symmetric part says no
    more than which of the equal orientations the camera chose, so that counts of such
    parts are to be summed by group.

    Parameters
    ----------
    part : Part
    orientations : (n, 4) array_like
        Unit quaternions x y z w of the part frame in the plate frame, z up. Rows that
        are zero or not finite stand for an orientation that is not known.
    angle : float
        Largest tilt between an orientation and its pose, radians: three standard
        deviations of the camera's error about a horizontal axis. Such an error decides
        too whether a pose is told from those of other groups: at 15 degrees, poses less
        than 26 degrees apart are not.
    cluster_tolerance, round_sides
        By which the poses are numbered, as in `resting_poses`.

    Returns
    -------
    (n,) array of int
        `index` of the pose; -1 where the orientation is near none, is nearly as likely
        that of a pose of another group, or is not known.

    Raises
    ------
    RequestError
        If the orientations are not (n, 4) numbers, one has another length than 1, or
        the angle is not above 0 and up to a right angle.
    """
    largest_tilt = number_or_nan(angle)
    if not 0.0 < largest_tilt <= 0.5 * math.pi:
        raise RequestError(
            "an angle above 0 and up to 1.57 radians",
            f"{angle!r}",
            "math.radians(15) is the default",
        )
    poses = resting_poses(part, cluster_tolerance, round_sides)
    downs = observed_downs(orientations)
    pose = np.full(len(downs), -1, dtype=np.int64)
    known_rows = np.flatnonzero(np.isfinite(downs[:, 0]))
    step = max(1, AT_ONCE // len(poses.clusters.pose))
    for begin in range(0, len(known_rows), step):
        rows = known_rows[begin : begin + step]
        pose[rows] = _find_nearest(poses, downs[rows], largest_tilt)
    return pose


def observed_downs(orientations: ArrayLike) -> Array:
    """Directions (n, 3) that point down in observed orientations.

    NaN where they are not known.
    """
    try:
        quaternions = real_array(orientations)
    except NOT_NUMBERS as error:
        raise RequestError(
            "orientations as (n, 4) numbers x y z w", f"{error}", "one row a part"
        ) from error
    if quaternions.ndim != 2 or quaternions.shape[1] != 4:
        if quaternions.size:
            raise RequestError(
                "orientations as (n, 4) numbers x y z w",
                f"an array of shape {quaternions.shape}",
                "one row a part",
            )
        quaternions = quaternions.reshape(0, 4)
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.sqrt((quaternions * quaternions).sum(axis=1))
    is_known = np.isfinite(quaternions).all(axis=1) & (length > 0.0)
    wrong_rows = np.flatnonzero(is_known & ~(np.abs(length - 1.0) <= UNIT_WITHIN))
    if len(wrong_rows):
        raise RequestError(
            "unit quaternions x y z w",
            f"one of length {length[wrong_rows[0]]:g} in row {wrong_rows[0]}",
            "divide each by its length; zeros stand for an unknown orientation",
        )
    downs = np.full((len(quaternions), 3), np.nan)
    x, y, z, w = (quaternions[is_known] / length[is_known, None]).T
    downs[is_known] = -np.column_stack(
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y))
    )
    return downs


def _find_nearest(poses: RestingPoses, downs: Array, angle: float) -> Index:
    """Pose of each direction (n, 3), -1 where none is sure."""
    group = poses.group[poses.clusters.pose]  # of each stable face
    cosine = downs @ poses.equilibria.downs.T
    face = cosine.argmax(axis=1)
    other_cosine = np.where(group == group[face, None], -np.inf, cosine).max(axis=1)
    tilt, other_tilt = (
        np.arccos(np.clip(cosines, -1.0, 1.0))
        for cosines in (cosine.max(axis=1), other_cosine)
    )
    # The logarithm of how many times as likely the nearest is, where errors are normal.
    log_ratio = 0.5 * (other_tilt**2 - tilt**2) * (DEVIATIONS / angle) ** 2
    is_sure = (other_cosine == -np.inf) | (log_ratio >= math.log(SURELY))
    return np.where((tilt <= angle) & is_sure, poses.clusters.pose[face], -1)
