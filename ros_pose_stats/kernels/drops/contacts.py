"""Which of the touching vertices keep contact: the forces that are needed and not negative."""

from __future__ import annotations

import math

from ...tolerances import PULL, SINKING
from ..compilation import inlined
from .layout import EDGE, FACE, FLIGHT, VERTEX, Array, DropBody, Index, P, V, W


@inlined
def weigh(state: Array, body: DropBody, near: Index, count: int, load: Array) -> None:
    """Downward acceleration in free motion and reach of every touching vertex.

    Parameters
    ----------
    load : (C, 4) array
        Set to a = r x p and the acceleration 1 - ((p x w) x w) . r - a . I^-1 (I w) x w.
    """
    m0, m1, m2 = body.moment[0], body.moment[1], body.moment[2]
    px, py, pz = state[P], state[P + 1], state[P + 2]
    wx, wy, wz = state[W], state[W + 1], state[W + 2]
    gx, gy, gz = (m1 - m2) / m0 * wy * wz, (m2 - m0) / m1 * wz * wx, (m0 - m1) / m2 * wx * wy
    pw, ww = px * wx + py * wy + pz * wz, wx * wx + wy * wy + wz * wz
    for i in range(count):
        j = near[i]
        rx, ry, rz = body.x[j], body.y[j], body.z[j]
        ax, ay, az = ry * pz - rz * py, rz * px - rx * pz, rx * py - ry * px
        load[i, 0], load[i, 1], load[i, 2] = ax, ay, az
        load[i, 3] = (1.0 - pw * (wx * rx + wy * ry + wz * rz)
                      + ww * (px * rx + py * ry + pz * rz) - ax * gx - ay * gy - az * gz)


@inlined
def choose_contact(state: Array, body: DropBody, near: Index, rested: Index, count: int,
                   load: Array, active: Index, contact: Array) -> int:
    """Contact mode of the vertices at rest: none, one, or two that carry the body, or a face.

    Parameters
    ----------
    load : (C, 4) array
        From `weigh`.
    active : (2,) array
        Set to the vertices in contact, -1 where there is none.
    contact : (7,) array
        Set to the vertex, the edge's direction and its length.
    """
    active[0] = active[1] = -1
    most = 0.0
    for i in range(count):
        if rested[i] == 1:
            most = max(most, load[i, 3])
    if most <= PULL:
        return FLIGHT
    still = _still_on_three(state, rested, count)
    m0, m1, m2 = body.moment[0], body.moment[1], body.moment[2]
    for i in range(count):
        if rested[i] == 0 or load[i, 3] <= PULL:
            continue
        bx, by, bz = load[i, 0] / m0, load[i, 1] / m1, load[i, 2] / m2
        force = load[i, 3] / (1.0 + load[i, 0] * bx + load[i, 1] * by + load[i, 2] * bz)
        bx, by, bz = force * bx, force * by, force * bz
        if _carries(near, rested, count, load, i, i, force, bx, by, bz):
            if still and not _lifts(rested, count, load, force, bx, by, bz):
                return FACE
            active[0] = near[i]
            _hold(body, active, contact)
            return VERTEX
    for i in range(count):
        for k in range(i + 1, count):
            if rested[i] == 0 or rested[k] == 0:
                continue
            active[0], active[1] = near[i], near[k]
            _hold(body, active, contact)
            px, py, pz = state[P], state[P + 1], state[P + 2]
            ex, ey, ez, length = contact[3], contact[4], contact[5], contact[6]
            cx, cy, cz = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
            ax, ay, az = load[i, 0], load[i, 1], load[i, 2]
            m11 = 1.0 + ax * ax / m0 + ay * ay / m1 + az * az / m2
            m12 = ax * cx / m0 + ay * cy / m1 + az * cz / m2
            m22 = cx * cx / m0 + cy * cy / m1 + cz * cz / m2
            turn = (load[k, 3] - load[i, 3]) / length
            share = 1.0 / (m11 * m22 - m12 * m12)
            force = share * (m22 * load[i, 3] - m12 * turn)
            torque = share * (m11 * turn - m12 * load[i, 3])
            far = torque / length
            if far < -PULL or force - far < -PULL or not math.isfinite(far):
                continue
            bx, by, bz = ((force * ax + torque * cx) / m0, (force * ay + torque * cy) / m1,
                          (force * az + torque * cz) / m2)
            if _carries(near, rested, count, load, i, k, force, bx, by, bz):
                if still and not _lifts(rested, count, load, force, bx, by, bz):
                    return FACE
                return EDGE
    active[0] = active[1] = -1
    return FACE


@inlined
def _carries(near: Index, rested: Index, count: int, load: Array, first: int, second: int,
             force: float, bx: float, by: float, bz: float) -> bool:
    """No other vertex at rest would sink, the body's acceleration by the forces being given."""
    for k in range(count):
        if rested[k] == 0 or k in (first, second):
            continue
        rise = force + load[k, 0] * bx + load[k, 1] * by + load[k, 2] * bz - load[k, 3]
        if rise < -SINKING:
            return False
    return True


@inlined
def _lifts(rested: Index, count: int, load: Array, force: float, bx: float, by: float,
           bz: float) -> bool:
    """A vertex at rest would rise."""
    for k in range(count):
        rise = force + load[k, 0] * bx + load[k, 1] * by + load[k, 2] * bz - load[k, 3]
        if rested[k] == 1 and rise > SINKING:
            return True
    return False


@inlined
def _still_on_three(state: Array, rested: Index, count: int) -> bool:
    """Three vertices or more are at rest and hold the body still.

    It then rests on the face even where two of them alone could carry it, as across the
    middle of a rectangle.
    """
    if state[V] != 0.0 or state[W] != 0.0 or state[W + 1] != 0.0 or state[W + 2] != 0.0:
        return False
    held = 0
    for i in range(count):
        held += rested[i]
    return held >= 3


@inlined
def _hold(body: DropBody, active: Index, contact: Array) -> None:
    """Vertex, direction and length of the contact."""
    a = active[0]
    contact[0], contact[1], contact[2] = body.x[a], body.y[a], body.z[a]
    b = active[1]
    contact[3] = contact[4] = contact[5] = 0.0
    contact[6] = 1.0
    if b >= 0:
        ex, ey, ez = body.x[b] - body.x[a], body.y[b] - body.y[a], body.z[b] - body.z[a]
        length = math.sqrt(ex * ex + ey * ey + ez * ez)
        contact[3], contact[4], contact[5] = ex / length, ey / length, ez / length
        contact[6] = length


@inlined
def let_go(body: DropBody, active: Index, which: int, contact: Array) -> int:
    """Release one of the vertices in contact; return the mode that is left."""
    if which == 0:
        active[0] = active[1]
    active[1] = -1
    if active[0] < 0:
        return FLIGHT
    _hold(body, active, contact)
    return VERTEX
