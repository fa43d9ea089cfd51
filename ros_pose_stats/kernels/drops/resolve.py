"""What happens at an event: impacts, then flight or a contact; or a contact that lets go."""

import math

from ...tolerances import AT_REST
from ..array_types import Array
from ..compilation import inlined
from . import layout as at
from .contacts import choose_contact, let_go, weigh
from .detect import LANDING, NOTHING, Event
from .impacts import stop_slow, strike, vertex_velocity
from .layout import DropBody, DropRules, Work, corner_height, corner_of, note, note_contact

PATIENT = 1.25
"""Steps in flight end this much after the time at which the next bounce is expected."""


@inlined
def take_up(body: DropBody, rules: DropRules, work: Work, event: Event, tape: Array) -> bool:
    """Note the vertices that an event is about, and let go of a contact that pulls.

    Returns whether vertices have landed, which is to be resolved.
    """
    tally = work.tally
    tally[at.NEAR] = 0
    if event.what == NOTHING:
        return False
    if event.what == LANDING:
        for i in range(event.close):
            if corner_height(work.state, body, work.found[i]) <= rules.touching:
                work.near[tally[at.NEAR]] = work.found[i]
                tally[at.NEAR] += 1
        note(work, tape, at.ARRIVAL, event.corner)
        return True
    tally[at.NEAR] = 1
    work.near[0], work.rested[0] = work.active[event.what], 2
    tally[at.MODE] = let_go(body, work, event.what)
    note(work, tape, at.LIFT_OFF, work.near[0])
    return False


@inlined
def resolve(body: DropBody, rules: DropRules, work: Work, tape: Array) -> bool:
    """Resolve an event at the touching vertices: afterwards none of them approaches.

    Each round the fastest vertex is struck. Once all are slow they are brought to rest, and
    the contact is chosen; one that could not be (see `stop_slow`) is struck.

    Returns false where the steps granted ran out before.
    """
    state, near, tally = work.state, work.near, work.tally
    tally[at.MODE] = at.FLIGHT
    done = False
    while tally[at.STEPS] < tally[at.LIMIT]:
        _sort_by_speed(body, work)
        hit, speed = 0, work.speed[0]
        if speed > AT_REST:
            done = True
            break
        if speed >= -rules.slow:
            stop_slow(body, rules, work)
            note(work, tape, at.STOP, near[0])
            hit, speed = _fastest(body, work)
            if hit < 0:
                weigh(body, work)
                tally[at.MODE] = choose_contact(body, work)
                done = True
                break
        j = near[hit]
        strike(state, body.moment, corner_of(body, j), speed, rules.restitution)
        tally[at.IMPACTS] += 1
        tally[at.STEPS] += 1
        note(work, tape, at.IMPACT, j)
    _look_ahead(body, work)
    note_contact(work, tape)
    return done


@inlined
def _sort_by_speed(body: DropBody, work: Work) -> None:
    """Velocities of the touching vertices, the one that approaches fastest first."""
    for i in range(work.tally[at.NEAR]):
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
    for i in range(work.tally[at.NEAR]):
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
    work.clock[at.EXPECTED_BOUNCE] = math.inf
    if tally[at.MODE] == at.FLIGHT:
        weigh(body, work)
    lowest = math.inf
    for i in range(tally[at.NEAR]):
        j = work.near[i]
        height = corner_height(state, body, j)
        if height < lowest:
            lowest = height
            tally[at.LOWEST] = j
        if tally[at.MODE] == at.FLIGHT and work.rested[i] == 0 and work.load[i, at.FALL] > 0.0:
            bounce = 2.0 * PATIENT * work.speed[i] / work.load[i, at.FALL]
            work.clock[at.EXPECTED_BOUNCE] = min(work.clock[at.EXPECTED_BOUNCE], bounce)
