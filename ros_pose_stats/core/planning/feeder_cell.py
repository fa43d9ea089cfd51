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

"""A feeder's cell: hopper, plate under a camera, robot; or parts that come singly."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from ...base import text
from ...base.errors import RequestError
from ..records import Array, FlipStatistics, Mask, StablePose, scene
from ..simulation.flips import usual_kicks
from ..statistics import feeding, pose_groups

MOST_SIDE = 100.0  # of a plate, metres
FLIPS_ERROR = 0.17
"""Of rows of the model, rms over groups and kicks (docs/decisions.md)."""

SOONER = 1.0 - 1e-12  # by more than rounding


@dataclass(frozen=True)
class FeederCell:
    """A cell in which a robot, or a gate, takes parts in wanted poses.

    On a plate under a camera a robot picks one part after the other, all others are
    kicked together, and fresh ones take the place of those picked. Without a plate
    parts come singly: one that lies wrong is kicked where it lies or dropped again.

    Attributes
    ----------
    rate : float
        Parts that are dropped a minute, above 0.
    plate : (float, float), optional
        Sides of the area over which the centres of the parts spread, metres. Default:
        none, parts come singly; a dropped one then takes 60 / `rate` seconds with all
        that is done to it but kicks.
    clearance : float
        Room that the gripper needs around a part's silhouette on a plate, metres.
    cycle_seconds, pick_seconds, look_seconds, drop_seconds : float
        Seconds of a kick; and on a plate those of a picked part, of a picture, and
        until dropped parts lie still.
    """

    rate: float
    plate: tuple[float, float] | None = None
    clearance: float = 0.0
    cycle_seconds: float = 1.0
    pick_seconds: float = 1.0
    look_seconds: float = 0.2
    drop_seconds: float = 0.5

    def check(self) -> None:
        """Raise RequestError if a number is out of its range."""
        feeding.check_rate(scene.real_number("rate", self.rate), self.cycle_seconds)
        if self.plate is not None and (
            np.shape(self.plate) != (2,)
            or not all(
                0.0 < scene.real_number("plate", side) < MOST_SIDE
                for side in self.plate
            )
        ):
            raise RequestError(
                f"a plate with sides above 0 m, two below {MOST_SIDE:g} m",
                f"{self.plate}",
                "measure where the centres of parts come to rest",
            )
        for field in fields(self)[2:]:
            if (
                not 0.0
                <= scene.real_number(field.name, getattr(self, field.name))
                < np.inf
            ):
                raise RequestError(
                    f"a {field.name} of 0 or more",
                    f"{getattr(self, field.name)}",
                    "in metres or seconds",
                )

    def kick_heights(
        self, radius: float, named: Sequence[float] | None, has_kicker: bool = False
    ) -> tuple[float, ...]:
        """Kicks to plan with, metres: those named, else the usual ones.

        `radius`: of the part, metres; `has_kicker`: whether flips were counted in the
        cell, or it gives some kick now. Where parts come singly nothing else kicks
        them.
        """
        if named is not None:
            return tuple(named)
        return usual_kicks(radius) if self.plate is not None or has_kicker else ()

    def describe_plate(self) -> str:
        """The plate in words, or that there is none."""
        if self.plate is None:
            return "parts come singly, no plate"
        length, width = map(text.millimetres, self.plate)
        return f"{length} × {width} mm plate"


class KickPlan(NamedTuple):
    """The best that the cell gets with one kick."""

    kick_height: float  # metres; 0 without one
    parts: int  # on the plate at each picture; 0 without a plate
    kicks: int  # from one empty plate to the next; 0 without a plate
    pickable: float  # parts that the first picture shows free in wanted poses
    # The intervals have the errors of the plate and of the flips in them.
    accepted: feeding.Bounded  # share of the dropped parts that are picked
    passes: feeding.Bounded  # drops that a picked part took
    flips: feeding.Bounded  # flips that a picked part took, of others on its way too
    per_minute: feeding.Bounded  # parts picked
    feeder_setting: str = ""  # of a kick whose flips were counted in the cell

    @property
    def is_kicking(self) -> bool:
        """Whether parts are kicked at all: a kick may be worth nothing."""
        return self.flips.value != 0.0

    @property
    def name(self) -> str:
        """Of the kick, by the feeder's setting or its height."""
        if self.feeder_setting:
            return f"setting {self.feeder_setting}"
        return f"a kick of {text.length_in_words(self.kick_height)}"

    def describe_kick(self) -> str:
        """By which setting of the feeder or how high parts are kicked."""
        if not self.is_kicking:
            return "not kicked"
        if self.feeder_setting:
            return f"at setting {self.feeder_setting}"
        return f"kicked by {text.length_in_words(self.kick_height)}"


def describe_cell(cell: FeederCell, plan: KickPlan) -> str:
    """What the cell does by a plan, in a line."""
    if cell.plate is None:
        return cell.describe_plate()
    others = "all others are kicked together"
    if not plan.is_kicking:
        others = "the plate is emptied of the others"
    return (
        f"robot picks one part at a time, {others}; {cell.describe_plate()}, "
        f"{text.several(plan.parts, 'part')}"
    )


@dataclass(frozen=True, eq=False)
class Feeder:
    """A part in a cell: what both kinds of cells know of it."""

    cell: FeederCell
    pick_mask: Array  # (K,); 1 where the robot picks parts in a pose, else 0
    dropped: pose_groups.PoseShares
    poses: Sequence[StablePose]  # by their index
    # of the shares on a real plate, beside that of the model; a fraction
    plate_error: float
    # (K,); of a pick in each pose: 0 where the camera takes it for a wanted one
    pick_worth: Array | float = 1.0

    @property
    def right_mask(self) -> Array:
        """1 (K,) where a pick is a right one, else 0."""
        return np.asarray(self.pick_mask * self.pick_worth)

    @property
    def can_flip(self) -> Mask:
        """Poses (K,) in which a part may be kicked: those that are not mistaken."""
        return np.asarray(self.pick_mask == self.right_mask)

    @property
    def landed(self) -> pose_groups.PoseShares:
        """The shares of dropped parts, as uncertain as they are on a real plate."""
        shares = self.dropped
        return shares._replace(
            drops=self.equivalent_drops(
                shares.probability, shares.drops, self.plate_error
            )
        )

    def flips_known(self, kick: FlipStatistics) -> list[float]:
        """Flips whose counts would be as uncertain as each row of a kick."""
        counts = kick.effective_counts.sum(axis=1)
        if not counts.all():
            raise RequestError(
                "flips counted out of every pose",
                f"none out of pose {int(np.argmin(counts))}",
                "simulate more flips",
            )
        if kick.counted_flips:
            return list(counts.tolist())
        return [
            self.equivalent_drops(row, flips, FLIPS_ERROR)
            for row, flips in zip(kick.transition, counts.tolist(), strict=True)
        ]

    def equivalent_drops(self, shares: Array, drops: float, error: float) -> float:
        """Drops whose counts are as uncertain as shares (K,) that are off as well."""
        groups = np.bincount([pose.group for pose in self.poses], shares).astype(float)
        error_drops = pose_groups.equivalent_drops(groups, np.full(groups.size, error))
        inverse = 1.0 / drops + 1.0 / error_drops
        return 1.0 / inverse if inverse else math.inf


def faster_by_kick(
    pick_chance: Array,
    dropped_shares: Array,
    transition: Array,
    kick_seconds: float,
    drop_seconds: float,
    can_flip: Mask,
) -> Mask:
    """Poses (K,) in which a kick gets a part picked sooner than a new drop does.

    `pick_chance` (K,): that a part in each pose is rightly picked; else it is kicked,
    where it `can_flip`, or another one is dropped. By policy iteration over the seconds
    of the cell that a part takes; it ends where value iteration would.
    """
    miss_chance = 1.0 - pick_chance
    flips: Mask = np.zeros(pick_chance.size, dtype=np.bool_)
    while True:
        next_shares = np.where(flips[:, None], transition, dropped_shares)
        step_seconds = np.where(flips, kick_seconds, drop_seconds)
        seconds = np.linalg.solve(
            np.eye(pick_chance.size) - next_shares * miss_chance[:, None],
            miss_chance * step_seconds,
        )
        by_kick = kick_seconds + transition @ seconds
        by_drop = drop_seconds + dropped_shares @ seconds
        is_sooner = can_flip & (by_kick < by_drop * SOONER)
        if (is_sooner == flips).all():
            return flips
        flips = np.asarray(is_sooner)


def mean_variance(shares: Array, values: Array, drops: float) -> float:
    """Variance of the mean of values (K,) over so many drops that end by these shares.

    Half a drop is spread over all: that none ended elsewhere yet does not make it
    certain.
    """
    half_drop = 0.5 / drops
    smoothed_shares = (shares + half_drop / shares.size) / (1.0 + half_drop)
    mean = smoothed_shares @ values
    return max(0.0, float(smoothed_shares @ (values - mean) ** 2)) / drops
