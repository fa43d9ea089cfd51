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

"""One step of the motion: how long, its power series, and the state at its end.

A recorded drop is sampled between two events with the full orientation. The eight
numbers of a state leave out the turn about the vertical, which is integrated along: the
quaternion q of the part in the plate frame obeys q' = q (0, w) / 2.
"""

import math

import numpy as np

from ...tolerances import TRUNCATION
from ..array_types import Array, Array2, Fixed1, Fixed2
from ..compilation import entry_kernel, inlined
from ..vectors import (
    dot,
    dot_from,
    length,
    products,
    read_row,
    read_vector,
    scale,
    subtract,
    transform,
    write_vector,
)
from . import layout
from .detect import NOTHING, Event
from .free_rotation import rotate_freely
from .impacts import vertex_velocity
from .series import free_series, shorten_series, sliding_series

TURN = 1.0
"""Radians that a step tries to turn the body by; the series then just converges.

Near the plate a body with many corners turns by less in a step; see
`DropBody.turn_limit`.
"""

LONGEST_STEP = 2.0
"""Longest sliding step, in sqrt(radius / g)."""

GROWTH = 4.0
"""A sliding step of which nothing is expected is at most this many times as long as the
last one, or as the last event took to come.
"""

SHORTEST_REACH = 1e-3
"""But no shorter than this."""

FREE_TURN = 2.0
"""Turns of this many radians above the plate are made in one go."""

SHORTEST_CLEAR = 1e-3
"""Flights above the plate shorter than this are not worth a step of their own."""


@inlined
def prepare_step(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work
) -> int:
    """Choose a step and fill its series; return the last row.

    Returns 0 where the body has instead been moved, in one go, to where it comes within
    reach of the plate again.
    """
    state = work.state
    clock = work.clock
    turning_speed = length(layout.spin_of(state))
    if work.tally[layout.MODE] == layout.FLIGHT:
        clear_time = (
            0.0  # time for which the centre of mass stays a radius above the plate
        )
        if state[layout.Z] > 1.0:
            clear_time = state[layout.V] + math.sqrt(
                state[layout.V] * state[layout.V] + 2.0 * (state[layout.Z] - 1.0)
            )
        if turning_speed * clear_time > FREE_TURN and rotate_freely(
            state, body.moment, clear_time
        ):
            state[layout.Z] += clear_time * (state[layout.V] - 0.5 * clear_time)
            state[layout.V] -= clear_time
            clock[layout.TIME] += clear_time
            clock[layout.EXPECTED_LANDING] = math.inf
            work.tally[layout.VERTICES] = 0
            return 0
        fall_time = 1.0001 * (
            state[layout.V]
            + math.sqrt(state[layout.V] * state[layout.V] + 2.0 * state[layout.Z])
        )
        step = min(fall_time, clock[layout.EXPECTED_LANDING])
        turn = body.turn_limit
        if clear_time > SHORTEST_CLEAR:
            step = clear_time
            turn = TURN
        if turning_speed * step > turn:
            step = turn / turning_speed
        last = free_series(state, body.moment, step, rules.truncation, work.series)
    else:
        step = min(LONGEST_STEP, GROWTH * clock[layout.REACH])
        if clock[layout.EXPECTED_LANDING] < math.inf:
            step = min(LONGEST_STEP, clock[layout.EXPECTED_LANDING])
        if turning_speed * step > body.turn_limit:
            step = body.turn_limit / turning_speed
        on_edge = work.tally[layout.MODE] == layout.EDGE
        last = sliding_series(
            state,
            body.moment,
            work.contact,
            on_edge,
            step,
            rules.truncation,
            work.series,
        )
    clock[layout.EXPECTED_LANDING] = math.inf
    step *= shorten_series(work.series, last, rules.truncation)
    clock[layout.STEP] = clock[layout.REACH] = step
    return last


@inlined
def move_to_event(
    body: layout.DropBody, work: layout.Work, last: int, event: Event
) -> None:
    """Move to an event, or to the end of the step where nothing happens on it."""
    state = work.state
    clock = work.clock
    elapsed = event.fraction * clock[layout.STEP]
    advance_state(
        state,
        work.series,
        work.contact,
        work.tally[layout.MODE],
        last,
        clock[layout.STEP],
        event.fraction,
    )
    clock[layout.TIME] += elapsed
    if event.kind != NOTHING:
        clock[layout.REACH] = max(elapsed, SHORTEST_REACH)
        restore_invariants(state, body.moment)


@inlined
def advance_state(
    state: Array,
    series: Array,
    contact: Array,
    mode: int,
    last: int,
    step: float,
    fraction: float,
) -> None:
    """Move a state to a fraction of the step that its series is for."""
    for i in range(3):
        state[layout.W + i] = value_at(series, layout.WS + i, last, fraction) / step
        state[layout.P + i] = value_at(series, layout.PS + i, last, fraction)
    if mode == layout.FLIGHT:
        elapsed = fraction * step
        state[layout.Z] += elapsed * (state[layout.V] - 0.5 * elapsed)
        state[layout.V] -= elapsed
    else:  # the contact stays where it is, so that its velocity gives the centre's
        state[layout.Z] = value_at(series, layout.ZS, last, fraction)
        state[layout.V] = 0.0
        state[layout.V] = -vertex_velocity(state, read_vector(contact, layout.CORNER))


@inlined
def value_at(series: Array, column: int, last: int, x: float) -> float:
    """Value of one of the power series."""
    value = series[last, column]
    for k in range(last - 1, -1, -1):
        value = value * x + series[k, column]
    return float(value)


@inlined
def restore_invariants(state: Array, moment: Array) -> None:
    """Restore |p| = 1 and p . I w = 0, from which rounding makes a state drift."""
    up = layout.up_of(state)
    spin = layout.spin_of(state)
    inertia = read_vector(moment, 0)
    up = scale(up, 1.5 - 0.5 * dot(up, up))
    momentum = products(up, inertia)
    # From 0, so that there is no negative zero where nothing turns.
    excess = dot_from(0.0, momentum, spin) / dot(momentum, up)
    write_vector(state, layout.P, up)
    write_vector(state, layout.W, subtract(spin, scale(up, excess)))


@entry_kernel
def sample_motion(
    moment: Fixed1,
    axes: Fixed2,
    mode: int,
    contact: Fixed1,
    start: Fixed1,
    first_turn: Fixed1,
    times: Fixed1,
    states: Array2,
    turns: Array2,
) -> None:
    """States at given times of one smooth phase.

    `moment` (3,); `axes` (3, 3): principal axes as columns; `contact` (7,): see
    `layout`; `start` (8,): state at time 0; `first_turn` (4,): quaternion x y z w of
    the part frame in the plate frame at time 0; `times` (n,): rising, from 0 on;
    `states` (n, 8): filled; `turns` (n, 4): filled.
    """
    state = start.copy()
    series = np.zeros((layout.ORDER + 1, layout.COLUMNS))
    turn = first_turn.copy()
    turn_series = np.zeros((layout.ORDER + 1, 4))
    time = 0.0
    for i in range(times.shape[0]):
        while True:
            remaining_time = times[i] - time
            turning_speed = length(layout.spin_of(state))
            step = (
                LONGEST_STEP
                if turning_speed * LONGEST_STEP < TURN
                else TURN / turning_speed
            )
            step = max(min(step, remaining_time), 1e-12)
            if mode == layout.FLIGHT:
                last = free_series(state, moment, step, TRUNCATION, series)
            else:
                last = sliding_series(
                    state,
                    moment,
                    contact,
                    mode == layout.EDGE,
                    step,
                    TRUNCATION,
                    series,
                )
            step *= shorten_series(series, last, TRUNCATION)
            _quaternion_series(series, axes, turn, last, turn_series)
            fraction = min(1.0, remaining_time / step)
            advance_state(state, series, contact, mode, last, step, fraction)
            for k in range(4):
                turn[k] = value_at(turn_series, k, last, fraction)
            time += fraction * step
            if time >= times[i] - 1e-14 * (1.0 + times[i]):
                break
        for k in range(layout.STATE):
            states[i, k] = state[k]
        x = turn[0]
        y = turn[1]
        z = turn[2]
        w = turn[3]
        size = math.sqrt(x * x + y * y + z * z + w * w)
        for k in range(4):
            turn[k] /= size
            turns[i, k] = turn[k]


@inlined
def _quaternion_series(
    series: Array, axes: Array, quaternion: Array, last: int, quaternion_series: Array
) -> None:
    for k in range(4):
        quaternion_series[0, k] = quaternion[k]
    for n in range(last):
        dx = dy = dz = dw = 0.0
        for i in range(n + 1):
            j = n - i
            spin = transform(axes, read_row(series, j, layout.WS))
            x = quaternion_series[i, 0]
            y = quaternion_series[i, 1]
            z = quaternion_series[i, 2]
            w = quaternion_series[i, 3]
            dx += w * spin.x + y * spin.z - z * spin.y
            dy += w * spin.y + z * spin.x - x * spin.z
            dz += w * spin.z + x * spin.y - y * spin.x
            dw -= x * spin.x + y * spin.y + z * spin.z
        share = 0.5 / (n + 1)
        quaternion_series[n + 1, 0] = dx * share
        quaternion_series[n + 1, 1] = dy * share
        quaternion_series[n + 1, 2] = dz * share
        quaternion_series[n + 1, 3] = dw * share
