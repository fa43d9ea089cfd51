"""Power series of free flight: torque-free rotation and a parabola.

I w' = (I w) x w and p' = p x w (Eqs. 13 and 15 without contact, p the vertical in body
axes). In principal axes w1' = (I2 - I3)/I1 w2 w3 and so on, so that each coefficient is a sum
over products of the earlier ones.
"""

from __future__ import annotations

import numpy as np

from ..array_types import Array
from ..compilation import inlined
from ..elementary import rough_root
from ..vectors import Vec3, cross, plus, read_row, scaled, times, write_row
from .layout import FORCE, ORDER, PS, TORQUE, WS, ZS, V, Z, coupling_of, spin_of, up_of


@inlined
def begin_series(state: Array, step: float, series: Array) -> None:
    """Put the state at the start of a step into row 0, and the height's first power."""
    write_row(series, 0, WS, scaled(spin_of(state), step))
    write_row(series, 0, PS, up_of(state))
    series[0, ZS] = state[Z]


@inlined
def free_series(state: Array, moment: Array, step: float, truncation: float,
                series: Array) -> int:
    """Fill the series of a free flight; return its last row.

    Rows stop when two in a row add less than `truncation` to the direction of up.
    """
    coupling = coupling_of(moment)
    begin_series(state, step, series)
    last = ORDER
    before = 1.0
    for k in range(ORDER):
        spins, tilt = turning_products(series, k)
        share = 1.0 / (k + 1)
        write_row(series, k + 1, WS, scaled(times(coupling, spins), share))
        write_row(series, k + 1, PS, scaled(tilt, share))
        series[k + 1, ZS] = 0.0
        size = max(abs(tilt.x), abs(tilt.y), abs(tilt.z)) * share
        if max(size, before) < truncation:
            last = k + 1
            break
        before = size
    last = max(last, 2)
    series[1, ZS] = step * state[V]
    series[2, ZS] = -0.5 * step * step
    return last


@inlined
def turning_products(series: Array, k: int) -> tuple[Vec3, Vec3]:
    """Coefficients k of (w2 w3, w3 w1, w1 w2), and of p x w."""
    spins, tilt = Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0)
    for i in range(np.uint64(k + 1)):
        j = np.uint64(k) - i
        a, b = read_row(series, i, WS), read_row(series, j, WS)
        spins = plus(spins, Vec3(a.y * b.z, a.z * b.x, a.x * b.y))
        tilt = plus(tilt, cross(read_row(series, i, PS), b))
    return spins, tilt


@inlined
def shorten(series: Array, last: int, truncation: float) -> float:
    """Fraction of the step at which the series has converged; rescales it to that.

    Returns 1 where the last two rows are already below `truncation`.
    """
    tail = 0.0
    for k in (last - 1, last):
        for i in range(PS, PS + 3):
            tail = max(tail, abs(series[k, i]))
    if tail <= 4.0 * truncation:
        return 1.0
    fraction = 0.9 * rough_root(truncation / tail, last)
    power = 1.0
    for k in range(last + 1):
        write_row(series, k, WS, scaled(read_row(series, k, WS), power * fraction))
        write_row(series, k, PS, scaled(read_row(series, k, PS), power))
        series[k, ZS] *= power
        series[k, FORCE] *= power * fraction * fraction
        series[k, TORQUE] *= power * fraction * fraction
        power *= fraction
    return fraction
