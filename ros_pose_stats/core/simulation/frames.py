"""A recorded drop at even steps of time, from shortly before it lands until it lies still.

A part that bounces on a rigid plate comes to rest through ever smaller bounces, and on a fine
curve through thousands of them. Once its energy exceeds that at rest by less than anybody sees,
the remaining motion is left out and the part is laid down in its pose.
"""

from typing import NamedTuple

import numpy as np

from ...base.errors import RequestError
from ..mesh.vectors import rotation_matrices
from ..records import Array, DropScene, Part, Trajectory
from ..resting.poses import RestingPoses
from .record_drop import drop_recorded

RATE = 15  # frames a second
SHOWN = 6.5  # most seconds that the motion takes on the screen
PAUSE = 1.2  # seconds that the part is shown at rest
FALL = 3.0  # height over the first contact, in radii, from which on the fall is shown
UNSEEN = (
    5e-3  # energy over that at rest, in weight times radius, whose motion nobody sees
)


class DropFrames(NamedTuple):
    """Frames of a drop."""

    times: Array  # (n,); seconds since release; the frames at rest share the last one
    heights: Array  # (n,); of the centre of mass, metres
    orientations: (
        Array  # (n, 4); quaternions x y z w of the part frame in the plate frame
    )
    energies: Array  # (n,); joules, never rising; the last is that at rest
    rest: int  # first frame at rest; n where the part did not settle
    slower: float  # factor by which the motion is slowed
    begin: float  # seconds since release at the first frame, and at the last in motion
    end: float


def watchable_drop(part: Part, scene: DropScene, seed: int, drop: int) -> Trajectory:
    """Record a drop to rest, or until its pose is certain where that takes too long."""
    for to_rest in (True, False):
        found = drop_recorded(part, scene, seed, drop, to_rest=to_rest)
        if found.pose >= 0:
            return found
    raise RequestError(
        "a drop that comes to rest",
        f"drop {drop}, which does not settle",
        "take another one, or a smaller restitution",
    )


def drop_frames(
    part: Part, trajectory: Trajectory, resting: RestingPoses
) -> DropFrames:
    """Cut a drop into frames at even steps of time, some seven seconds of them at most.

    The last ones lie in the pose, on the stable face nearest to where the motion is cut off.
    """
    weight = trajectory.energies[0] / trajectory.heights[0]
    landing = next(
        (event for event in trajectory.events if event.kind == "arrival"),
        trajectory.events[-1],
    )
    high = (trajectory.heights > landing.height + FALL * trajectory.radius) & (
        trajectory.times < landing.time
    )
    begin = float(trajectory.times[np.flatnonzero(high)[-1]]) if high.any() else 0.0
    last = first_still(trajectory, UNSEEN)
    orientation, height = _lay_down(trajectory, resting, last)
    end = float(trajectory.times[last])
    factors = [base * 10.0**power for power in range(-1, 6) for base in (1.0, 2.0, 5.0)]
    most = 1.0 / max((end - begin) / SHOWN, 1e-6)
    slower = max((factor for factor in factors if factor <= most), default=factors[0])
    motion = np.arange(begin, end, 1.0 / (slower * RATE))
    moving = len(motion)
    times: Array = np.append(motion, np.full(round(PAUSE * RATE), end))
    heights, orientations, energies = _interpolate(trajectory, times)
    heights[moving:] = height
    orientations[moving:] = orientation
    energies[moving:] = weight * height
    return DropFrames(
        times, heights, orientations, energies, moving, slower, begin, end
    )


def first_still(trajectory: Trajectory, unseen: float) -> int:
    """First sample whose energy is that at rest but for `unseen`, in weight times radius."""
    weight = trajectory.energies[0] / trajectory.heights[0]
    above = (
        trajectory.energies
        > trajectory.energies[-1] + unseen * weight * trajectory.radius
    )
    return min(int(np.flatnonzero(above)[-1]) + 1 if above.any() else 0, len(above) - 1)


def _interpolate(trajectory: Trajectory, times: Array) -> tuple[Array, Array, Array]:
    """Interpolate heights and orientations at some times; energies are those after the events."""
    place = np.clip(
        np.searchsorted(trajectory.times, times, side="right") - 1,
        0,
        len(trajectory.times) - 1,
    )
    after = np.minimum(place + 1, len(trajectory.times) - 1)
    span = trajectory.times[after] - trajectory.times[place]
    share = np.where(
        span > 0.0,
        (times - trajectory.times[place]) / np.where(span > 0, span, 1.0),
        0.0,
    )
    heights = (1.0 - share) * trajectory.heights[place] + share * trajectory.heights[
        after
    ]
    one = trajectory.orientations[place]
    two = trajectory.orientations[after]
    sign = np.where(
        (one * two).sum(axis=1) < 0.0, -1.0, 1.0
    )  # q and -q are the same turn
    turned = (1.0 - share)[:, None] * one + (share * sign)[:, None] * two
    return (
        heights,
        turned / np.linalg.norm(turned, axis=1)[:, None],
        np.minimum.accumulate(trajectory.energies)[place],
    )


def _lay_down(
    trajectory: Trajectory, resting: RestingPoses, last: int
) -> tuple[Array, float]:
    """Orientation and height on the face of the pose that is nearest to the last sample shown."""
    found = resting.equilibria
    members = np.flatnonzero(resting.clusters.pose == trajectory.pose)
    downs = found.downs[members]
    nearest = int(np.argmax(downs @ -trajectory.up[last]))
    turn = trajectory.orientations[last]
    # The smallest turn that brings the face's normal straight down, after the one there is.
    low = rotation_matrices(turn[None])[0] @ downs[nearest]
    tilt = np.append(np.cross(low, (0.0, 0.0, -1.0)), 1.0 - low[2])
    tilt /= np.linalg.norm(tilt)
    vector = tilt[3] * turn[:3] + turn[3] * tilt[:3] + np.cross(tilt[:3], turn[:3])
    orientation = np.append(vector, tilt[3] * turn[3] - tilt[:3] @ turn[:3])
    return orientation, float(found.heights[members[nearest]]) * trajectory.radius
