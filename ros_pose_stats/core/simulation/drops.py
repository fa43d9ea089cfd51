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

"""Drops of one prepared body: the drop kernel in SI units, and its outcomes."""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.drops import drop, layout
from ..kernels.elementary import sines_cosines
from ..mesh.vectors import lengths, turn_vectors
from ..records import Array, DropScene, Index, Mask
from ..records.scene import GRAVITY
from ..tolerances import (
    MOST_STEPS,
    SAME_DOWN,
    SLOW,
    SOFT,
    SOFT_SHARE,
    SOON_OVER,
    TOUCHING,
    TRUNCATION,
)
from .drop_body import DIRECTION_BITS, PreparedBody, round_to

NO_TAPE: Array = np.zeros((0, layout.TAPE))


class DropOutcomes(NamedTuple):
    """Outcomes of consecutive drops."""

    # (n,) int; `index` of the pose that it came to rest in; -1 where unsettled
    pose: Index
    impacts: Index  # (n,) int; single impacts
    events: Index  # (n,) int; impacts and steps, which is what a drop costs
    seconds: Array  # (n,); from release until the outcome was certain
    # (n,); mechanical energy at that time, the plate at 0, in m g radius
    energy_left: Array
    # (n,) bool; whether the outcome was certain before the part came to rest
    trapped: Mask
    # (n,) bool; whether it was released touching the plate, for want of height
    touched: Mask
    # (n,) bool; whether it ended on poses that symmetry makes equal, and `pose` was
    # drawn
    drawn: Mask

    def first(self, count: int) -> "DropOutcomes":
        """Outcomes of the first `count` drops."""
        return DropOutcomes._make(column[:count] for column in self)


class DropChunk(NamedTuple):
    """Consecutive drops that were counted, each with its start and its outcome."""

    first: int  # number of the first of them
    downs: Array  # (n, 3); unit vectors in the part frame that point down at release
    outcomes: DropOutcomes


def drop_rules(
    scene: DropScene, radius: float, *, to_rest: bool = False, draws: bool = False
) -> layout.DropRules:
    """The scene and `tolerances` in the kernels' units.

    `to_rest`: go on until the part lies still. `draws`: end a drop that takes long,
    or rolls for long, as soon as all poses left to it are equally probable, of which
    one is to be drawn then.
    """
    slow = max(SLOW, SOON_OVER * (1.0 - scene.restitution))
    return layout.DropRules(
        scene.restitution,
        scene.release_height(radius) / radius,
        to_rest,
        draws,
        TRUNCATION,
        TOUCHING,
        slow,
        SOFT,
        SOFT_SHARE,
        MOST_STEPS,
    )


def compute_drops(
    body: PreparedBody, rules: layout.DropRules, downs: Array, tape: Array = NO_TAPE
) -> DropOutcomes:
    """Compute the drops from directions `downs` (n, 3) in the caller's thread."""
    directions = body.frame_directions(downs)
    states = states_at_rest(body, rules.height, directions)
    return compute_motions(body, rules, states, tape)


def states_at_rest(
    body: PreparedBody, heights: float | Array, directions: Array
) -> Array:
    """States (n, 8) of a body at rest, in principal axes and radii.

    `directions` (n, 3): that point down, in the axes of the body's frame.
    """
    states = np.zeros((directions.shape[0], layout.STATE))
    states[:, layout.Z] = round_length(heights) if body.is_rounded else heights
    ups = -turn_vectors(directions, body.turn)
    if body.is_rounded:
        ups /= lengths(ups)[:, None]
    states[:, layout.P : layout.P + 3] = ups
    return states


LENGTH_BITS = 36
LEAST_EXPONENT = -64  # of two; smaller lengths are rounded by the step of these


def round_length(lengths_in_radii: float | Array) -> Array:
    """Lengths in radii, rounded so that they are the same for a part in any unit."""
    values = np.asarray(lengths_in_radii)
    # The step of a length next to nothing would vanish.
    exponent = np.maximum(np.frexp(values)[1], LEAST_EXPONENT)
    return round_to(values, np.ldexp(1.0, exponent - LENGTH_BITS))


def release_directions(body: PreparedBody, seed: int, first: int, count: int) -> Array:
    """Directions (count, 3) in part axes that point down at release, by a seed.

    Those of `random_starts` in the frame of the part's own, so that turned, scaled and
    mirrored copies of a part have the same drops.
    """
    starts = random_starts(seed, first, count)
    return turn_vectors(round_to(starts, 2.0**-DIRECTION_BITS), body.frame.T)


def compute_motions(
    body: PreparedBody, rules: layout.DropRules, states: Array, tape: Array = NO_TAPE
) -> DropOutcomes:
    """Compute the outcomes of given states (n, 8), in principal axes.

    `tape` (T, 14): takes the events of the last one; see `kernels.drops.layout`.
    """
    outcome = np.empty((states.shape[0], 5), dtype=np.int64)
    measure = np.empty((states.shape[0], 2))
    drop.run_drops(body.arrays, rules, states, outcome, measure, tape)
    is_drawn = outcome[:, layout.ENDING] == layout.DRAWN
    return DropOutcomes(
        outcome[:, layout.POSE],
        outcome[:, layout.IMPACT_COUNT],
        outcome[:, layout.EVENT_COUNT],
        measure[:, layout.DURATION] * math.sqrt(body.radius / GRAVITY),
        measure[:, layout.ENERGY],
        (outcome[:, layout.ENDING] == layout.TRAPPED) | is_drawn,
        outcome[:, layout.TOUCHED] == 1,
        is_drawn,
    )


_WORDS = 4  # 64-bit words that Philox makes at each place of its stream
_RANDOM_STREAM = 1
_FLIP_STREAM = 3
_ROLL_STREAM = 4
"""Second words of the key, so that drops, flips and draws of one seed have nothing in
common."""


def draw_poses(
    body: PreparedBody, outcomes: DropOutcomes, seed: int, first: int
) -> DropOutcomes:
    """Draw poses for drops that ended before, fairly by the seed and their number.

    Members of a unit are counted in the frame of the part's own, so that copies of a
    part draw the same ones. `outcomes`: of drop `first` and those that follow.
    """
    if not outcomes.drawn.any():
        return outcomes
    unit = body.resting.unit
    downs = np.rint(body.frame_directions(body.resting.downs) / SAME_DOWN)
    order = np.lexsort((*downs.T, unit))
    size = np.bincount(unit)
    unit_start = np.cumsum(size) - size
    drawn_unit = unit[outcomes.pose]
    count = outcomes.pose.shape[0]
    chance = _random_pairs(seed, _ROLL_STREAM, first, count)[:, 0]
    member = np.floor(chance * size[drawn_unit]).astype(np.int64)
    drawn_pose = order[unit_start[drawn_unit] + member]
    return outcomes._replace(pose=np.where(outcomes.drawn, drawn_pose, outcomes.pose))


def random_starts(seed: int, first: int, count: int) -> Array:
    """Unit vectors (count, 3), uniform on the sphere, that point down at release.

    Row k is that of drop `first` + k in every call; 0 <= seed < 2**64.
    """
    u, v = _random_pairs(seed, _RANDOM_STREAM, first, count).T
    points = np.empty((count, 3))
    radius = 2.0 * np.sqrt(u * (1.0 - u))
    sine, cosine = sines_cosines((2.0 * np.pi) * v)
    points[:, 0] = radius * cosine
    points[:, 1] = radius * sine
    points[:, 2] = 2.0 * u - 1.0
    return points


def flip_draws(seed: int, first: int, count: int) -> Array:
    """Two numbers in [0, 1) for each flip (count, 2), the same in every call."""
    return _random_pairs(seed, _FLIP_STREAM, first, count)


def _random_pairs(seed: int, stream: int, first: int, count: int) -> Array:
    """Numbers of 53 bits in [0, 1), (count, 2), from pair `first` of a stream on."""
    block, skipped_words = divmod(2 * first, _WORDS)
    key = np.array((seed, stream), dtype=np.uint64)
    words = np.random.Philox(counter=block, key=key).random_raw(
        skipped_words + 2 * count
    )[skipped_words:]
    return np.asarray((words >> np.uint64(11)) * 2.0**-53).reshape(count, 2)
