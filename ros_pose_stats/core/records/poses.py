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

"""A stable pose of a part, and poses that symmetry makes alike."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from .part import Array
from .plain_values import plain_value, without_rounding

POSE_FIELDS = (
    "index",
    "group",
    "group_size",
    "height",
    "top",
    "margin",
    "barrier",
    "spread",
    "rolls",
    "yaw_symmetry",
    "probability",
    "probability_low",
    "probability_high",
    "standard_error",
    "count",
    "group_probability",
)
"""Single values of a pose; JSON and messages have them under the same names."""

POSE_VECTORS = ("down", "roll_axis", "orientation")


class RestingShape(Protocol):
    """Contact polygon and silhouette of a part in one of its poses."""

    @property
    def support_polygon(self) -> Array:
        """Contact polygon (k, 2) in the plate frame, metres, counter-clockwise."""

    @property
    def outline(self) -> Array:
        """Convex silhouette (k, 2) in the plate frame, metres, counter-clockwise."""


@dataclass(frozen=True, eq=False)
class StablePose:
    """One stable pose of a part, with its resting probability.

    Attributes
    ----------
    index : int
        Number of the pose by geometry alone (rising height); equal for every method.
    group : int
        Shared by the poses that a proper rotation of the part carries into each other.
    down : (3,) array
        Unit vector in the part frame that points vertically down at rest.
    height : float
        Of the centre of mass above the plate, metres.
    top : float
        Of the highest point above the plate, metres.
    margin : float
        Smallest tilt of the plate that topples the part out of this pose, radians.
    barrier : float
        Rise of the centre of mass needed to leave the pose, metres; infinite for a
        single pose.
    spread : float
        Largest angle between the `down` of two members, radians.
    members : tuple of int
        The stable faces that are this pose, numbered by rising height over the whole
        part.
    orientation : (4,) array
        Quaternion x y z w of the part frame in the plate frame (smallest rotation).
    position : (3,) array
        Origin of the part frame in the plate frame, metres; the centre of mass is above
        (0, 0).
    shape : RestingShape
        Computes the contact polygon and the outline on demand.
    group_size : int
        Poses of its group.
    rolls : bool
        Whether it can go on by 90 degrees about the axis of a round, toothed or winding
        surface without rising by more than the cluster tolerance, over teeth by 0.025.
    roll_axis : (3,) array
        That axis on the plate, a unit vector of either sign; zero for none or several.
    yaw_symmetry : int
        Turns about the vertical that leave the part as it is: n-fold; 0 for any angle.
    probability : float
    probability_low, probability_high : float
        Bounds of the 90 % interval; NaN where none is known.
    standard_error : float
        NaN where none is known.
    count : int
        Drops that came to rest here; parts that were seen here where the method is
        `observed`.
    group_probability : float
        Of all poses of its group together.
    alike_from_above : tuple of int, optional
        Indices of the other poses that a camera above the plate cannot tell from this
        one, as `find_lookalikes` finds them; None until then.
    """

    index: int
    group: int
    down: Array
    height: float
    top: float
    margin: float
    barrier: float
    spread: float
    members: tuple[int, ...]
    orientation: Array
    position: Array
    shape: RestingShape = field(repr=False)
    group_size: int = 1
    rolls: bool = False
    roll_axis: Array = field(default_factory=lambda: np.zeros(3))
    yaw_symmetry: int = 1
    probability: float = math.nan
    probability_low: float = math.nan
    probability_high: float = math.nan
    standard_error: float = math.nan
    count: int = 0
    group_probability: float = math.nan
    alike_from_above: tuple[int, ...] | None = None

    @property
    def support_polygon(self) -> Array:
        """Contact polygon (k, 2), plate frame, metres, counter-clockwise from above."""
        return self.shape.support_polygon

    @property
    def outline(self) -> Array:
        """Silhouette (k, 2) of the hull, plate frame, metres, counter-clockwise."""
        return self.shape.outline

    @property
    def transform(self) -> Array:
        """Matrix (4, 4) that takes points of the part frame to the plate frame, metres.

        The same as `orientation` and `position`.
        """
        vector = self.orientation[:3]
        scalar = self.orientation[3]
        matrix = np.eye(4)
        matrix[:3, :3] = (
            (scalar * scalar - vector @ vector) * np.eye(3)
            + 2.0 * np.outer(vector, vector)
            + 2.0 * scalar * np.cross(np.eye(3), vector)
        )
        matrix[:3, 3] = self.position
        return matrix

    def with_values(self, **values: Any) -> "StablePose":
        """The same pose with other probabilities, or with its lookalikes."""
        pose = object.__new__(StablePose)
        pose.__dict__.update(self.__dict__, **values)
        return pose

    def as_dict(self) -> dict[str, Any]:
        """The pose as plain values under the keys of the JSON contract."""
        fields = {name: getattr(self, name) for name in POSE_FIELDS}
        vectors = {name: without_rounding(getattr(self, name)) for name in POSE_VECTORS}
        values: dict[str, Any] = plain_value(
            {
                **fields,
                **vectors,
                "position": without_rounding(self.position, self.height),
                "members": self.members,
                "alike_from_above": self.alike_from_above,
            }
        )
        return values


@dataclass(frozen=True, eq=False)
class PoseGroup:
    """Poses that a rotation of the part carries into each other, or a single pose."""

    # At least one, by rising `index`. All are as high; what ties decide may differ a
    # little.
    poses: tuple[StablePose, ...]
    probability: float  # of all of them together
    probability_low: float  # bounds of its 90 % interval; NaN where none is known
    probability_high: float
    count: int  # drops that came to rest in any of them

    @property
    def first(self) -> StablePose:
        """The pose of the smallest index."""
        return self.poses[0]

    @property
    def size(self) -> int:
        """Number of its poses."""
        return len(self.poses)

    @property
    def margin(self) -> float:
        """The smallest of its poses, radians."""
        return min(pose.margin for pose in self.poses)

    @property
    def barrier(self) -> float:
        """The smallest of its poses, metres."""
        return min(pose.barrier for pose in self.poses)

    @property
    def indices(self) -> tuple[int, ...]:
        """Of its poses, rising."""
        return tuple(pose.index for pose in self.poses)


def single_poses(poses: Iterable[StablePose]) -> tuple[PoseGroup, ...]:
    """Each pose by itself, in their order."""
    return tuple(
        PoseGroup(
            (pose,),
            pose.probability,
            pose.probability_low,
            pose.probability_high,
            pose.count,
        )
        for pose in poses
    )


def lookalikes(group: PoseGroup, groups: Iterable[PoseGroup]) -> tuple[int, ...]:
    """Other poses that look like those of a group from above, rising.

    None of those that symmetry makes the same, in whichever of `groups`; none if it is
    not known.
    """
    twins = {
        pose.index
        for other in groups
        if other.first.group == group.first.group
        for pose in other.poses
    }
    alike = group.first.alike_from_above or ()
    return tuple(index for index in alike if index not in twins)
