"""Impacts, and what ends an infinite series of them.

Simultaneous impacts are a sequence of single ones, each at the vertex that approaches
fastest (section 3.D). Where all touching vertices are slow, the rest of the series is
replaced by impulses that stop them (appendix B).
"""

from __future__ import annotations

import math

from ...tolerances import DEPENDENT
from ..compilation import inlined
from .layout import Array, DropBody, Index, P, V, W


@inlined
def vertex_velocity(state: Array, rx: float, ry: float, rz: float) -> float:
    """Vertical velocity v + w . (r x p) of a vertex."""
    px, py, pz = state[P], state[P + 1], state[P + 2]
    return float(state[V] + state[W] * (ry * pz - rz * py) + state[W + 1] * (rz * px - rx * pz)
                 + state[W + 2] * (rx * py - ry * px))


@inlined
def strike(state: Array, moment: Array, rx: float, ry: float, rz: float, speed: float,
           restitution: float) -> None:
    """One impact at a vertex that moves at `speed` < 0.

    The impulse is -(1 + restitution) u / (1/m + a . I^-1 a) with a = r x p.
    """
    px, py, pz = state[P], state[P + 1], state[P + 2]
    ax, ay, az = ry * pz - rz * py, rz * px - rx * pz, rx * py - ry * px
    bx, by, bz = ax / moment[0], ay / moment[1], az / moment[2]
    impulse = -(1.0 + restitution) * speed / (1.0 + ax * bx + ay * by + az * bz)
    state[V] += impulse
    state[W] += impulse * bx
    state[W + 1] += impulse * by
    state[W + 2] += impulse * bz


@inlined
def stop_slow(state: Array, body: DropBody, near: Index, speed: Array, count: int,
              slow: float, soft: float, rested: Index, frame: Array) -> None:
    """Bring the slow touching vertices to rest.

    Works on the velocity (v, w) in the metric of the kinetic energy: the component along
    each contact in turn, made orthogonal to those before it, is taken out. A contact is left
    out where this would cost more energy than `soft`: its vertex is slow only because it is
    close to another one on a body that turns.

    Parameters
    ----------
    near : (C,) array
        The first `count` are touching; they are sorted by rising velocity.
    rested : (C,) array
        Set to 1 where a vertex has been brought to rest, else to 0.
    frame : (3, 4) array
        Scratch.
    """
    rank = 0
    mx, my, mz = body.moment[0], body.moment[1], body.moment[2]
    for i in range(count):
        rested[i] = 0
        if abs(speed[i]) > slow:
            continue
        j = near[i]
        px, py, pz = state[P], state[P + 1], state[P + 2]
        rx, ry, rz = body.x[j], body.y[j], body.z[j]
        # The constraint as a velocity: the direction in which an impulse changes (v, w).
        d0 = 1.0
        d1, d2, d3 = (ry * pz - rz * py) / mx, (rz * px - rx * pz) / my, (rx * py - ry * px) / mz
        full = d0 * d0 + mx * d1 * d1 + my * d2 * d2 + mz * d3 * d3
        for _ in range(2):  # twice is enough to be orthogonal to rounding
            for k in range(rank):
                f0, f1, f2, f3 = frame[k, 0], frame[k, 1], frame[k, 2], frame[k, 3]
                along = d0 * f0 + mx * d1 * f1 + my * d2 * f2 + mz * d3 * f3
                d0, d1, d2, d3 = d0 - along * f0, d1 - along * f1, d2 - along * f2, d3 - along * f3
        size = d0 * d0 + mx * d1 * d1 + my * d2 * d2 + mz * d3 * d3
        if rank == 3 or size < DEPENDENT * DEPENDENT * full:
            rested[i] = 1
            continue
        scale = 1.0 / math.sqrt(size)
        d0, d1, d2, d3 = d0 * scale, d1 * scale, d2 * scale, d3 * scale
        along = (d0 * state[V] + mx * d1 * state[W] + my * d2 * state[W + 1]
                 + mz * d3 * state[W + 2])
        if 0.5 * along * along > soft:
            continue
        state[V] -= along * d0
        state[W] -= along * d1
        state[W + 1] -= along * d2
        state[W + 2] -= along * d3
        frame[rank, 0], frame[rank, 1], frame[rank, 2], frame[rank, 3] = d0, d1, d2, d3
        rank += 1
        rested[i] = 1
    if rank == 3:  # three contacts leave a turn about the vertical only, which never starts
        state[V] = 0.0
        state[W] = state[W + 1] = state[W + 2] = 0.0
