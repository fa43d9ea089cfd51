"""What a vision feeder is to do with a part, and what it gets: a plate whose parts move together.

Parts are dropped on an empty plate, a camera looks, and a robot picks the free ones that lie in
wanted poses. A kick throws all that is left anew, fresh parts take the place of those picked, and
after a number of kicks the plate is emptied. Only the mean over the parts is followed, which is
exact but for how the others lie that block one.
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
SIZES = 60
MOST_PARTS = 10_000  # numbers of parts that are looked at, and the largest of them
MOST_SIDE = 100.0  # of a plate, metres
FLIPS_ERROR = (
    0.17  # of rows of the model, rms over groups and kicks (docs/decisions.md)
)
PASSES = (
    2  # the first knows how dropped parts lie, the second how those on the plate do
)


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
    cycle_time, pick_time, camera_time, drop_time : float
        Seconds of a kick, of a picked part, of a picture, and until dropped parts lie still.
    """

    rate: float
    plate: tuple[float, float]
    clearance: float = 0.0
    cycle_time: float = 1.0
    pick_time: float = 1.0
    camera_time: float = 0.2
    drop_time: float = 0.5

    def check(self) -> None:
        """Raise RequestError if a number is out of its range."""
        feeding.check_rate(scene.real_number("rate", self.rate), self.cycle_time)
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
    )  # parts picked a minute; the interval has the plate's error in it
    feeder_speed: str = ""  # of a kick whose flips were counted in the cell


@dataclass(frozen=True)
class FeedingPlan:
    """What the cell is to do.

    Attributes
    ----------
    actions : tuple of str
        For each pose by its index: `pick` it where it is free; `flip`, for kicking a part that
        lies so gets it picked sooner than dropping another one; or `leave` it, for it does not.
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
    """Plan a cell: which poses to pick, how to kick, and how many parts to put on the plate.

    Parameters
    ----------
    dropped : PoseStatistics
        Of a part, by any method.
    wanted : sequence of int
        Indices of the poses that the robot picks, at least one.
    cell : FeederCell
    flips : sequence of FlipStatistics
        Of the same part and scene, one for each kick that the plate can give. Of those that a
        cell counted (`learn_flips`) the errors are their own, without the plate's.
    part : Part, optional
        The part, whose bays and holes let others in. Default: silhouettes count as convex, which
        tells too few free parts, of a hex bolt up to 8 % (docs/measured/benchmarks.md).

    Returns
    -------
    FeedingPlan

    Raises
    ------
    RequestError
        If a number is out of its range, there is no such pose, no dropped part comes to rest in a
        wanted one, flips out of a pose are missing, or results are of another part.
    """
    cell.check()
    feeding.check_alike([dropped, *flips])
    if part is not None and part.digest != dropped.part_digest:
        raise RequestError(
            "results of the part",
            f"those of {dropped.part_id}",
            "estimate the part that is given",
        )
    picked = feeding.check_wanted(wanted, len(dropped.poses)).astype(np.float64)
    shares = pose_groups.pose_shares(dropped)
    if not shares.probability @ picked > 0.0:
        raise RequestError(
            "wanted poses that dropped parts come to rest in",
            "none of them",
            "name others; `ros_pose_stats estimate` lists their probabilities",
        )
    poses = list(dropped.by_index.values())
    blocking = (
        1.0
        if part is None
        else plate_fill.blocking_with_bays(
            part, poses, shares.probability, np.flatnonzero(picked), cell.clearance
        )
    )
    plate = Plate(
        cell,
        picked,
        shares,
        poses,
        0.0 if dropped.observed else dropped.plate_error,
        blocking,
    )
    kicks = [None, *sorted(flips, key=lambda kick: kick.kick_height)]
    options = [plate.plan(kick) for kick in kicks]
    place = max(range(len(options)), key=lambda at: options[at].per_minute.value)
    best = options[place]
    chosen = kicks[place]
    actions = np.full(picked.size, LEAVE)
    if chosen is not None and best.kicks:
        actions[plate.worth_flipping(best.parts, chosen.transition)] = FLIP
    actions[picked > 0.0] = PICK
    return FeedingPlan(tuple(actions.tolist()), best, tuple(options))


@dataclass(frozen=True, eq=False)
class Plate:
    """Parts that lie on the plate of a cell."""

    cell: FeederCell
    picked: Array  # (K,); 1 where the robot picks parts in a pose, else 0
    dropped: pose_groups.PoseShares
    poses: Sequence[StablePose]  # by their index
    plate_error: (
        float  # of the shares on a real plate, beside that of the model; a fraction
    )
    # (K,); of the area in which convex silhouettes would block a part, the share in which it is,
    # among parts that were dropped
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

    def plan(self, kick: FlipStatistics | None, most: int = MOST_KICKS) -> KickPlan:
        """The best numbers of parts and of kicks, at most `most`, and what they give."""
        moves = np.zeros((0, 0)) if kick is None else kick.transition
        if kick is not None and not (settled := kick.counts.sum(axis=1)).all():
            raise RequestError(
                "flips counted out of every pose",
                f"none out of pose {int(np.argmin(settled))}",
                "simulate more flips",
            )
        fresh = self.dropped.probability
        shares = self.dropped.probability
        for _ in range(PASSES):
            room = self.fill(shares)
            largest = min(MOST_PARTS, 2.0 + 2.0 / float(room.blocked.mean()))
            parts = np.unique(np.geomspace(1.0, largest, SIZES).astype(int))
            seen = self.picked * room.free(parts)
            lying = [np.tile(fresh, (len(parts), 1))]
            for _ in range(most if kick is not None else 0):
                taken = lying[-1] * seen
                refill = taken.sum(axis=1, keepdims=True) * fresh
                lying.append((lying[-1] - taken) @ moves + refill)
            pictures = np.array(lying)  # (kicks + 1, N, K)
            picks = parts[:, None] * (pictures * seen).sum(axis=2).T
            rates = self._rates(parts, picks)
            at, kicks = np.unravel_index(int(rates.argmax()), rates.shape)
            shares = pictures[: kicks + 1, at].mean(axis=0)
        chain = pictures[: kicks + 1, at]
        spread = feeding.spread_of(self._picks_error(chain, seen[at], kick))
        # No picture shows more than all parts in the pose that is blocked least.
        around = np.minimum(
            np.outer((1.0, 1.0 / spread, spread), picks[at]), parts[at] * seen[at].max()
        )
        rate = feeding.Bounded(
            *self._rates(parts[[at, at, at]], around)[:, kicks].tolist()
        )
        return KickPlan(
            0.0 if kick is None else kick.kick_height,
            int(parts[at]),
            int(kicks),
            float(picks[at, 0]),
            rate,
            "" if kick is None else kick.feeder_speed,
        )

    def _rates(self, parts: Index, picks: Array) -> Array:
        """Parts picked a minute (N, R) by the picks (N, R) after 0, 1 ... kicks."""
        cell = self.cell
        kicks = np.arange(picks.shape[1])
        total = picks.cumsum(axis=1)
        refilled = parts[:, None] + total - picks
        seconds = (
            (kicks + 1.0) * (cell.drop_time + cell.camera_time)
            + kicks * cell.cycle_time
            + 60.0 / cell.rate * refilled
            + cell.pick_time * total
        )
        return np.asarray(60.0 * total / seconds)

    def _picks_error(
        self, lying: Array, seen: Array, kick: FlipStatistics | None
    ) -> float:
        """Relative standard error of the parts that a cycle picks.

        To first order in the shares of dropped parts and in the rows of the moves, each off by
        its own counts and by the error of the plate or of its flips. `lying` (R + 1, K): how parts
        lie at each picture.
        """
        fresh = self.dropped.probability
        picks = float((lying @ seen).sum())
        counted = self.drops_as_unsure(fresh, self.dropped.drops, self.plate_error)
        if kick is None:
            return (
                math.sqrt(
                    mean_variance(
                        self.dropped.shares, self.dropped.by_unit(seen), counted
                    )
                )
                / picks
            )
        moves = kick.transition
        left = 1.0 - seen
        worth = [
            seen
        ]  # of a part that lies so at a picture: picks until the cycle's end
        for _ in lying[1:]:
            worth.append(seen + left * (moves @ worth[-1]) + seen * (fresh @ worth[-1]))
        after = np.array(worth[-2::-1]).reshape(-1, seen.size)
        gain = worth[-1] + (lying[:-1] @ seen) @ after
        variance = mean_variance(
            self.dropped.shares, self.dropped.by_unit(gain), counted
        )
        row_gain = (lying[:-1] * left).T @ after
        for row, values, flips in zip(
            moves, row_gain, kick.counts.sum(axis=1).tolist(), strict=True
        ):
            drops = (
                flips
                if kick.observed
                else self.drops_as_unsure(row, flips, FLIPS_ERROR)
            )
            variance += mean_variance(row, values, drops)
        return math.sqrt(variance) / picks

    def drops_as_unsure(self, shares: Array, counted: float, error: float) -> float:
        """Drops that leave shares (K,) as uncertain as if counted so, and off in each group."""
        groups = np.bincount([pose.group for pose in self.poses], shares).astype(
            np.float64
        )
        inverse = 1.0 / counted + 1.0 / pose_groups.equivalent_drops(
            groups, np.full(groups.size, error)
        )
        return 1.0 / inverse if inverse else math.inf

    def worth_flipping(self, parts: int, moves: Array) -> Index:
        """The poses in which a kick gets a part picked sooner than dropping another one does.

        By policy iteration over the seconds of the cell that each part takes, of which those on
        the plate share kicks and pictures; it ends where value iteration would.
        """
        cell = self.cell
        fresh = self.dropped.probability
        seen = self.picked * self.fill(fresh).free(np.array([parts]))[0]
        kick = (cell.cycle_time + cell.drop_time + cell.camera_time) / parts
        drop = 60.0 / cell.rate + (cell.drop_time + cell.camera_time) / parts
        flips = np.zeros(seen.size, dtype=np.bool_)
        while True:
            rows = np.where(flips[:, None], moves, fresh) * (1.0 - seen)[:, None]
            seconds = np.linalg.solve(
                np.eye(seen.size) - rows,
                seen * cell.pick_time + (1.0 - seen) * np.where(flips, kick, drop),
            )
            sooner = kick + moves @ seconds < (drop + fresh @ seconds) * (1.0 - 1e-12)
            if (sooner == flips).all():
                return np.flatnonzero(flips)
            flips = sooner


def mean_variance(shares: Array, values: Array, drops: float) -> float:
    """Variance of the mean of values (K,) over so many drops that end by these shares.

    Half a drop is spread over all: that none ended elsewhere yet does not make it certain.
    """
    half = 0.5 / drops
    smooth = (shares + half / shares.size) / (1.0 + half)
    return max(0.0, float(smooth @ (values - smooth @ values) ** 2)) / drops
