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

"""Changes of a probability along a walk: slopes, and jumps found by halving."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ros_pose_stats.core.records import Array

JUMP = 2e-3
"""Change of a probability that is examined, and that counts as a jump if it remains."""

NARROW = 1e-9
"""Width, relative to the whole walk, at which a change that remains is a jump."""

KEPT = 0.5
"""Share of the change that must be left at the end of the halving."""


class Jump(NamedTuple):
    """A jump: its position along the walk, and the change with its sign."""

    position: float
    size: float


class Change(NamedTuple):
    """Changes of a method along a walk.

    Attributes
    ----------
    slope : float
        Largest change of the probability per unit of the parameter, or per relative
        change of it where the walk is logarithmic, between neighbouring values without
        a jump.
    slope_at : float
        Place of the largest change: the lower of the two values.
    jumps : tuple of Jump
    """

    slope: float
    slope_at: float
    jumps: tuple[Jump, ...]


def change(
    positions: Array, values: Array, probability: Callable[[float], float], whole: bool
) -> Change:
    """Find slopes between neighbours, and jumps.

    Parameters
    ----------
    places : (k,) array
        Positions along the walk, rising.
    values : (k,) array
        Probabilities there.
    probability : callable
        At any position in between.
    whole : bool
        Whether no values lie in between, so that no jump is looked for.
    """
    jumps: list[Jump] = []
    slope = 0.0
    position = float(positions[0])
    end = NARROW * float(positions[-1] - positions[0])
    for k in range(len(positions) - 1):
        ends = (float(positions[k]), float(positions[k + 1]))
        step = float(values[k + 1] - values[k])
        found_jumps = (
            []
            if whole
            else _jumps(
                ends, (float(values[k]), float(values[k + 1])), probability, end
            )
        )
        jumps += found_jumps
        steep = abs(step - sum(jump.size for jump in found_jumps)) / (ends[1] - ends[0])
        if steep > slope:
            slope = steep
            position = ends[0]
    return Change(slope, position, tuple(jumps))


def _jumps(
    ends: tuple[float, float],
    values: tuple[float, float],
    probability: Callable[[float], float],
    narrow: float,
) -> list[Jump]:
    """The jump with the largest change between two positions, if there is one.

    The half with the larger change is halved again until it is narrow; a smooth curve's
    change shrinks with the width, a jump's stays.
    """
    if abs(values[1] - values[0]) < JUMP:
        return []
    (low, high), (first, last) = ends, values
    while high - low > narrow:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        share = probability(middle)
        if abs(share - first) >= abs(last - share):
            high = middle
            last = share
        else:
            low = middle
            first = share
        if abs(last - first) < JUMP * KEPT:
            return []
    return [Jump(0.5 * (low + high), last - first)]


def spread(curves: Sequence[Array]) -> tuple[int, float]:
    """Where curves (k,) are farthest apart, and by how much."""
    stack = np.array(curves)
    distance = stack.max(axis=0) - stack.min(axis=0)
    row = int(np.argmax(distance))
    return row, float(distance[row])
