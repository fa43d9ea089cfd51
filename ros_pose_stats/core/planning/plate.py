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

"""What a plate of parts gives, where all that are not picked are kicked together.

Parts are dropped on an empty plate, a camera looks, and a robot picks the free ones
that lie in wanted poses. A kick throws all that is left anew, fresh parts take the
place of those picked, and after a number of kicks the plate is emptied. Only the mean
over the parts is followed, which is exact but for how the others lie that block one.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..records import Array, FlipStatistics, Index
from ..statistics import feeding
from . import plate_fill
from .feeder_cell import Feeder, KickPlan, faster_by_kick, mean_variance

MOST_KICKS = 100  # kicks between two empty plates; more of them are worth hardly more
PART_NUMBERS = 60
MOST_PARTS = 10_000  # numbers of parts that are looked at, and the largest of them
SHARE_PASSES = 2
"""The first knows how dropped parts lie, the second how those on the plate do."""


@dataclass(frozen=True, eq=False)
class Plate(Feeder):
    """Parts that lie on the plate of a cell."""

    # (K,); of the area in which convex silhouettes would block a part, the share in
    # which it is, among parts that were dropped
    blocking: Array | float = 1.0

    def fill(self, shares: Array) -> plate_fill.PlateFill:
        """Room among parts that lie in these shares."""
        assert self.cell.plate is not None
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
        flips_known: list[float] = []
        transition: Array = np.zeros((0, 0))
        if kick is None:
            most_kicks = 0
        else:
            flips_known = self.flips_known(kick)
            transition = kick.transition
        cycle = self._best_cycle(transition, most_kicks)
        parts, kicks = cycle.parts, cycle.kicks
        error = self._picks_error(cycle, transition, flips_known)
        # No picture shows more than all parts in the pose that is blocked least.
        picks_range = np.minimum(
            np.outer((1.0, *feeding.relative_bounds(error)), cycle.picks),
            parts * cycle.pick_chance.max(),
        )
        parts_range = np.full(3, parts)
        right_range = picks_range * np.divide(
            cycle.right_picks,
            cycle.picks,
            out=np.zeros(kicks + 1),
            where=cycle.picks > 0.0,
        )
        rates = self._rates(parts_range, picks_range, right_range)[:, -1]
        total = right_range.sum(axis=1)
        shares = total / _dropped(parts_range, picks_range)[:, -1]
        accepted = feeding.Bounded(*shares.tolist())
        flips = feeding.NO_FLIPS
        if kicks:
            thrown = kicks * parts - picks_range[:, :-1].sum(axis=1)
            with np.errstate(divide="ignore"):  # maybe nothing is picked
                middle, most, least = (thrown / total).tolist()
            flips = feeding.Bounded(middle, least, most)
        return KickPlan(
            0.0 if kick is None else kick.kick_height,
            parts,
            kicks,
            float(cycle.right_picks[0]),
            accepted,
            feeding.passes_of(*accepted),
            flips,
            feeding.Bounded(*rates.tolist()),
            "" if kick is None else kick.feeder_setting,
        )

    def _best_cycle(self, transition: Array, most_kicks: int) -> "_Cycle":
        """The cycle with the numbers of parts and kicks that give most a minute."""
        shares = self.dropped.probability
        for _ in range(SHARE_PASSES):
            room = self.fill(shares)
            largest = min(MOST_PARTS, 2.0 + 2.0 / float(room.blocked.mean()))
            parts = np.unique(np.geomspace(1.0, largest, PART_NUMBERS).astype(int))
            pick_chance = self.pick_mask * room.free_probability(parts)
            pictures = self._pictures(pick_chance, transition, most_kicks)
            picks = parts[:, None] * (pictures * pick_chance).sum(axis=2).T
            right_chance = pick_chance * self.pick_worth
            right_picks = parts[:, None] * (pictures * right_chance).sum(axis=2).T
            rates = self._rates(parts, picks, right_picks)
            row, kicks = map(int, np.unravel_index(int(rates.argmax()), rates.shape))
            shares = pictures[: kicks + 1, row].mean(axis=0)
        return _Cycle(
            int(parts[row]),
            kicks,
            pictures[: kicks + 1, row],
            pick_chance[row],
            picks[row, : kicks + 1],
            right_picks[row, : kicks + 1],
        )

    def _pictures(
        self, pick_chance: Array, transition: Array, most_kicks: int
    ) -> Array:
        """How parts lie (R + 1, N, K) after 0, 1 ... kicks, by chances of a pick."""
        dropped_shares = self.dropped.probability
        pictures = [np.tile(dropped_shares, (len(pick_chance), 1))]
        for _ in range(most_kicks):
            pose_picks = pictures[-1] * pick_chance
            refill = pose_picks.sum(axis=1, keepdims=True) * dropped_shares
            pictures.append((pictures[-1] - pose_picks) @ transition + refill)
        return np.array(pictures)

    def _rates(self, parts: Index, picks: Array, right_picks: Array) -> Array:
        """Parts rightly picked a minute (N, R) by picks (N, R) after 0, 1 ... kicks."""
        cell = self.cell
        kicks = np.arange(picks.shape[1])
        total = picks.cumsum(axis=1)
        seconds = (
            (kicks + 1.0) * (cell.drop_seconds + cell.look_seconds)
            + kicks * cell.cycle_seconds
            + 60.0 / cell.rate * _dropped(parts, picks)
            + cell.pick_seconds * total
        )
        return np.asarray(60.0 * right_picks.cumsum(axis=1) / seconds)

    def _picks_error(
        self, cycle: "_Cycle", transition: Array, flips_known: list[float]
    ) -> float:
        """Relative standard error of the parts that a cycle rightly picks.

        To first order in the shares of dropped parts and in the rows of the moves, each
        off by its own counts and by the error of the plate or of its flips.
        `flips_known`: of the rows, none without a kick.
        """
        landed = self.landed
        picture_shares = cycle.picture_shares
        pick_chance = cycle.pick_chance
        right_chance = pick_chance * self.pick_worth
        picks = float((picture_shares @ right_chance).sum())
        stay_chance = 1.0 - pick_chance
        # Of a part that lies so at a picture: right picks until the cycle's end.
        worth = [right_chance]
        for _ in picture_shares[1:]:
            worth.append(
                right_chance
                + stay_chance * (transition @ worth[-1])
                + pick_chance * (landed.probability @ worth[-1])
            )
        later_worth = np.array(worth[-2::-1]).reshape(-1, pick_chance.size)
        gain = worth[-1] + (picture_shares[:-1] @ pick_chance) @ later_worth
        variance = mean_variance(landed.shares, landed.by_unit(gain), landed.drops)
        row_gain = (picture_shares[:-1] * stay_chance).T @ later_worth
        for row, values, flips in zip(transition, row_gain, flips_known, strict=False):
            variance += mean_variance(row, values, flips)
        return math.sqrt(variance) / picks

    def poses_worth_flipping(self, parts: int, transition: Array) -> Index:
        """Poses in which a kick gets a part picked sooner than a new drop does.

        Parts on the plate share kicks and pictures.
        """
        cell = self.cell
        room = self.fill(self.dropped.probability)
        settling_seconds = cell.drop_seconds + cell.look_seconds
        return np.flatnonzero(
            faster_by_kick(
                self.right_mask * room.free_probability(np.array([parts]))[0],
                self.dropped.probability,
                transition,
                (cell.cycle_seconds + settling_seconds) / parts,
                60.0 / cell.rate + settling_seconds / parts,
                self.can_flip,
            )
        )


class _Cycle(NamedTuple):
    """What is on the plate from one emptying to the next, on average."""

    parts: int
    kicks: int
    picture_shares: Array  # (R + 1, K); how parts lie at each picture
    pick_chance: Array  # (K,); of a part in a pose
    picks: Array  # (R + 1,); parts that are picked by each picture
    right_picks: Array  # (R + 1,); those of them in a wanted pose


def _dropped(parts: Index, picks: Array) -> Array:
    """Parts dropped (N, R) until the picture after 0, 1 ... kicks, as `_rates`."""
    return np.asarray(parts[:, None] + picks.cumsum(axis=1) - picks)
