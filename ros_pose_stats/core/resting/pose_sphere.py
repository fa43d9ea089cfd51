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

"""The sphere of poses as two flat maps: r(u), R(u) and all basins (Fig. 1C).

A direction u is the point of the part that is down. Each hemisphere is drawn in
Lambert's azimuthal equal-area projection as it is seen from outside, so that areas on
the page compare like solid angles.
"""

import math
from typing import NamedTuple

import numpy as np

from ..records import Array, Index
from . import poses

FINEST = 200
COARSEST = 60  # pixels across a hemisphere
# Most directions times faces; parts of many faces get a coarser map.
MOST_PRODUCTS = 2e8
AT_ONCE = 4_000_000  # most numbers in memory at a time


class PoseSphere(NamedTuple):
    """Maps of the two hemispheres, those around -z and +z of the part."""

    # (2, n, n, 3); unit vectors in the part frame; NaN outside of the discs. Rows go up
    # the page
    directions: Array
    r: Array  # (2, n, n); metres; NaN outside of the discs
    R: Array
    # (2, n, n) int; `index` of the pose whose basin the direction lies in; -1 outside
    # of the discs
    pose: Index
    downs: Array  # (P, 3); minima: `down` of the poses, by their index
    heights: Array  # (P,); their values of R, metres
    peaks: Array  # (U, 3); maxima of r and R


def pose_sphere(resting: poses.RestingPoses) -> PoseSphere:
    """Map r, R and the basins of a part (section 2.C, Figs. 1C and 3D-F)."""
    body = resting.body
    finest_pixels = math.sqrt(
        MOST_PRODUCTS / (body.faces + len(body.points)) / (0.5 * math.pi)
    )
    directions = _directions(int(min(max(finest_pixels, COARSEST), FINEST)))
    on_disc = np.isfinite(directions[..., 0])
    samples = directions[on_disc]
    r = np.empty(len(samples))
    height = np.empty(len(samples))
    face = np.empty(len(samples), dtype=np.int64)
    step = max(1, AT_ONCE // max(body.faces, len(body.points)))
    for begin in range(0, len(samples), step):
        batch = slice(begin, begin + step)
        steepness = (
            samples[batch] @ (body.arrays.normal / body.arrays.distance[:, None]).T
        )
        face[batch] = steepness.argmax(axis=1)
        r[batch] = 1.0 / steepness.max(axis=1)
        height[batch] = body.R(samples[batch])
    maps = np.full((2, *on_disc.shape), np.nan)
    maps[0][on_disc] = body.radius * r
    maps[1][on_disc] = body.radius * height
    pose_of_pixel = np.full(on_disc.shape, -1, dtype=np.int64)
    pose_of_pixel[on_disc] = resting.pose_of_face[face]
    peaks = resting.equilibria.peaks
    return PoseSphere(
        directions,
        maps[0],
        maps[1],
        pose_of_pixel,
        np.array([pose.down for pose in resting.poses]),
        np.array([pose.height for pose in resting.poses]),
        peaks / np.linalg.norm(peaks, axis=1)[:, None],
    )


def on_map(directions: Array) -> tuple[Index, Array]:
    """Hemisphere (k,) of directions (k, 3), 0 around -z, and places (k, 2) on it."""
    x, y, z = np.asarray(directions, dtype=np.float64).reshape(-1, 3).T
    hemisphere = (z > 0.0).astype(np.int64)
    # Lambert: the distance from the middle is sqrt(2) sin(half the polar angle).
    scale = 1.0 / np.sqrt(1.0 + np.abs(z))
    horizontal = np.where(hemisphere == 1, x, -x)  # from below, +x is to the left
    return hemisphere, np.stack([horizontal, y], axis=1) * scale[:, None]


def across_disc(pixels: int) -> Array:
    """Middles (n,) of the pixels across a disc of radius 1."""
    return (2.0 * np.arange(pixels) + 1.0) / pixels - 1.0


def _directions(pixels: int) -> Array:
    middle = across_disc(pixels)
    x, y = np.meshgrid(middle, middle)
    square = x**2 + y**2
    with np.errstate(invalid="ignore"):
        scale = np.where(square <= 1.0, np.sqrt(2.0 - square), np.nan)
    z = 1.0 - square
    upper = np.stack([x * scale, y * scale, z + 0.0 * scale], axis=-1)
    return np.stack([upper * (-1.0, 1.0, -1.0), upper])
