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

"""Elementary functions that round alike on every processor.

The C library picks its sine by the processor that it finds, and fuses multiplications
with additions where it can, so that the last bit of a result depends on the machine;
and drops are chaotic. The functions here consist of additions, multiplications and
divisions alone, which IEEE 754 rounds in one way, in an order that the compiler keeps.

Arguments are reduced until a few terms of the Taylor series do (DLMF 4.19, 4.2.19,
4.6.4, 4.24.3). The constants are those of the series; nothing is fitted.
"""

import math

import numpy as np

from .array_types import Array, Fixed1
from .compilation import entry_kernel, kernel

_QUARTERS_PER_RADIAN = 2.0 / math.pi
# pi / 2 in three parts. Two have 33 bits, so that up to 2^20 quarter turns times them
# are exact.
_QUARTER_HIGH = 1.5707963267341256
_QUARTER_MIDDLE = 6.077100506303966e-11
_QUARTER_LOW = 2.0222662487959506e-21

_LN2 = math.log(2.0)
# ln 2 in two parts. The first has 32 bits: its products with binary exponents are
# exact.
_LN2_HIGH = 0.6931471803691238
_LN2_LOW = 1.9082149292705877e-10

_ARCTANGENTS = (
    0.0,
    0.24497866312686414,
    0.4636476090008061,
    0.6435011087932844,
    0.7853981633974483,
)
"""Of 0, 1/4, 1/2, 3/4 and 1."""

_EXPONENT_LEAST = -708.0
_EXPONENT_MOST = 709.0


@kernel
def sine_cosine(x: float) -> tuple[float, float]:
    """Sine and cosine of a finite angle in radians."""
    turns = math.floor(x * _QUARTERS_PER_RADIAN + 0.5)
    r = ((x - turns * _QUARTER_HIGH) - turns * _QUARTER_MIDDLE) - turns * _QUARTER_LOW
    q = r * r
    series = 1 / 6227020800 - q * (1 / 1307674368000 - q * (1 / 355687428096000))
    series = 1 / 5040 - q * (1 / 362880 - q * (1 / 39916800 - q * series))
    sine = r - r * (q * (1 / 6 - q * (1 / 120 - q * series)))
    series = 1 / 479001600 - q * (1 / 87178291200 - q * (1 / 20922789888000))
    series = 1 / 720 - q * (1 / 40320 - q * (1 / 3628800 - q * series))
    cosine = 1.0 - q * (1 / 2 - q * (1 / 24 - q * series))
    quadrant = turns - 4.0 * math.floor(0.25 * turns)
    if quadrant == 0.0:
        return sine, cosine
    if quadrant == 1.0:
        return cosine, -sine
    if quadrant == 2.0:
        return -sine, -cosine
    return -cosine, sine


@kernel
def arctangent(y: float, x: float) -> float:
    """Angle of (x, y) in radians, from -pi to pi; 0 for the origin, NaN for none."""
    width = abs(x)
    height = abs(y)
    smaller = min(width, height)
    larger = max(width, height)
    if larger == 0.0:
        return 0.0
    ratio = smaller / larger
    if not (ratio <= 1.0 and width + height >= 0.0):
        return math.nan
    nearest = int(4.0 * ratio + 0.5)
    center = 0.25 * nearest
    t = (smaller - center * larger) / (larger + center * smaller)
    q = t * t
    series = 1 / 11 - q * (1 / 13 - q * (1 / 15 - q * (1 / 17)))
    series = 1 / 3 - q * (1 / 5 - q * (1 / 7 - q * (1 / 9 - q * series)))
    angle = _ARCTANGENTS[nearest] + (t - t * (q * series))
    if height > width:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return -angle if y < 0.0 else angle


@kernel
def split_binary(x: float) -> tuple[float, int]:
    """Significand, sqrt(1/2) to sqrt(2), and binary exponent of a normal number > 0."""
    bits = np.float64(x).view(np.int64)
    n = (bits >> 52) - 1023
    m = np.int64(bits & 0x000FFFFFFFFFFFFF | 0x3FF0000000000000).view(np.float64)
    if m > 1.4142135623730951:
        m = 0.5 * m
        n = n + 1
    return float(m), int(n)


@kernel
def power_of_two(n: int) -> float:
    """2 to the power n, n from -1022 to 1023."""
    return float(np.int64((n + 1023) << 52).view(np.float64))


@kernel
def exponential(x: float) -> float:
    """Power of e; 0 and infinity outside of the range of normal numbers."""
    if x < _EXPONENT_LEAST:
        return 0.0
    if x > _EXPONENT_MOST:
        return math.inf
    n = math.floor(x * (1.0 / _LN2) + 0.5)
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    series = 1 / 39916800 + r * (1 / 479001600 + r * (1 / 6227020800))
    series = 1 / 40320 + r * (1 / 362880 + r * (1 / 3628800 + r * series))
    series = 1 / 120 + r * (1 / 720 + r * (1 / 5040 + r * series))
    series = 1.0 + r * (1.0 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 + r * series))))
    return series * power_of_two(int(n))


@kernel
def rough_root(x: float, order: int) -> float:
    """Root of a normal number above 0, to 1e-5: enough for the length of a step."""
    m, n = split_binary(x)
    s = (m - 1.0) / (m + 1.0)
    q = s * s
    logarithm = (2.0 * (s + s * (q * (1 / 3 + q * (1 / 5)))) + n * _LN2) / order
    k = math.floor(logarithm * (1.0 / _LN2) + 0.5)
    r = logarithm - k * _LN2
    series = 1.0 + r * (1.0 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 + r * (1 / 120)))))
    return series * power_of_two(int(k))


@entry_kernel
def sines_cosines(angles: Fixed1) -> tuple[Array, Array]:
    """Sines (n,) and cosines (n,) of angles (n,) in radians."""
    sines = np.empty(angles.shape[0])
    cosines = np.empty(angles.shape[0])
    for i in range(angles.shape[0]):
        sines[i], cosines[i] = sine_cosine(angles[i])
    return sines, cosines
