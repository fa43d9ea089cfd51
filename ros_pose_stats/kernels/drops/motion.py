"""One step of the motion: how long, its power series, and the state at its end."""

from __future__ import annotations

import math

from ..array_types import Array
from ..compilation import inlined
from ..vectors import dot, dot_from, length, minus, read_vector, scaled, times, write_vector
from .free_motion import free_series, shorten
from .free_rotation import rotate_freely
from .impacts import vertex_velocity
from .layout import (
    CORNER,
    EDGE,
    EXPECTED_BOUNCE,
    FLIGHT,
    MODE,
    NEAR,
    PS,
    REACH,
    STEP,
    TIME,
    WS,
    ZS,
    DropBody,
    DropRules,
    P,
    V,
    W,
    Work,
    Z,
    spin_of,
    up_of,
)
from .sliding_motion import sliding_series

TURN = 1.0
"""Angle, in radians, that a step tries to turn the body by; the series then just converges.

Near the plate a body with many corners turns by less in a step; see `DropBody.turn`.
"""

LONGEST = 2.0
"""Longest sliding step, in sqrt(radius / g)."""

GROWTH = 4.0
"""A sliding step is at most this many times as long as the last one, or as the last event took
to come."""

SHORTEST = 1e-3
"""But no shorter than this."""

FAR = 2.0
"""Turns of this many radians above the plate are made in one go."""

SHORTEST_CLEAR = 1e-3
"""Flights above the plate shorter than this are not worth a step of their own."""


@inlined
def prepare_step(body: DropBody, rules: DropRules, work: Work) -> int:
    """Choose a step and fill its series; return the last row.

    Returns 0 where the body has instead been moved, in one go, to where it comes within reach of
    the plate again.
    """
    state, clock = work.state, work.clock
    turning = length(spin_of(state))
    if work.tally[MODE] == FLIGHT:
        clear = _time_clear(state)
        if turning * clear > FAR and rotate_freely(state, body.moment, clear):
            state[Z] += clear * (state[V] - 0.5 * clear)
            state[V] -= clear
            clock[TIME] += clear
            clock[EXPECTED_BOUNCE] = math.inf
            work.tally[NEAR] = 0
            return 0
        fall = 1.0001 * (state[V] + math.sqrt(state[V] * state[V] + 2.0 * state[Z]))
        step, turn = min(fall, clock[EXPECTED_BOUNCE]), body.turn
        if clear > SHORTEST_CLEAR:
            step, turn = clear, TURN
        if turning * step > turn:
            step = turn / turning
        clock[EXPECTED_BOUNCE] = math.inf
        last = free_series(state, body.moment, step, rules.truncation, work.series)
    else:
        step = min(LONGEST, GROWTH * clock[REACH])
        if turning * step > body.turn:
            step = body.turn / turning
        last = sliding_series(state, body.moment, work.contact, work.tally[MODE] == EDGE, step,
                              rules.truncation, work.series)
    step *= shorten(work.series, last, rules.truncation)
    clock[STEP] = clock[REACH] = step
    return last


@inlined
def _time_clear(state: Array) -> float:
    """Time for which the centre of mass stays a radius above the plate; 0 if it is not."""
    if state[Z] <= 1.0:
        return 0.0
    return float(state[V] + math.sqrt(state[V] * state[V] + 2.0 * (state[Z] - 1.0)))


@inlined
def advance(state: Array, series: Array, contact: Array, mode: int, last: int, step: float,
            fraction: float) -> None:
    """Move a state to a fraction of the step that its series is for."""
    for i in range(3):
        state[W + i] = value_at(series, WS + i, last, fraction) / step
        state[P + i] = value_at(series, PS + i, last, fraction)
    if mode == FLIGHT:
        elapsed = fraction * step
        state[Z] += elapsed * (state[V] - 0.5 * elapsed)
        state[V] -= elapsed
    else:  # the contact stays where it is, so that its velocity gives the centre's
        state[Z] = value_at(series, ZS, last, fraction)
        state[V] = 0.0
        state[V] = -vertex_velocity(state, read_vector(contact, CORNER))


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
    up, spin, inertia = up_of(state), spin_of(state), read_vector(moment, 0)
    up = scaled(up, 1.5 - 0.5 * dot(up, up))
    momentum = times(up, inertia)
    # From 0, so that there is no negative zero where nothing turns.
    excess = dot_from(0.0, momentum, spin) / dot(momentum, up)
    write_vector(state, P, up)
    write_vector(state, W, minus(spin, scaled(up, excess)))
