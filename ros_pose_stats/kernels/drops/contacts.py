"""Which of the touching vertices keep contact: the forces that are needed and not negative."""

import math

from ...tolerances import PULL, SINKING
from .. import vectors as vec
from ..compilation import inlined
from . import layout as at


@inlined
def weigh(body: at.DropBody, work: at.Work) -> None:
    """Reach and downward acceleration in free motion of every touching vertex.

    They are a = r x p and 1 - ((p x w) x w) . r - a . I^-1 (I w) x w.
    """
    g, p, w = at.coupling_of(body.moment), at.up_of(work.state), at.spin_of(work.state)
    g = vec.Vec3(g.x * w.y * w.z, g.y * w.z * w.x, g.z * w.x * w.y)
    pw, ww = vec.dot(p, w), vec.dot(w, w)
    for i in range(work.tally[at.NEAR]):
        r = at.corner_of(body, work.near[i])
        a = vec.cross(r, p)
        vec.write_row(work.load, i, at.ARM, a)
        work.load[i, at.FALL] = (1.0 - pw * vec.dot(w, r) + ww * vec.dot(p, r)
                              - a.x * g.x - a.y * g.y - a.z * g.z)


@inlined
def choose_contact(body: at.DropBody, work: at.Work) -> int:
    """Contact mode of the vertices at rest: none, one, or two that carry the body, or a face.

    `weigh` has measured them. The vertices in contact are noted in `active` and `contact`.
    """
    active, count = work.active, work.tally[at.NEAR]
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
    arm, fall = vec.read_row(work.load, i, at.ARM), work.load[i, at.FALL]
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
    m, size = at.moments_of(body), work.contact[at.LENGTH]
    a = vec.read_row(work.load, i, at.ARM)
    c = vec.cross(vec.read_vector(work.contact, at.ALONG), at.up_of(work.state))
    m11, m12, m22 = _response(1.0, a, a, m), _response(0.0, a, c, m), _response(0.0, c, c, m)
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
    return vec.dot_from(force, vec.read_row(work.load, k, at.ARM), turning) - work.load[k, at.FALL]


@inlined
def _carries(work: at.Work, first: int, second: int, force: float, turning: vec.Vec3) -> bool:
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
    contact, far = work.contact, work.active[1]
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
