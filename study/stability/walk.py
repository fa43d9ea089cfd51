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

"""A walk: bodies or scenes along one parameter, and what of their poses is watched."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.records import Array, Mask, Part
from ros_pose_stats.core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
)

SIZE = 0.02
"""Size of the bodies, metres, on which no number depends."""


@dataclass(frozen=True, eq=False)
class Step:
    """The part and the scene at one value of a walk.

    Attributes
    ----------
    part : Part
    restitution : float
    drop_height : float or None
        Metres; None for 20 radii.
    cluster_tolerance : float or None
        None for the walk's.
    """

    part: Part
    restitution: float = DEFAULT_RESTITUTION
    drop_height: float | None = None
    cluster_tolerance: float | None = None


@dataclass(frozen=True, eq=False)
class Walk:
    """A family of bodies or scenes along one parameter.

    Attributes
    ----------
    name : str
        For files.
    title : str
        Sentence that says what happens along the walk.
    parameter : str
        Label of the axis, with its unit.
    values : (k,) array
        Of the parameter, rising, where everything is measured.
    logarithmic : bool
        Whether the axis and the slopes are in the parameter's logarithm.
    make : callable
        From a value of the parameter to a `Step`.
    watched : callable
        From directions (P, 3) that point down in the poses to a mask (P,): the poses
        whose probabilities are added and followed.
    quantity : str
        Name of what is watched.
    cluster_tolerance : float
    round_sides : int
        As for `simulate`; 0 for bodies that are no parts.
    whole : bool
        Whether the parameter takes whole numbers only, so that no limit can be looked
        for.
    mark : float or None
        Value of the parameter at which the trouble is.
    """

    name: str
    title: str
    parameter: str
    values: NDArray[np.floating[Any]]
    logarithmic: bool
    make: Callable[[float], Step]
    watched: Callable[[Array], Mask]
    quantity: str
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE
    round_sides: int = 0
    whole: bool = False
    mark: float | None = None

    def position(self, value: float) -> float:
        """Position along the walk: the value or its logarithm."""
        return float(np.log(value)) if self.logarithmic else value

    def value(self, position: float) -> float:
        """The parameter at a position."""
        return float(np.exp(position)) if self.logarithmic else position

    def scene(self, step: Step) -> dict[str, Any]:
        """Keywords of the library for a step."""
        return {
            "restitution": step.restitution,
            "drop_height": step.drop_height,
            "cluster_tolerance": self.cluster_tolerance
            if step.cluster_tolerance is None
            else step.cluster_tolerance,
            "round_sides": self.round_sides,
        }


def is_towards(
    direction: tuple[float, float, float], angle: float
) -> Callable[[Array], Mask]:
    """Whether directions (P, 3) lie within an angle, in radians, of one."""
    unit = np.asarray(direction) / np.linalg.norm(direction)
    cosine = np.cos(angle)
    return lambda downs: np.asarray(downs @ unit >= cosine)


def is_along(axis: int) -> Callable[[Array], Mask]:
    """Whether directions (P, 3) lie nearest to an axis, either way."""
    return lambda downs: np.asarray(np.abs(downs[:, axis]) > 0.9)
