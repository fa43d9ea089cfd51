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

"""A recorded drop in frames, from shortly before it lands until it lies still.

A part that bounces on a rigid plate comes to rest through ever smaller bounces, and on
a fine curve through thousands of them. Once its energy exceeds that at rest by less
than anybody sees, the remaining motion is left out and the part is laid down in its
pose.
"""

from typing import NamedTuple

import numpy as np

from ...base.errors import RequestError
from ..mesh.vectors import rotation_matrices
from ..records import Array, DropScene, Part, Trajectory
from ..resting.poses import RestingPoses
from .record_drop import record_scene_drop

RATE = 15  # frames a second
LONGEST_MOTION = 6.5  # most seconds that the motion takes on the screen
PAUSE = 1.2  # seconds that the part is shown at rest
FALL = 3.0  # height over the first contact, in radii, from which on the fall is shown
UNSEEN_ENERGY = 5e-3
"""Energy over that at rest, in weight times radius, whose motion nobody sees."""


class DropFrames(NamedTuple):
    """Frames of a drop."""

    times: Array  # (n,); seconds since release; the frames at rest share the last one
    heights: Array  # (n,); of the centre of mass, metres
    # (n, 4); quaternions x y z w of the part frame in the plate frame
    orientations: Array
    energies: Array  # (n,); joules, never rising; the last is that at rest
    rest_frame: int  # first frame at rest; n where the part did not settle
    slowing: float  # factor by which the motion is slowed
    begin: float  # seconds since release at the first frame, and at the last in motion
    end: float


def watchable_drop(part: Part, scene: DropScene, seed: int, drop: int) -> Trajectory:
    """Record a drop to rest, or until its pose is certain where that takes too long."""
    for to_rest in (True, False):
        trajectory = record_scene_drop(part, scene, seed, drop, to_rest=to_rest)
        if trajectory.pose >= 0:
            return trajectory
    raise RequestError(
        "a drop that comes to rest",
        f"drop {drop}, which does not settle",
        "take another one, or a smaller restitution",
    )


def drop_frames(
    part: Part, trajectory: Trajectory, resting: RestingPoses
) -> DropFrames:
    """Cut a drop into frames at even steps of time, some seven seconds of them at most.

    The last ones lie in the pose, on the stable face nearest to where the motion is cut
    off.
    """
    weight = trajectory.energies[0] / trajectory.heights[0]
    landing = next(
        (event for event in trajectory.events if event.kind == "arrival"),
        trajectory.events[-1],
    )
    is_high = (trajectory.heights > landing.height + FALL * trajectory.radius) & (
        trajectory.times < landing.time
    )
    begin = (
        float(trajectory.times[np.flatnonzero(is_high)[-1]]) if is_high.any() else 0.0
    )
    last = first_still(trajectory, UNSEEN_ENERGY)
    orientation, height = _lay_down(trajectory, resting, last)
    end = float(trajectory.times[last])
    factors = [base * 10.0**power for power in range(-1, 6) for base in (1.0, 2.0, 5.0)]
    largest_factor = 1.0 / max((end - begin) / LONGEST_MOTION, 1e-6)
    slowing = max(
        (factor for factor in factors if factor <= largest_factor), default=factors[0]
    )
    motion = np.arange(begin, end, 1.0 / (slowing * RATE))
    moving_frames = len(motion)
    times: Array = np.append(motion, np.full(round(PAUSE * RATE), end))
    heights, orientations, energies = _interpolate(trajectory, times)
    heights[moving_frames:] = height
    orientations[moving_frames:] = orientation
    energies[moving_frames:] = weight * height
    return DropFrames(
        times, heights, orientations, energies, moving_frames, slowing, begin, end
    )


def first_still(trajectory: Trajectory, unseen_energy: float) -> int:
    """First sample whose energy is that at rest but for what nobody sees.

    `unseen_energy`: in weight times radius.
    """
    weight = trajectory.energies[0] / trajectory.heights[0]
    is_moving = (
        trajectory.energies
        > trajectory.energies[-1] + unseen_energy * weight * trajectory.radius
    )
    if not is_moving.any():
        return 0
    return min(int(np.flatnonzero(is_moving)[-1]) + 1, len(is_moving) - 1)


def _interpolate(trajectory: Trajectory, times: Array) -> tuple[Array, Array, Array]:
    """Heights and orientations at some times, and energies after the events."""
    sample = np.clip(
        np.searchsorted(trajectory.times, times, side="right") - 1,
        0,
        len(trajectory.times) - 1,
    )
    next_sample = np.minimum(sample + 1, len(trajectory.times) - 1)
    span = trajectory.times[next_sample] - trajectory.times[sample]
    share = np.where(
        span > 0.0,
        (times - trajectory.times[sample]) / np.where(span > 0, span, 1.0),
        0.0,
    )
    height = trajectory.heights[sample]
    next_height = trajectory.heights[next_sample]
    heights = (1.0 - share) * height + share * next_height

    turn = trajectory.orientations[sample]
    next_turn = trajectory.orientations[next_sample]
    # q and -q are the same turn.
    sign = np.where((turn * next_turn).sum(axis=1) < 0.0, -1.0, 1.0)
    next_share = (share * sign)[:, None]
    orientation = (1.0 - share)[:, None] * turn + next_share * next_turn
    return (
        heights,
        orientation / np.linalg.norm(orientation, axis=1)[:, None],
        np.minimum.accumulate(trajectory.energies)[sample],
    )


def _lay_down(
    trajectory: Trajectory, resting: RestingPoses, last: int
) -> tuple[Array, float]:
    """Orientation and height on the pose's face nearest to the last sample."""
    equilibria = resting.equilibria
    members = np.flatnonzero(resting.clusters.pose == trajectory.pose)
    downs = equilibria.downs[members]
    nearest = int(np.argmax(downs @ -trajectory.up[last]))
    turn = trajectory.orientations[last]
    # The smallest turn that brings the face's normal straight down, after the one there
    # is.
    face_normal = rotation_matrices(turn[None])[0] @ downs[nearest]
    tilt = np.append(np.cross(face_normal, (0.0, 0.0, -1.0)), 1.0 - face_normal[2])
    tilt /= np.linalg.norm(tilt)
    vector = tilt[3] * turn[:3] + turn[3] * tilt[:3] + np.cross(tilt[:3], turn[:3])
    orientation = np.append(vector, tilt[3] * turn[3] - tilt[:3] @ turn[:3])
    return orientation, float(equilibria.heights[members[nearest]]) * trajectory.radius
