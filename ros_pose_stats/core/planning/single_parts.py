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

"""What parts give that come singly, each kicked or dropped again where it lies wrong.

A part that is dropped takes 60 / rate seconds, and each kick a cycle. In each pose the
part gets what has it accepted sooner.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..records import Array, FlipStatistics, Index
from ..statistics import feeding
from .feeder_cell import Feeder, KickPlan, faster_by_kick, mean_variance


@dataclass(frozen=True, eq=False)
class SingleParts(Feeder):
    """Parts that come one after the other."""

    def plan(self, kick: FlipStatistics | None) -> KickPlan:
        """What the cell gets with a kick, where it is worth its time."""
        accepted = feeding.accepted_share(self.landed, np.flatnonzero(self.right_mask))
        flips = feeding.NO_FLIPS
        per_minute = feeding.Bounded(*(self.cell.rate * share for share in accepted))
        pickable = accepted.value
        if kick is not None:
            flips_known = np.array(self.flips_known(kick))
            flipped = self.poses_worth_flipping(0, kick.transition)
            if self.dropped.probability[flipped].any():
                accepted, flips, per_minute = self._flip(
                    flipped, kick.transition[flipped], flips_known[flipped]
                )
        return KickPlan(
            0.0 if kick is None else kick.kick_height,
            0,
            0,
            pickable,
            accepted,
            feeding.passes_of(*accepted),
            flips,
            per_minute,
            "" if kick is None else kick.feeder_setting,
        )

    def poses_worth_flipping(self, _parts: int, transition: Array) -> Index:
        """Poses in which a kick gets a part accepted sooner than a new drop does.

        `_parts`: as of a plate, on which they would share a kick.
        """
        flips = faster_by_kick(
            self.right_mask,
            self.dropped.probability,
            transition,
            self.cell.cycle_seconds,
            60.0 / self.cell.rate,
            self.can_flip,
        )
        return np.flatnonzero(flips & (self.pick_mask == 0.0))

    def _flip(
        self, flipped: Index, moves: Array, flips_known: Array
    ) -> tuple[feeding.Bounded, feeding.Bounded, feeding.Bounded]:
        """Share accepted of the drops, flips for each of these, and accepted a minute.

        With T the moves (F, K) among the flipped poses, (I - T)^-1 1 flips are needed
        out of each, and each is visited v = p (I - T)^-1 times. Of a sum p g over the
        poses a change dT changes v dT g: errors of first order.
        """
        landed = self.landed
        shares = landed.probability
        inner = np.eye(flipped.size) - moves[:, flipped]
        acceptance = self.right_mask  # chance (K,) before the part is sent back
        acceptance[flipped] = np.linalg.solve(inner, moves @ acceptance)
        flips_needed = np.zeros(shares.size)
        flips_needed[flipped] = np.linalg.solve(inner, np.ones(flipped.size))
        visits = np.linalg.solve(inner.T, shares[flipped])

        def variance(values: Array) -> float:
            rows = zip(moves, flips_known.tolist(), visits.tolist(), strict=True)
            drops = mean_variance(landed.shares, landed.by_unit(values), landed.drops)
            return drops + sum(
                float(visit) ** 2 * mean_variance(row, values, flips)
                for row, flips, visit in rows
            )

        accepted = min(1.0, float(shares @ acceptance))
        flips = float(shares @ flips_needed)
        cycle_seconds = self.cell.cycle_seconds
        seconds = 60.0 / self.cell.rate + cycle_seconds * flips
        share = feeding.CERTAINTY
        right_poses = np.count_nonzero(self.right_mask)
        are_all_flipped = flipped.size + right_poses == shares.size
        if accepted < 1.0 and not are_all_flipped:
            error = variance(acceptance)
            scatter = accepted * (1.0 - accepted)
            share = feeding.counted_share(
                accepted, scatter / error if error else math.inf
            )
        accepted_change = acceptance / accepted
        per_minute = feeding.with_bounds(
            60.0 * accepted / seconds,
            variance(accepted_change - cycle_seconds / seconds * flips_needed),
        )
        return (
            share,
            feeding.with_bounds(
                flips / accepted, variance(flips_needed / flips - accepted_change)
            ),
            per_minute._replace(high=min(per_minute.high, self.cell.rate)),
        )
