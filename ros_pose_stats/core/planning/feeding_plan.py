"""What a vision feeder is to do with a part, and what it gets.

Parts are dropped on an empty plate, a camera looks, and a robot picks the free ones
that lie in wanted poses. A kick throws all that is left anew, fresh parts take the
place of those picked, and after a number of kicks the plate is emptied. Only the mean
over the parts is followed, which is exact but for how the others lie that block one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import RequestError
from ..records import (
    Array,
    FlipStatistics,
    Index,
    Part,
    PoseStatistics,
    StablePose,
    scene,
)
from ..records.plain_values import with_units
from ..statistics import feeding, pose_groups
from . import plate_fill

PICK = "pick"
FLIP = "flip"
LEAVE = "leave"
MOST_KICKS = 100  # kicks between two empty plates; more of them are worth hardly more
PART_NUMBERS = 60
MOST_PARTS = 10_000  # numbers of parts that are looked at, and the largest of them
MOST_SIDE = 100.0  # of a plate, metres
FLIPS_ERROR = 0.17
"""Of rows of the model, rms over groups and kicks (docs/decisions.md)."""
SHARE_PASSES = 2
"""The first knows how dropped parts lie, the second how those on the plate do."""


@dataclass(frozen=True)
class FeederCell:
    """A plate under a camera, its hopper, and a robot.

    Attributes
    ----------
    rate : float
        Parts that the hopper drops a minute, above 0.
    plate : (float, float)
        Sides of the area over which the centres of the parts spread, metres.
    clearance : float
        Room that the gripper needs around a part's silhouette, metres.
    cycle_seconds, pick_seconds, look_seconds, drop_seconds : float
        Seconds of a kick, of a picked part, of a picture, and until dropped parts lie
        still.
    """

    rate: float
    plate: tuple[float, float]
    clearance: float = 0.0
    cycle_seconds: float = 1.0
    pick_seconds: float = 1.0
    look_seconds: float = 0.2
    drop_seconds: float = 0.5

    def check(self) -> None:
        """Raise RequestError if a number is out of its range."""
        feeding.check_rate(scene.real_number("rate", self.rate), self.cycle_seconds)
        if np.shape(self.plate) != (2,) or not all(
            0.0 < scene.real_number("plate", side) < MOST_SIDE for side in self.plate
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


class KickPlan(NamedTuple):
    """The best that the cell gets with one kick."""

    kick_height: float  # metres; 0 where the plate is not kicked
    parts: int  # on the plate at each picture
    kicks: int  # from one empty plate to the next
    pickable: float  # parts that the first picture shows free in wanted poses
    per_minute: (
        feeding.Bounded
    )  # parts picked; its interval has the plate's error in it
    feeder_setting: str = ""  # of a kick whose flips were counted in the cell


@dataclass(frozen=True)
class FeedingPlan:
    """What the cell is to do.

    Attributes
    ----------
    actions : tuple of str
        For each pose by its index: `pick` it where it is free; `flip`, for kicking a
        part that lies so gets it picked sooner than dropping another one; or `leave`
        it, for it does not.
    best : KickPlan
        The kick, the number of parts and the kicks to use.
    options : tuple of KickPlan
        Without kicks, and with each kick by its height.
    """

    actions: tuple[str, ...]
    best: KickPlan
    options: tuple[KickPlan, ...]

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain values."""
        return with_units(
            {"actions": self.actions, "options": self.options, **self.best._asdict()}
        )


def plan_feeding(
    dropped: PoseStatistics,
    wanted: Sequence[int],
    cell: FeederCell,
    flips: Sequence[FlipStatistics] = (),
    part: Part | None = None,
) -> FeedingPlan:
    """Plan a cell: poses to pick, how to kick, and how many parts to put on it.

    Parameters
    ----------
    dropped : PoseStatistics
        Of a part, by any method.
    wanted : sequence of int
        Indices of the poses that the robot picks, at least one.
    cell : FeederCell
    flips : sequence of FlipStatistics
        Of the same part and scene, one for each kick that the plate can give. Of those
        that a cell counted (`learn_flips`) the errors are their own, without the
        plate's.
    part : Part, optional
        The part, whose bays and holes let others in. Default: silhouettes count as
        convex, which tells too few free parts, of a hex bolt up to 8 %
        (docs/measured/benchmarks.md).

    Returns
    -------
    FeedingPlan

    Raises
    ------
    RequestError
        If a number is out of its range, there is no such pose, no dropped part comes to
        rest in a wanted one, flips out of a pose are missing, or results are of another
        part.
    """
    cell.check()
    feeding.check_alike([dropped, *flips])
    if part is not None and part.digest != dropped.part_digest:
        raise RequestError(
            "results of the part",
            f"those of {dropped.part_id}",
            "estimate the part that is given",
        )
    is_wanted = feeding.check_wanted_poses(wanted, len(dropped.poses))
    pick_mask = is_wanted.astype(np.float64)
    shares = pose_groups.pose_shares(dropped)
    if not shares.probability @ pick_mask > 0.0:
        raise RequestError(
            "wanted poses that dropped parts come to rest in",
            "none of them",
            "name others; `ros_pose_stats estimate` lists their probabilities",
        )
    poses = list(dropped.by_index.values())
    blocking: Array | float = 1.0
    if part is not None:
        blocking = plate_fill.blocking_with_bays(
            part, poses, shares.probability, np.flatnonzero(is_wanted), cell.clearance
        )
    plate = Plate(
        cell,
        pick_mask,
        shares,
        poses,
        0.0 if dropped.counted_parts else dropped.plate_error,
        blocking,
    )
    kicks = [None, *sorted(flips, key=lambda kick: kick.kick_height)]
    options = [plate.plan(kick) for kick in kicks]
    best, kick = max(
        zip(options, kicks, strict=True), key=lambda pair: pair[0].per_minute.value
    )
    actions = np.full(pick_mask.size, LEAVE)
    if kick is not None and best.kicks:
        actions[plate.poses_worth_flipping(best.parts, kick.transition)] = FLIP
    actions[is_wanted] = PICK
    return FeedingPlan(tuple(actions.tolist()), best, tuple(options))


@dataclass(frozen=True, eq=False)
class Plate:
    """Parts that lie on the plate of a cell."""

    cell: FeederCell
    pick_mask: Array  # (K,); 1 where the robot picks parts in a pose, else 0
    dropped: pose_groups.PoseShares
    poses: Sequence[StablePose]  # by their index
    # of the shares on a real plate, beside that of the model; a fraction
    plate_error: float
    # (K,); of the area in which convex silhouettes would block a part, the share in
    # which it is, among parts that were dropped
    blocking: Array | float = 1.0

    def fill(self, shares: Array) -> plate_fill.PlateFill:
        """Room among parts that lie in these shares."""
        return plate_fill.plate_fill(
            [pose.outline for pose in self.poses],
            shares,
            self.cell.plate,
            self.cell.clearance,
            self.blocking,
        )

    def plan(
        self, kick: FlipStatistics | None, most_kicks: int = MOST_KICKS
    ) -> KickPlan:
        """The best numbers of parts and of kicks, and what they give."""
        if kick is None:
            transition: Array = np.zeros((0, 0))
            most_kicks = 0
        else:
            transition = kick.transition
            settled_flips = kick.effective_counts.sum(axis=1)
            if not settled_flips.all():
                raise RequestError(
                    "flips counted out of every pose",
                    f"none out of pose {int(np.argmin(settled_flips))}",
                    "simulate more flips",
                )

        dropped_shares = self.dropped.probability
        shares = self.dropped.probability
        for _ in range(SHARE_PASSES):
            room = self.fill(shares)
            largest = min(MOST_PARTS, 2.0 + 2.0 / float(room.blocked.mean()))
            parts = np.unique(np.geomspace(1.0, largest, PART_NUMBERS).astype(int))
            pick_chance = self.pick_mask * room.free_probability(parts)
            picture_shares = [np.tile(dropped_shares, (len(parts), 1))]
            for _ in range(most_kicks):
                pose_picks = picture_shares[-1] * pick_chance
                refill = pose_picks.sum(axis=1, keepdims=True) * dropped_shares
                picture_shares.append(
                    (picture_shares[-1] - pose_picks) @ transition + refill
                )
            pictures = np.array(picture_shares)  # (kicks + 1, N, K)
            picks = parts[:, None] * (pictures * pick_chance).sum(axis=2).T
            rates = self._rates(parts, picks)
            row, kicks = np.unravel_index(int(rates.argmax()), rates.shape)
            shares = pictures[: kicks + 1, row].mean(axis=0)

        chain = pictures[: kicks + 1, row]
        spread = feeding.spread_of(self._picks_error(chain, pick_chance[row], kick))
        # No picture shows more than all parts in the pose that is blocked least.
        picks_range = np.minimum(
            np.outer((1.0, 1.0 / spread, spread), picks[row]),
            parts[row] * pick_chance[row].max(),
        )
        range_rates = self._rates(parts[[row, row, row]], picks_range)
        rate = feeding.Bounded(*range_rates[:, kicks].tolist())
        return KickPlan(
            0.0 if kick is None else kick.kick_height,
            int(parts[row]),
            int(kicks),
            float(picks[row, 0]),
            rate,
            "" if kick is None else kick.feeder_setting,
        )

    def _rates(self, parts: Index, picks: Array) -> Array:
        """Parts picked a minute (N, R) by the picks (N, R) after 0, 1 ... kicks."""
        cell = self.cell
        kicks = np.arange(picks.shape[1])
        total = picks.cumsum(axis=1)
        refilled = parts[:, None] + total - picks
        seconds = (
            (kicks + 1.0) * (cell.drop_seconds + cell.look_seconds)
            + kicks * cell.cycle_seconds
            + 60.0 / cell.rate * refilled
            + cell.pick_seconds * total
        )
        return np.asarray(60.0 * total / seconds)

    def _picks_error(
        self, picture_shares: Array, pick_chance: Array, kick: FlipStatistics | None
    ) -> float:
        """Relative standard error of the parts that a cycle picks.

        To first order in the shares of dropped parts and in the rows of the moves, each
        off by its own counts and by the error of the plate or of its flips.
        `picture_shares` (R + 1, K): how parts lie at each picture.
        """
        dropped_shares = self.dropped.probability
        picks = float((picture_shares @ pick_chance).sum())
        shares_worth = self.equivalent_drops(
            dropped_shares, self.dropped.drops, self.plate_error
        )
        if kick is None:
            unit_chance = self.dropped.by_unit(pick_chance)
            variance = mean_variance(self.dropped.shares, unit_chance, shares_worth)
            return math.sqrt(variance) / picks

        transition = kick.transition
        stay_chance = 1.0 - pick_chance
        # Of a part that lies so at a picture: picks until the cycle's end.
        worth = [pick_chance]
        for _ in picture_shares[1:]:
            worth.append(
                pick_chance
                + stay_chance * (transition @ worth[-1])
                + pick_chance * (dropped_shares @ worth[-1])
            )
        later_worth = np.array(worth[-2::-1]).reshape(-1, pick_chance.size)
        gain = worth[-1] + (picture_shares[:-1] @ pick_chance) @ later_worth
        variance = mean_variance(
            self.dropped.shares, self.dropped.by_unit(gain), shares_worth
        )
        row_gain = (picture_shares[:-1] * stay_chance).T @ later_worth
        for row, values, flips in zip(
            transition,
            row_gain,
            kick.effective_counts.sum(axis=1).tolist(),
            strict=True,
        ):
            drops = (
                flips
                if kick.counted_flips
                else self.equivalent_drops(row, flips, FLIPS_ERROR)
            )
            variance += mean_variance(row, values, drops)
        return math.sqrt(variance) / picks

    def equivalent_drops(self, shares: Array, drops: float, error: float) -> float:
        """Drops whose counts are as uncertain as shares (K,) that are off as well."""
        groups = np.bincount([pose.group for pose in self.poses], shares).astype(float)
        error_drops = pose_groups.equivalent_drops(groups, np.full(groups.size, error))
        inverse = 1.0 / drops + 1.0 / error_drops
        return 1.0 / inverse if inverse else math.inf

    def poses_worth_flipping(self, parts: int, transition: Array) -> Index:
        """Poses in which a kick gets a part picked sooner than a new drop does.

        By policy iteration over the seconds of the cell that each part takes, of which
        those on the plate share kicks and pictures; it ends where value iteration
        would.
        """
        cell = self.cell
        dropped_shares = self.dropped.probability
        room = self.fill(dropped_shares)
        pick_chance = self.pick_mask * room.free_probability(np.array([parts]))[0]
        miss_chance = 1.0 - pick_chance
        kick_seconds = (
            cell.cycle_seconds + cell.drop_seconds + cell.look_seconds
        ) / parts
        drop_seconds = (
            60.0 / cell.rate + (cell.drop_seconds + cell.look_seconds) / parts
        )
        flips = np.zeros(pick_chance.size, dtype=np.bool_)
        while True:
            next_shares = np.where(flips[:, None], transition, dropped_shares)
            step_seconds = np.where(flips, kick_seconds, drop_seconds)
            seconds = np.linalg.solve(
                np.eye(pick_chance.size) - next_shares * miss_chance[:, None],
                pick_chance * cell.pick_seconds + miss_chance * step_seconds,
            )
            by_kick = kick_seconds + transition @ seconds
            by_drop = drop_seconds + dropped_shares @ seconds
            is_sooner = by_kick < by_drop * (1.0 - 1e-12)
            if (is_sooner == flips).all():
                return np.flatnonzero(flips)
            flips = is_sooner


def mean_variance(shares: Array, values: Array, drops: float) -> float:
    """Variance of the mean of values (K,) over so many drops that end by these shares.

    Half a drop is spread over all: that none ended elsewhere yet does not make it
    certain.
    """
    half_drop = 0.5 / drops
    smoothed_shares = (shares + half_drop / shares.size) / (1.0 + half_drop)
    mean = smoothed_shares @ values
    return max(0.0, float(smoothed_shares @ (values - mean) ** 2)) / drops
