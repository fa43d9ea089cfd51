"""Power series of free flight: torque-free rotation and a parabola.

I w' = (I w) x w and p' = p x w (Eqs. 13 and 15 without contact, p the vertical in body
axes). In principal axes w1' = (I2 - I3)/I1 w2 w3 and so on, so that each coefficient is a sum
over products of the earlier ones.
"""

from __future__ import annotations

import numpy as np

from ..compilation import inlined
from ..elementary import rough_root
from .layout import FORCE, ORDER, PS, TORQUE, WS, ZS, Array, P, V, W, Z


@inlined
def begin_series(state: Array, step: float, series: Array) -> None:
    """Put the state at the start of a step into row 0, and the height's first power."""
    for i in range(3):
        series[0, WS + i] = step * state[W + i]
        series[0, PS + i] = state[P + i]
    series[0, ZS] = state[Z]


@inlined
def free_series(state: Array, moment: Array, step: float, truncation: float,
                series: Array) -> int:
    """Fill the series of a free flight; return its last row.

    Rows stop when two in a row add less than `truncation` to the direction of up.
    """
    c0 = (moment[1] - moment[2]) / moment[0]
    c1 = (moment[2] - moment[0]) / moment[1]
    c2 = (moment[0] - moment[1]) / moment[2]
    begin_series(state, step, series)
    last = ORDER
    before = 1.0
    for k in range(ORDER):
        s0 = s1 = s2 = s3 = s4 = s5 = 0.0
        for i in range(np.uint64(k + 1)):
            j = np.uint64(k) - i
            a0, a1, a2 = series[i, WS], series[i, WS + 1], series[i, WS + 2]
            q0, q1, q2 = series[i, PS], series[i, PS + 1], series[i, PS + 2]
            b0, b1, b2 = series[j, WS], series[j, WS + 1], series[j, WS + 2]
            s0 += a1 * b2
            s1 += a2 * b0
            s2 += a0 * b1
            s3 += q1 * b2 - q2 * b1
            s4 += q2 * b0 - q0 * b2
            s5 += q0 * b1 - q1 * b0
        share = 1.0 / (k + 1)
        series[k + 1, WS], series[k + 1, WS + 1] = c0 * s0 * share, c1 * s1 * share
        series[k + 1, WS + 2] = c2 * s2 * share
        series[k + 1, PS], series[k + 1, PS + 1] = s3 * share, s4 * share
        series[k + 1, PS + 2] = s5 * share
        series[k + 1, ZS] = 0.0
        size = max(abs(s3), abs(s4), abs(s5)) * share
        if max(size, before) < truncation:
            last = k + 1
            break
        before = size
    last = max(last, 2)
    series[1, ZS] = step * state[V]
    series[2, ZS] = -0.5 * step * step
    return last


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
        for i in range(3):
            series[k, WS + i] *= power * fraction
            series[k, PS + i] *= power
        series[k, ZS] *= power
        series[k, FORCE] *= power * fraction * fraction
        series[k, TORQUE] *= power * fraction * fraction
        power *= fraction
    return fraction
