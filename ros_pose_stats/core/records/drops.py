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

"""What drops and kicks bring: a motion, a simulation's state, counted flips."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .notes import Note
from .part import Array, Index
from .plain_values import with_units
from .poses import StablePose
from .scene import describe_scene
from .statistics import PoseStatistics


@dataclass(frozen=True, eq=False)
class DropEvent:
    """Something that happened during a drop, and the state right after it.

    Attributes
    ----------
    time : float
        Seconds since release.
    kind : str
        `release`; `arrival` (a vertex reaches the plate; the state is that before the
        impacts); `impact` (a single one, of a sequence where several vertices touch);
        `stop` (touching vertices that are slow have been brought to rest: the limit of
        an infinite series of impacts); `lift-off` (a contact force has come down to
        zero); `end`.
    vertex : int
        Hull point concerned; -1 for none.
    mode : str
        The motion that follows: `flight`, `vertex`, `edge` or `face`.
    contact : tuple of int
        Hull points that slide on the plate from here on.
    height : float
        Of the centre of mass, metres.
    velocity : float
        Vertical, of the centre of mass, m/s.
    up : (3,) array
        Vertical direction in part axes.
    angular_velocity : (3,) array
        In part axes, rad/s.
    """

    time: float
    kind: str
    vertex: int
    mode: str
    contact: tuple[int, ...]
    height: float
    velocity: float
    up: Array
    angular_velocity: Array


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """One drop from release to where its outcome was certain, or to rest.

    Attributes
    ----------
    part_id, part_digest : str
    radius : float
        Metres.
    restitution : float
    drop_height : float
        Height of the centre of mass that was asked for, metres.
    down : (3,) array
        Starting direction, in part axes.
    pose : int
        `index` of the pose that it comes to rest in; -1 where it did not settle.
    impacts : int
    at_rest : bool
        Whether the part lies still at the end; else the recording ends once the pose is
        certain.
    events : tuple of DropEvent
    times : (n,) array
        Seconds, rising; every event is among them, once before and once after it.
    heights, velocities : (n,) array
        Of the centre of mass, m and m/s.
    up, angular_velocities : (n, 3) array
        In part axes; rad/s.
    orientations : (n, 4) array
        Quaternions x y z w of the part frame in the plate frame, the centre of mass
        staying above one point of the plate. At release the smallest rotation is taken.
    energies : (n,) array
        Mechanical energy, joules, the plate at 0.
    """

    part_id: str
    part_digest: str
    radius: float
    restitution: float
    drop_height: float
    down: Array
    pose: int
    impacts: int
    at_rest: bool
    events: tuple[DropEvent, ...]
    times: Array
    heights: Array
    velocities: Array
    up: Array
    angular_velocities: Array
    orientations: Array
    energies: Array

    @property
    def scene(self) -> str:
        """How high the part was released, onto what, and how bouncy, as a sentence."""
        return describe_scene(self.restitution, self.drop_height)

    def __repr__(self) -> str:
        return (
            f"Trajectory({self.part_id!r}, {len(self.events)} events, "
            f"{len(self.times)} samples, {self.times[-1]:.4g} s, pose {self.pose})"
        )


@dataclass(frozen=True, eq=False)
class DropProgress:
    """State of a simulation, as `on_progress` receives it.

    Attributes
    ----------
    drops : int
        Drops that are counted.
    bound : int
        Most drops that are wanted.
    unsettled : int
        Of those done.
    expected_error : float
        Of the drops so far, a fraction; NaN before one has settled.
    error_bound : float
        That the error over the poses keeps with 90 % confidence; infinite before one
        has settled.
    target_error : float
        0 where all drops are wanted.
    seconds : float
        Since the simulation began.
    statistics : callable
        Makes the `PoseStatistics` so far.
    """

    drops: int
    bound: int
    unsettled: int
    expected_error: float
    error_bound: float
    target_error: float
    seconds: float
    statistics: Callable[[], PoseStatistics]

    @property
    def rate(self) -> float:
        """Drops a second; NaN before the first."""
        return (
            self.drops / self.seconds if self.drops and self.seconds > 0.0 else math.nan
        )

    @property
    def seconds_left(self) -> float:
        """Expected time; the error falls as one over the root of the drops."""
        if not self.drops:
            return math.nan
        expected_drops = float(self.bound)
        if self.target_error > 0.0 and math.isfinite(self.error_bound):
            ratio = self.error_bound / self.target_error
            expected_drops = min(expected_drops, self.drops * ratio**2)
        return max(0.0, expected_drops - self.drops) / self.rate


@dataclass(frozen=True, eq=False)
class FlipStatistics:
    """The transition matrix of a kick, counted.

    Attributes
    ----------
    part_id, part_digest : str
    radius : float
        Largest distance from the centre of mass to a vertex, metres.
    restitution : float
    kick_height : float
        Energy of the kick over the weight, metres.
    cluster_tolerance : float
    round_sides : int
    poses : tuple of StablePose
        All K of them by `index`, without probabilities.
    counts : (K, K) array of int, or of float where the model's are among them
        Row i: flips out of pose i, by the pose in which they ended.
    effective_counts : (K, K) array
        Flips as which each row is known: those out of poses that a rotation or
        reflection of the part exchanges count for each other.
    unsettled : (K,) array of int
        Flips out of each pose that were given up.
    transition : (K, K) array
        Probability of pose j after a kick in pose i; a row sums to 1, or is NaN where
        nothing has settled.
    standard_error : (K, K) array
        Of `transition`; NaN where nothing has settled.
    seed : int
    seconds : float
    warnings : tuple of Note
    version : str
    feeder_setting : str
        Name of a setting of the cell's feeder whose flips are among them; empty: none.
    counted_flips : int
        Flips that were counted at that setting.
    """

    part_id: str
    part_digest: str
    radius: float
    restitution: float
    kick_height: float
    cluster_tolerance: float
    round_sides: int
    poses: tuple[StablePose, ...]
    counts: Index | Array
    effective_counts: Array
    unsettled: Index
    transition: Array
    standard_error: Array
    seed: int
    seconds: float
    warnings: tuple[Note, ...]
    version: str
    feeder_setting: str = ""
    counted_flips: int = 0

    @property
    def flips(self) -> int:
        """All of them, also those that were given up."""
        return int(self.counts.sum() + self.unsettled.sum())

    def as_dict(self) -> dict[str, Any]:
        """The flips as plain values, in the words of the JSON contract."""
        of_setting = ("feeder_setting", "counted_flips") if self.feeder_setting else ()
        return with_units(
            {
                name: getattr(self, name)
                for name in (
                    "part_id",
                    "part_digest",
                    "radius",
                    "restitution",
                    "kick_height",
                    "cluster_tolerance",
                    "round_sides",
                    "flips",
                    "seed",
                    "seconds",
                    "version",
                    *of_setting,
                    "warnings",
                    "counts",
                    "unsettled",
                    "transition",
                    "standard_error",
                )
            }
        )
