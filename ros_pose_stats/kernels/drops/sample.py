"""States between two events of a recorded drop, with the full orientation.

The eight numbers of a drop leave out the turn about the vertical. For pictures it is
integrated along: the quaternion q of the part in the plate frame obeys q' = q (0, w) / 2.
"""

from __future__ import annotations

import math

import numpy as np

from ...tolerances import TRUNCATION
from ..array_types import Array, Array2, Fixed1, Fixed2
from ..compilation import entry_kernel, inlined
from ..vectors import length, read_row, turned
from .free_motion import free_series, shorten
from .layout import COLUMNS, EDGE, FLIGHT, ORDER, STATE, WS, spin_of
from .motion import LONGEST, TURN, advance, value_at
from .sliding_motion import sliding_series


@entry_kernel
def sample_motion(moment: Fixed1, axes: Fixed2, mode: int, contact: Fixed1, start: Fixed1,
                  first_turn: Fixed1, times: Fixed1, states: Array2, turns: Array2) -> None:
    """States at given times of one smooth phase.

    `moment` (3,); `axes` (3, 3): principal axes as columns; `contact` (7,): see `layout`; `start`
    (8,): state at time 0; `first_turn` (4,): quaternion x y z w of the part frame in the plate
    frame at time 0; `times` (n,): rising, from 0 on; `states` (n, 8): filled; `turns` (n, 4):
    filled.
    """
    state, series = start.copy(), np.zeros((ORDER + 1, COLUMNS))
    turn, turn_series = first_turn.copy(), np.zeros((ORDER + 1, 4))
    now = 0.0
    for i in range(times.shape[0]):
        while True:
            ahead = times[i] - now
            rate = length(spin_of(state))
            step = LONGEST if rate * LONGEST < TURN else TURN / rate
            step = max(min(step, ahead), 1e-12)
            if mode == FLIGHT:
                last = free_series(state, moment, step, TRUNCATION, series)
            else:
                last = sliding_series(state, moment, contact, mode == EDGE, step, TRUNCATION,
                                      series)
            step *= shorten(series, last, TRUNCATION)
            _turn_series(series, axes, turn, last, turn_series)
            part = min(1.0, ahead / step)
            advance(state, series, contact, mode, last, step, part)
            for k in range(4):
                turn[k] = value_at(turn_series, k, last, part)
            now += part * step
            if now >= times[i] - 1e-14 * (1.0 + times[i]):
                break
        for k in range(STATE):
            states[i, k] = state[k]
        x, y, z, w = turn[0], turn[1], turn[2], turn[3]
        size = math.sqrt(x * x + y * y + z * z + w * w)
        for k in range(4):
            turn[k] /= size
            turns[i, k] = turn[k]


@inlined
def _turn_series(series: Array, axes: Array, turn: Array, last: int, out: Array) -> None:
    for k in range(4):
        out[0, k] = turn[k]
    for n in range(last):
        dx = dy = dz = dw = 0.0
        for i in range(n + 1):
            j = n - i
            spin = turned(axes, read_row(series, j, WS))
            x, y, z, w = out[i, 0], out[i, 1], out[i, 2], out[i, 3]
            dx += w * spin.x + y * spin.z - z * spin.y
            dy += w * spin.y + z * spin.x - x * spin.z
            dz += w * spin.z + x * spin.y - y * spin.x
            dw -= x * spin.x + y * spin.y + z * spin.z
        share = 0.5 / (n + 1)
        out[n + 1, 0], out[n + 1, 1] = dx * share, dy * share
        out[n + 1, 2], out[n + 1, 3] = dz * share, dw * share
