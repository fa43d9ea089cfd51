"""One step of the motion: how long, its power series, and the state at its end.

A recorded drop is sampled between two events with the full orientation. The eight numbers of a
state leave out the turn about the vertical, which is integrated along: the quaternion q of the
part in the plate frame obeys q' = q (0, w) / 2.
"""

import math

import numpy as np

from ...tolerances import TRUNCATION
from .. import vectors
from ..array_types import Array, Array2, Fixed1, Fixed2
from ..compilation import entry_kernel, inlined
from . import layout as at
from .detect import NOTHING, Event
from .free_rotation import rotate_freely
from .impacts import vertex_velocity
from .series import free_series, shorten, sliding_series

TURN = 1.0
"""Angle, in radians, that a step tries to turn the body by; the series then just converges.

Near the plate a body with many corners turns by less in a step; see `DropBody.turn`.
"""

LONGEST = 2.0
"""Longest sliding step, in sqrt(radius / g)."""

GROWTH = 4.0
"""A sliding step of which nothing is expected is at most this many times as long as the last one,
or as the last event took to come."""

SHORTEST = 1e-3
"""But no shorter than this."""

FAR = 2.0
"""Turns of this many radians above the plate are made in one go."""

SHORTEST_CLEAR = 1e-3
"""Flights above the plate shorter than this are not worth a step of their own."""


@inlined
def prepare_step(body: at.DropBody, rules: at.DropRules, work: at.Work) -> int:
    """Choose a step and fill its series; return the last row.

    Returns 0 where the body has instead been moved, in one go, to where it comes within reach of
    the plate again.
    """
    state = work.state
    clock = work.clock
    turning = vectors.length(at.spin_of(state))
    if work.tally[at.MODE] == at.FLIGHT:
        clear = 0.0  # time for which the centre of mass stays a radius above the plate
        if state[at.Z] > 1.0:
            clear = state[at.V] + math.sqrt(
                state[at.V] * state[at.V] + 2.0 * (state[at.Z] - 1.0)
            )
        if turning * clear > FAR and rotate_freely(state, body.moment, clear):
            state[at.Z] += clear * (state[at.V] - 0.5 * clear)
            state[at.V] -= clear
            clock[at.TIME] += clear
            clock[at.EXPECTED_LANDING] = math.inf
            work.tally[at.NEAR] = 0
            return 0
        fall = 1.0001 * (
            state[at.V] + math.sqrt(state[at.V] * state[at.V] + 2.0 * state[at.Z])
        )
        step = min(fall, clock[at.EXPECTED_LANDING])
        turn = body.turn
        if clear > SHORTEST_CLEAR:
            step = clear
            turn = TURN
        if turning * step > turn:
            step = turn / turning
        last = free_series(state, body.moment, step, rules.truncation, work.series)
    else:
        step = min(LONGEST, GROWTH * clock[at.REACH])
        if clock[at.EXPECTED_LANDING] < math.inf:
            step = min(LONGEST, clock[at.EXPECTED_LANDING])
        if turning * step > body.turn:
            step = body.turn / turning
        on_edge = work.tally[at.MODE] == at.EDGE
        last = sliding_series(
            state,
            body.moment,
            work.contact,
            on_edge,
            step,
            rules.truncation,
            work.series,
        )
    clock[at.EXPECTED_LANDING] = math.inf
    step *= shorten(work.series, last, rules.truncation)
    clock[at.STEP] = clock[at.REACH] = step
    return last


@inlined
def evolve(body: at.DropBody, work: at.Work, last: int, event: Event) -> None:
    """Move to an event, or to the end of the step where nothing happens on it."""
    state = work.state
    clock = work.clock
    elapsed = event.fraction * clock[at.STEP]
    advance(
        state,
        work.series,
        work.contact,
        work.tally[at.MODE],
        last,
        clock[at.STEP],
        event.fraction,
    )
    clock[at.TIME] += elapsed
    if event.what != NOTHING:
        clock[at.REACH] = max(elapsed, SHORTEST)
        onto_invariants(state, body.moment)


@inlined
def advance(
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
        state[at.W + i] = value_at(series, at.WS + i, last, fraction) / step
        state[at.P + i] = value_at(series, at.PS + i, last, fraction)
    if mode == at.FLIGHT:
        elapsed = fraction * step
        state[at.Z] += elapsed * (state[at.V] - 0.5 * elapsed)
        state[at.V] -= elapsed
    else:  # the contact stays where it is, so that its velocity gives the centre's
        state[at.Z] = value_at(series, at.ZS, last, fraction)
        state[at.V] = 0.0
        state[at.V] = -vertex_velocity(state, vectors.read_vector(contact, at.CORNER))


@inlined
def value_at(series: Array, column: int, last: int, x: float) -> float:
    """Value of one of the power series."""
    value = series[last, column]
    for k in range(last - 1, -1, -1):
        value = value * x + series[k, column]
    return float(value)


@inlined
def onto_invariants(state: Array, moment: Array) -> None:
    """Put the state back on |p| = 1 and p . I w = 0, from which rounding makes it drift."""
    up = at.up_of(state)
    spin = at.spin_of(state)
    inertia = vectors.read_vector(moment, 0)
    up = vectors.scaled(up, 1.5 - 0.5 * vectors.dot(up, up))
    momentum = vectors.times(up, inertia)
    # From 0, so that there is no negative zero where nothing turns.
    excess = vectors.dot_from(0.0, momentum, spin) / vectors.dot(momentum, up)
    vectors.write_vector(state, at.P, up)
    vectors.write_vector(state, at.W, vectors.minus(spin, vectors.scaled(up, excess)))


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

    `moment` (3,); `axes` (3, 3): principal axes as columns; `contact` (7,): see `layout`; `start`
    (8,): state at time 0; `first_turn` (4,): quaternion x y z w of the part frame in the plate
    frame at time 0; `times` (n,): rising, from 0 on; `states` (n, 8): filled; `turns` (n, 4):
    filled.
    """
    state = start.copy()
    series = np.zeros((at.ORDER + 1, at.COLUMNS))
    turn = first_turn.copy()
    turn_series = np.zeros((at.ORDER + 1, 4))
    now = 0.0
    for i in range(times.shape[0]):
        while True:
            ahead = times[i] - now
            rate = vectors.length(at.spin_of(state))
            step = LONGEST if rate * LONGEST < TURN else TURN / rate
            step = max(min(step, ahead), 1e-12)
            if mode == at.FLIGHT:
                last = free_series(state, moment, step, TRUNCATION, series)
            else:
                last = sliding_series(
                    state, moment, contact, mode == at.EDGE, step, TRUNCATION, series
                )
            step *= shorten(series, last, TRUNCATION)
            _turn_series(series, axes, turn, last, turn_series)
            part = min(1.0, ahead / step)
            advance(state, series, contact, mode, last, step, part)
            for k in range(4):
                turn[k] = value_at(turn_series, k, last, part)
            now += part * step
            if now >= times[i] - 1e-14 * (1.0 + times[i]):
                break
        for k in range(at.STATE):
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
def _turn_series(
    series: Array, axes: Array, turn: Array, last: int, out: Array
) -> None:
    for k in range(4):
        out[0, k] = turn[k]
    for n in range(last):
        dx = dy = dz = dw = 0.0
        for i in range(n + 1):
            j = n - i
            spin = vectors.turned(axes, vectors.read_row(series, j, at.WS))
            x = out[i, 0]
            y = out[i, 1]
            z = out[i, 2]
            w = out[i, 3]
            dx += w * spin.x + y * spin.z - z * spin.y
            dy += w * spin.y + z * spin.x - x * spin.z
            dz += w * spin.z + x * spin.y - y * spin.x
            dw -= x * spin.x + y * spin.y + z * spin.z
        share = 0.5 / (n + 1)
        out[n + 1, 0] = dx * share
        out[n + 1, 1] = dy * share
        out[n + 1, 2] = dz * share
        out[n + 1, 3] = dw * share
