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

"""First zero of a polynomial on an interval, found for certain.

A stretch is settled by bounds on the sums of its coefficients: no zero, or a monotone,
concave or convex piece, on which Newton's method cannot miss. Otherwise it is halved.
So no grazing contact is stepped over, and there is no sampling step to choose.
"""

import math

from ..array_types import Array
from ..compilation import inlined

NO_ZERO = 0
MONOTONE = 1
CONCAVE = 2
CONVEX = 3
UNDECIDED = 4
NEVER = math.inf

SHORTEST_STRETCH = 1e-9
"""Stretch below which a polynomial counts as monotone: its bends are then below
rounding.
"""
NEWTON_STEP = 1e-10
"""Relative step after which Newton's method, converging quadratically, is done."""


@inlined
def first_zero(c: Array, first: int, last: int, limit: float, local: Array) -> float:
    """Smallest x in (0, limit] where the sum of c[k] x^(k - first) comes down to zero.

    The polynomial starts above zero, or at zero and falls, which gives a zero at once.
    `local` is scratch.

    Returns infinity if it stays positive.
    """
    begin = 0.0
    length = limit
    n = last - first
    while begin < limit:
        _shift_polynomial(c, first, n, begin, length, local)
        kind = _classify_polynomial(local, n)
        if kind == UNDECIDED and length > SHORTEST_STRETCH:
            length *= 0.5
            continue
        if kind != NO_ZERO:
            x = _newton_zero(local, n, kind)
            if x <= 1.0:
                return begin + length * x
        begin += length
        length = limit - begin
    return NEVER


@inlined
def _shift_polynomial(
    c: Array, first: int, n: int, begin: float, length: float, d: Array
) -> None:
    """Coefficients in the fraction of the stretch from `begin`."""
    for k in range(n + 1):
        d[k] = c[first + k]
    if begin > 0.0:
        for i in range(n):
            for k in range(n - 1, i - 1, -1):
                d[k] += begin * d[k + 1]
    if length != 1.0:
        power = length
        for k in range(1, n + 1):
            d[k] *= power
            power *= length


@inlined
def _classify_polynomial(d: Array, n: int) -> int:
    """What the coefficients alone say about zeros for 0 <= x <= 1."""
    low = total = slope = bend = 0.0
    for k in range(1, n + 1):
        size = abs(d[k])
        total += d[k]
        low += min(d[k], 0.0)
        slope += k * size
        bend += k * (k - 1) * size
    if d[0] + low > 0.0:
        return NO_ZERO
    if 2.0 * abs(d[1]) > slope:  # the first derivative keeps its sign
        return MONOTONE if d[1] < 0.0 and d[0] + total <= 0.0 else NO_ZERO
    if n >= 2 and 4.0 * abs(d[2]) > bend:  # the second one does
        if d[2] < 0.0:
            return CONCAVE if d[0] + total <= 0.0 else NO_ZERO
        return CONVEX if d[1] < 0.0 else NO_ZERO
    return UNDECIDED


@inlined
def _newton_zero(d: Array, n: int, kind: int) -> float:
    """Zero for 0 <= x <= 1 of a polynomial positive at 0; beyond 1 for none."""
    low = 0.0
    high = 1.0
    x = _guess_zero(d, n)
    if kind in (CONVEX, UNDECIDED):
        x = 0.0  # from the left Newton's method climbs to the zero and never past it
    for _ in range(64):
        value = d[n]
        slope = 0.0
        for k in range(n - 1, -1, -1):
            slope = slope * x + value
            value = value * x + d[k]
        if value > 0.0:
            low = x
        else:
            high = x
        if kind in (CONVEX, UNDECIDED) and value > 0.0 and slope >= 0.0:
            return NEVER
        next_x = x - value / slope if slope != 0.0 else 0.5 * (low + high)
        if kind == CONVEX and next_x > 1.0:
            return NEVER
        if not low <= next_x <= high:
            next_x = 0.5 * (low + high)
        if (
            abs(next_x - x) <= NEWTON_STEP * next_x
        ):  # the next error is about its square
            return float(next_x)
        x = next_x
    return float(x)


@inlined
def _guess_zero(d: Array, n: int) -> float:
    """Zero of the first three terms, or the end of the stretch."""
    if n < 2:
        return float(min(1.0, max(0.0, -d[0] / d[1])))
    square = d[1] * d[1] - 4.0 * d[0] * d[2]
    if square < 0.0:
        return 1.0
    x = 2.0 * d[0] / (math.sqrt(square) - d[1])
    return float(x) if 0.0 < x < 1.0 else 1.0
