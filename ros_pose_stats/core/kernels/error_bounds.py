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

"""Bounds that normal errors keep together."""

import math
from typing import NamedTuple

import numpy as np

from .array_types import Array, Fixed1, Fixed2, Fixed3, Index
from .compilation import entry_kernel, kernel

TINIEST = 2.0**-1022  # a deviation that is divided by, at least


class NormalErrors(NamedTuple):
    """Errors of units in each of several cases."""

    deviation: Array  # (M, G)
    offset: Array
    units: Index  # that may be wrong
    weight: Array  # (M,)


@entry_kernel
def bound_errors(
    bounds: Fixed2, deviation: Fixed3, offset: Fixed3, weight: Fixed1, level: float
) -> Array:
    """Bound (N,) that no error exceeds with the chance `level`, of N estimates.

    It is looked for among rising `bounds` (N, L), and straight between two of them.
    Errors of G units are normal in each of M cases of a `weight` (M,), with their
    deviations and offsets (N, M, G), none below 0.
    """
    limits = np.empty(bounds.shape[0])
    for n in range(bounds.shape[0]):
        units = _uncertain_units(deviation[n], offset[n])
        errors = NormalErrors(deviation[n], offset[n], units, weight)
        limits[n] = _bound(bounds[n], errors, level)
    return limits


@kernel
def _uncertain_units(deviation: Array, offset: Array) -> Index:
    """Units that may be wrong in some case."""
    is_uncertain = np.zeros(deviation.shape[1], np.bool_)
    for case in range(deviation.shape[0]):
        for unit in range(deviation.shape[1]):
            # Also where a deviation is not a number.
            is_certain = deviation[case, unit] <= 0.0 and offset[case, unit] <= 0.0
            is_uncertain[unit] |= not is_certain
    return np.flatnonzero(is_uncertain)


@kernel
def _bound(bounds: Array, errors: NormalErrors, level: float) -> float:
    low = 0
    high = bounds.shape[0] - 1
    chance_low = _chance_within(bounds[low], errors)
    chance_high = _chance_within(bounds[high], errors)
    if chance_low >= level:
        return float(bounds[low])
    if chance_high <= level:
        return float(bounds[high])
    while high - low > 1:
        middle = (low + high) // 2
        chance = _chance_within(bounds[middle], errors)
        if chance <= level:
            low = middle
            chance_low = chance
        else:
            high = middle
            chance_high = chance
    share = (level - chance_low) / (chance_high - chance_low)
    return float(bounds[low] + share * (bounds[high] - bounds[low]))


@kernel
def _chance_within(bound: float, errors: NormalErrors) -> float:
    """Chance that all errors are within a bound."""
    chance = 0.0
    for case in range(errors.weight.shape[0]):
        chance += errors.weight[case] * _joint_chance(bound, errors, case)
    return chance


@kernel
def _joint_chance(bound: float, errors: NormalErrors, case: int) -> float:
    """Product of the chances of all units but the likeliest; of one alone, its own."""
    product = 1.0
    likeliest = 1.0
    for k in range(errors.units.shape[0]):
        unit = errors.units[k]
        deviation = errors.deviation[case, unit]
        chance = _unit_chance(bound, deviation, errors.offset[case, unit])
        if k == 0:
            likeliest = chance
        else:
            product *= min(chance, likeliest)
            likeliest = max(chance, likeliest)
    return likeliest if errors.units.shape[0] == 1 else product


@kernel
def _unit_chance(bound: float, deviation: float, offset: float) -> float:
    """Chance that a normal error is within a bound, DLMF 7.18(i)."""
    scale = math.sqrt(2.0) * max(deviation, TINIEST)
    chance = math.erf((bound + offset) / scale)
    if offset == 0.0:
        return chance
    return 0.5 * (chance + math.erf((bound - offset) / scale))
