"""What happens at an event: impacts, then flight or a contact; or a contact that lets go."""

import math

from ...tolerances import AT_REST, PULL, SINKING
from .. import vectors as vec
from ..array_types import Array
from ..compilation import inlined
from . import layout as at
from .detect import LANDING, NOTHING, Event, Path, time_to_plate
from .impacts import stop_slow, strike, vertex_velocity

PATIENT = 1.25
"""Steps in flight end this much after the time at which the next landing is expected."""


@inlined
def take_up(
    body: at.DropBody, rules: at.DropRules, work: at.Work, event: Event, tape: Array
) -> bool:
    """Note the vertices that an event is about, and let go of a contact that pulls.

    Returns whether vertices have landed, which is to be resolved.
    """
    tally = work.tally
    tally[at.NEAR] = 0
    if event.what == NOTHING:
        return False
    if event.what == LANDING:
        for i in range(event.close):
            if at.corner_height(work.state, body, work.found[i]) <= rules.touching:
                work.near[tally[at.NEAR]] = work.found[i]
                tally[at.NEAR] += 1
        at.note(work, tape, at.ARRIVAL, event.corner)
        return True
    tally[at.NEAR] = 1
    work.near[0] = work.active[event.what]
    work.rested[0] = 2
    tally[at.MODE] = let_go(body, work, event.what)
    at.note(work, tape, at.LIFT_OFF, work.near[0])
    return False


@inlined
def resolve(body: at.DropBody, rules: at.DropRules, work: at.Work, tape: Array) -> bool:
    """Resolve an event at the touching vertices: afterwards none of them approaches.

    Each round the fastest vertex is struck. Once all are slow they are brought to rest, and
    the contact is chosen; one that could not be (see `stop_slow`) is struck.

    Returns false where the steps granted ran out before.
    """
    state = work.state
    near = work.near
    tally = work.tally
    tally[at.MODE] = at.FLIGHT
    done = False
    while tally[at.EVENTS] < tally[at.LIMIT]:
        _sort_by_speed(body, work)
        hit = 0
        speed = work.speed[0]
        if speed > AT_REST:
            done = True
            break
        if speed >= -rules.slow:
            stop_slow(body, rules, work)
            at.note(work, tape, at.STOP, near[0])
            hit, speed = _fastest(body, work)
            if hit < 0:
                weigh(body, work)
                tally[at.MODE] = choose_contact(body, work)
                done = True
                break
        j = near[hit]
        strike(state, body.moment, at.corner_of(body, j), speed, rules.restitution)
        tally[at.IMPACTS] += 1
        tally[at.EVENTS] += 1
        at.note(work, tape, at.IMPACT, j)
    _look_ahead(body, rules, work)
    at.note_contact(work, tape)
    return done


@inlined
def _sort_by_speed(body: at.DropBody, work: at.Work) -> None:
    """Velocities of the touching vertices, the one that approaches fastest first."""
    # Equal ones by turns: an edge that lands level would always tip the part the same way.
    tie = AT_REST if work.tally[at.EVENTS] % 2 == 0 else -AT_REST
    for i in range(work.tally[at.NEAR]):
        j = work.near[i]
        u = vertex_velocity(work.state, at.corner_of(body, j))
        k = i
        while k > 0 and work.speed[k - 1] > u + tie:
            work.speed[k], work.near[k] = work.speed[k - 1], work.near[k - 1]
            k -= 1
        work.speed[k] = u
        work.near[k] = j
        work.rested[i] = 0


@inlined
def _fastest(body: at.DropBody, work: at.Work) -> tuple[int, float]:
    """The touching vertex that still approaches fastest, -1 for none, and its velocity.

    One that was too fast to be stopped, but was stopped by the others, is at rest like them.
    """
    hit = -1
    fastest = -AT_REST
    for i in range(work.tally[at.NEAR]):
        if work.rested[i] == 0:
            j = work.near[i]
            u = vertex_velocity(work.state, at.corner_of(body, j))
            if abs(u) <= AT_REST:
                work.rested[i] = 1
            elif u < fastest:
                hit = i
                fastest = u
    return hit, fastest


@inlined
def _look_ahead(body: at.DropBody, rules: at.DropRules, work: at.Work) -> None:
    """Note a lowest corner, and when the next landing is expected.

    That is of a corner that has just been struck, or of a neighbour that the body rolls on to.
    """
    state = work.state
    tally = work.tally
    lowest = expected = math.inf
    for i in range(tally[at.NEAR]):
        j = work.near[i]
        height = at.corner_height(state, body, j)
        if height < lowest:
            lowest = height
            tally[at.LOWEST] = j
        path = _path_ahead(body, work, j)
        if work.rested[i] == 0 and path.slope > AT_REST:
            expected = min(expected, time_to_plate(path))
        if body.beside.shape[0] == 0:
            continue
        for k in range(body.beside_start[j], body.beside_start[j + 1]):
            path = _path_ahead(body, work, body.beside[k])
            if path.height > rules.touching:
                expected = min(expected, time_to_plate(path))
    work.clock[at.EXPECTED_LANDING] = PATIENT * expected


@inlined
def _path_ahead(body: at.DropBody, work: at.Work, j: int) -> Path:
    """Height of a vertex in time by its velocity and, in flight, its acceleration."""
    r = at.corner_of(body, j)
    fall = _fall_of(body, work.state, r) if work.tally[at.MODE] == at.FLIGHT else 0.0
    return Path(
        at.corner_height(work.state, body, j),
        vertex_velocity(work.state, r),
        -0.5 * fall,
    )


@inlined
def _fall_of(body: at.DropBody, state: Array, r: vec.Vec3) -> float:
    """Downward acceleration of a vertex in free motion.

    It is 1 - ((p x w) x w) . r - a . I^-1 (I w) x w with a = r x p.
    """
    g = at.coupling_of(body.moment)
    p = at.up_of(state)
    w = at.spin_of(state)
    a = vec.cross(r, p)
    return (
        1.0
        - vec.dot(p, w) * vec.dot(w, r)
        + vec.dot(w, w) * vec.dot(p, r)
        - a.x * g.x * w.y * w.z
        - a.y * g.y * w.z * w.x
        - a.z * g.z * w.x * w.y
    )


@inlined
def weigh(body: at.DropBody, work: at.Work) -> None:
    """Reach a = r x p and downward acceleration in free motion of every touching vertex."""
    for i in range(work.tally[at.NEAR]):
        r = at.corner_of(body, work.near[i])
        vec.write_row(work.load, i, at.ARM, vec.cross(r, at.up_of(work.state)))
        work.load[i, at.FALL] = _fall_of(body, work.state, r)


@inlined
def choose_contact(body: at.DropBody, work: at.Work) -> int:
    """Contact mode of the vertices at rest: none, one, or two that carry the body, or a face.

    `weigh` has measured them. The vertices in contact are noted in `active` and `contact`.
    """
    active = work.active
    count = work.tally[at.NEAR]
    active[0] = active[1] = -1
    most = 0.0
    for i in range(count):
        if work.rested[i] == 1:
            most = max(most, work.load[i, at.FALL])
    if most <= PULL:
        return at.FLIGHT
    still = _still_on_three(work)
    for i in range(count):
        if work.rested[i] == 0 or work.load[i, at.FALL] <= PULL:
            continue
        mode = _try_vertex(body, work, i, still)
        if mode != at.FLIGHT:
            return mode
    for i in range(count):
        for k in range(i + 1, count):
            if work.rested[i] == 0 or work.rested[k] == 0:
                continue
            mode = _try_edge(body, work, i, k, still)
            if mode != at.FLIGHT:
                return mode
    active[0] = active[1] = -1
    return at.FACE


@inlined
def _try_vertex(body: at.DropBody, work: at.Work, i: int, still: bool) -> int:
    """Mode if one vertex carries the body, `FLIGHT` if it does not."""
    arm = vec.read_row(work.load, i, at.ARM)
    fall = work.load[i, at.FALL]
    reply = vec.over(arm, at.moments_of(body))
    force = fall / vec.dot_from(1.0, arm, reply)
    turning = vec.scaled(reply, force)
    if not _carries(work, i, i, force, turning):
        return at.FLIGHT
    if still and not _lifts(work, force, turning):
        return at.FACE
    work.active[0] = work.near[i]
    _hold(body, work)
    return at.VERTEX


@inlined
def _try_edge(body: at.DropBody, work: at.Work, i: int, k: int, still: bool) -> int:
    """Mode if two vertices carry the body by forces that push, `FLIGHT` if they do not.

    They are held from here on.
    """
    work.active[0], work.active[1] = work.near[i], work.near[k]
    _hold(body, work)
    m = at.moments_of(body)
    size = work.contact[at.LENGTH]
    a = vec.read_row(work.load, i, at.ARM)
    c = vec.cross(vec.read_vector(work.contact, at.ALONG), at.up_of(work.state))
    m11 = _response(1.0, a, a, m)
    m12 = _response(0.0, a, c, m)
    m22 = _response(0.0, c, c, m)
    fall = work.load[i, at.FALL]
    turn = (work.load[k, at.FALL] - fall) / size
    share = 1.0 / (m11 * m22 - m12 * m12)
    force = share * (m22 * fall - m12 * turn)
    torque = share * (m11 * turn - m12 * fall)
    far = torque / size
    if far < -PULL or force - far < -PULL or not math.isfinite(far):
        return at.FLIGHT
    turning = vec.over(vec.plus(vec.scaled(a, force), vec.scaled(c, torque)), m)
    if not _carries(work, i, k, force, turning):
        return at.FLIGHT
    if still and not _lifts(work, force, turning):
        return at.FACE
    return at.EDGE


@inlined
def _response(start: float, a: vec.Vec3, b: vec.Vec3, m: vec.Vec3) -> float:
    """A number, plus a . I^-1 b."""
    return start + a.x * b.x / m.x + a.y * b.y / m.y + a.z * b.z / m.z


@inlined
def _rise(work: at.Work, k: int, force: float, turning: vec.Vec3) -> float:
    """Upward acceleration of a touching vertex under a force and the turning that it brings."""
    return (
        vec.dot_from(force, vec.read_row(work.load, k, at.ARM), turning)
        - work.load[k, at.FALL]
    )


@inlined
def _carries(
    work: at.Work, first: int, second: int, force: float, turning: vec.Vec3
) -> bool:
    """No other vertex at rest would sink, the body's acceleration by the forces being given."""
    for k in range(work.tally[at.NEAR]):
        if work.rested[k] == 0 or k in (first, second):
            continue
        if _rise(work, k, force, turning) < -SINKING:
            return False
    return True


@inlined
def _lifts(work: at.Work, force: float, turning: vec.Vec3) -> bool:
    """A vertex at rest would rise."""
    for k in range(work.tally[at.NEAR]):
        if work.rested[k] == 1 and _rise(work, k, force, turning) > SINKING:
            return True
    return False


@inlined
def _still_on_three(work: at.Work) -> bool:
    """Three vertices or more are at rest and hold the body still.

    It then rests on the face even where two of them alone could carry it, as across the
    middle of a rectangle.
    """
    state = work.state
    if state[at.V] != 0.0:
        return False
    if state[at.W] != 0.0 or state[at.W + 1] != 0.0 or state[at.W + 2] != 0.0:
        return False
    held = 0
    for i in range(work.tally[at.NEAR]):
        held += work.rested[i]
    return held >= 3


@inlined
def _hold(body: at.DropBody, work: at.Work) -> None:
    """Note vertex, direction and length of the contact."""
    contact = work.contact
    far = work.active[1]
    corner = at.corner_of(body, work.active[0])
    vec.write_vector(contact, at.CORNER, corner)
    vec.write_vector(contact, at.ALONG, vec.Vec3(0.0, 0.0, 0.0))
    contact[at.LENGTH] = 1.0
    if far >= 0:
        edge = vec.minus(at.corner_of(body, far), corner)
        size = vec.length(edge)
        vec.write_vector(contact, at.ALONG, vec.divided(edge, size))
        contact[at.LENGTH] = size


@inlined
def let_go(body: at.DropBody, work: at.Work, which: int) -> int:
    """Release one of the vertices in contact; return the mode that is left."""
    if which == 0:
        work.active[0] = work.active[1]
    work.active[1] = -1
    if work.active[0] < 0:
        return at.FLIGHT
    _hold(body, work)
    return at.VERTEX
