"""What happens when vertices reach the plate: impacts, then flight or a contact."""

from __future__ import annotations

import math

from ...tolerances import AT_REST
from ..array_types import Array
from ..compilation import inlined
from ..vectors import dot_from
from .contacts import choose_contact, weigh
from .impacts import stop_slow, strike, vertex_velocity
from .layout import (
    EXPECTED_BOUNCE,
    FALL,
    FLIGHT,
    IMPACT,
    IMPACTS,
    LIMIT,
    LOWEST,
    MODE,
    NEAR,
    STEPS,
    STOP,
    DropBody,
    DropRules,
    Work,
    Z,
    corner_of,
    up_of,
)
from .tape import note

PATIENT = 1.25
"""Steps in flight end this much after the time at which the next bounce is expected."""


@inlined
def resolve(body: DropBody, rules: DropRules, work: Work, tape: Array) -> bool:
    """Resolve an event at the touching vertices: afterwards none of them approaches.

    Each round the fastest vertex is struck. Once all are slow they are brought to rest, and
    the contact is chosen; one that could not be (see `stop_slow`) is struck.

    Returns false where the steps granted ran out before.
    """
    state, near, tally = work.state, work.near, work.tally
    tally[MODE] = FLIGHT
    done = False
    while tally[STEPS] < tally[LIMIT]:
        _sort_by_speed(body, work)
        hit, speed = 0, work.speed[0]
        if speed > AT_REST:
            done = True
            break
        if speed >= -rules.slow:
            stop_slow(body, rules, work)
            note(work, tape, STOP, near[0])
            hit, speed = _fastest(body, work)
            if hit < 0:
                weigh(body, work)
                tally[MODE] = choose_contact(body, work)
                done = True
                break
        j = near[hit]
        strike(state, body.moment, corner_of(body, j), speed, rules.restitution)
        tally[IMPACTS] += 1
        tally[STEPS] += 1
        note(work, tape, IMPACT, j)
    _look_ahead(body, work)
    return done


@inlined
def _sort_by_speed(body: DropBody, work: Work) -> None:
    """Velocities of the touching vertices, the one that approaches fastest first."""
    for i in range(work.tally[NEAR]):
        j = work.near[i]
        u = vertex_velocity(work.state, corner_of(body, j))
        k = i
        while k > 0 and work.speed[k - 1] > u:
            work.speed[k], work.near[k] = work.speed[k - 1], work.near[k - 1]
            k -= 1
        work.speed[k], work.near[k] = u, j
        work.rested[i] = 0


@inlined
def _fastest(body: DropBody, work: Work) -> tuple[int, float]:
    """The touching vertex that still approaches fastest, -1 for none, and its velocity.

    One that was too fast to be stopped, but was stopped by the others, is at rest like them.
    """
    hit, fastest = -1, -AT_REST
    for i in range(work.tally[NEAR]):
        if work.rested[i] == 0:
            j = work.near[i]
            u = vertex_velocity(work.state, corner_of(body, j))
            if abs(u) <= AT_REST:
                work.rested[i] = 1
            elif u < fastest:
                hit, fastest = i, u
    return hit, fastest


@inlined
def _look_ahead(body: DropBody, work: Work) -> None:
    """Note a lowest corner, and when the first bounce ends if nothing else happens."""
    state, tally = work.state, work.tally
    work.clock[EXPECTED_BOUNCE] = math.inf
    if tally[MODE] == FLIGHT:
        weigh(body, work)
    lowest = math.inf
    for i in range(tally[NEAR]):
        j = work.near[i]
        height = corner_height(state, body, j)
        if height < lowest:
            lowest = height
            tally[LOWEST] = j
        if tally[MODE] == FLIGHT and work.rested[i] == 0 and work.load[i, FALL] > 0.0:
            bounce = 2.0 * PATIENT * work.speed[i] / work.load[i, FALL]
            work.clock[EXPECTED_BOUNCE] = min(work.clock[EXPECTED_BOUNCE], bounce)


@inlined
def corner_height(state: Array, body: DropBody, j: int) -> float:
    """Height z + p . r of a corner above the plate."""
    return dot_from(state[Z], corner_of(body, j), up_of(state))


@inlined
def lowest_corner(state: Array, body: DropBody) -> int:
    """Lowest of all corners, the first of several."""
    low, lowest = math.inf, 0
    for j in range(body.x.shape[0]):
        height = corner_height(state, body, j)
        if height < low:
            low, lowest = height, j
    return lowest
