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

"""What changes gain by drops: parts before and after them, from the same starts.

All changes are dropped from the same starts, so that the part before is dropped once
for all of them. Their intervals hold together, so that a change which is chosen for its
gain gains as much as its interval says.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from ...core.records import Index
from ...core.simulation.request import DropRequest
from ...core.statistics.errors import DEFAULT_LEVEL
from .changes import ChangedPart
from .paired_drops import PairedDifference, adjust_together
from .shares import GoalModel

FIRST_LOOK = 1000
"""Drops of each part that tell how many it takes."""

KNOWN_GAIN = 0.0125
"""Half of the widest interval at which the drops end. By then the standard error is
half a point, so few are off by 1.5 points."""

NULL_CHANCE = 0.01
"""How often some step of an answer passes for one that changes something though none
does, at most: half of these pass for a gain. The intervals alone, of 90 %, would have
one answer of twenty recommend a step that gains nothing."""

SPARE = 1.05
"""Drops that are made at once over those that the intervals so far ask for."""


class Proof(NamedTuple):
    """Drops of several parts, and what one gains over another."""

    classes: Index  # (V, n); classes of poses in which the parts came to rest
    gains: tuple[PairedDifference, ...]  # their intervals and chances hold together
    drops: int  # of each part


def prove_gains(
    model: GoalModel,
    changed_parts: Sequence[ChangedPart],
    comparisons: Sequence[tuple[int, int]],
    request: DropRequest,
    on_progress: Callable[[float], object],
    should_stop: Callable[[], bool],
) -> Proof:
    """Drop parts until the gains are known, at most as often as requested.

    `comparisons`: numbers of a part before and of one after, for each gain.
    """
    pairs = model.pair_drops(changed_parts, request.seed, request.workers, should_stop)
    most_drops = request.drops * len(changed_parts)
    level = 1.0 - (1.0 - DEFAULT_LEVEL) / max(1, len(comparisons))
    size = min(FIRST_LOOK, request.drops)
    while True:
        pairs.drop_until(size, lambda drops_done: on_progress(drops_done / most_drops))
        classes = model.classes(pairs, changed_parts)
        gains = judge_together(
            [
                model.goal.gain(classes[before], classes[after], level)
                for before, after in comparisons
            ]
        )
        widest = max((0.5 * (gain.high - gain.low) for gain in gains), default=0.0)
        was_stopped = pairs.drops < size
        if was_stopped or size == request.drops or widest <= KNOWN_GAIN:
            return Proof(classes, gains, pairs.drops)
        needed_drops = math.ceil(SPARE * size * (widest / KNOWN_GAIN) ** 2)
        size = min(request.drops, needed_drops)


def judge_together(gains: Sequence[PairedDifference]) -> tuple[PairedDifference, ...]:
    """Gains with chances that hold for all of them together, by Holm's steps."""
    chances = adjust_together([gain.p_value for gain in gains]).tolist()
    return tuple(
        gain._replace(p_value=chance)
        for gain, chance in zip(gains, chances, strict=True)
    )


def is_known(gain: PairedDifference) -> bool:
    """Whether the interval of a gain is as narrow as more drops would be for."""
    return 0.5 * (gain.high - gain.low) <= KNOWN_GAIN


def is_gain(gain: PairedDifference) -> bool:
    """Whether drops show a gain, and not what a step without one comes to by chance.

    `gain`: with a chance that holds for all steps that were judged with it.
    """
    return gain.value > 0.0 and gain.p_value <= NULL_CHANCE
