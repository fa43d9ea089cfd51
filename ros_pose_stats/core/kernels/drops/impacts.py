"""Impacts, and what ends an infinite series of them.

Simultaneous impacts are a sequence of single ones, each at the vertex that approaches
fastest (section 3.D). Where all touching vertices are slow, the rest of the series is
replaced by impulses that stop them (appendix B).
"""

import math
from typing import NamedTuple

from ...tolerances import DEPENDENT
from .. import vectors as vec
from ..array_types import Array
from ..compilation import inlined
from . import layout as at


class Velocity(NamedTuple):
    """A velocity of the body."""

    rise: float  # of the centre of mass
    spin: vec.Vec3


@inlined
def vertex_velocity(state: Array, r: vec.Vec3) -> float:
    """Vertical velocity v + w . (r x p) of a vertex."""
    return vec.dot_from(state[at.V], at.spin_of(state), vec.cross(r, at.up_of(state)))


@inlined
def strike(
    state: Array, moment: Array, r: vec.Vec3, speed: float, restitution: float
) -> None:
    """One impact at a vertex that moves at `speed` < 0.

    The impulse is -(1 + restitution) u / (1/m + a . I^-1 a) with a = r x p.
    """
    arm = vec.cross(r, at.up_of(state))
    reply = vec.over(arm, vec.read_vector(moment, 0))
    impulse = -(1.0 + restitution) * speed / vec.dot_from(1.0, arm, reply)
    state[at.V] += impulse
    vec.write_vector(
        state, at.W, vec.plus(at.spin_of(state), vec.scaled(reply, impulse))
    )


@inlined
def stop_slow(body: at.DropBody, rules: at.DropRules, work: at.Work) -> None:
    """Bring the slow touching vertices to rest, and tell in `rested` which have been.

    Works on the velocity (v, w) in the metric of the kinetic energy: the component along
    each contact in turn, made orthogonal to those before it, is taken out. A contact is left
    out where this would cost more energy than `soft`, or than a share of what moves the body: its
    vertex is slow only because it is close to another one on a body that turns.

    The touching vertices are sorted by rising velocity.
    """
    state = work.state
    rested = work.rested
    moment = at.moments_of(body)
    motion = Velocity(state[at.V], at.spin_of(state))
    most = max(rules.soft, rules.soft_share * 0.5 * _product(motion, motion, moment))
    rank = 0
    for i in range(work.tally[at.NEAR]):
        rested[i] = 0
        if abs(work.speed[i]) > rules.slow:
            continue
        # The constraint as a velocity: the direction in which an impulse changes (v, w).
        arm = vec.cross(at.corner_of(body, work.near[i]), at.up_of(state))
        given = Velocity(1.0, vec.over(arm, moment))
        left = _orthogonal(given, work.frame, rank, moment)
        square = _product(left, left, moment)
        if rank == 3 or square < DEPENDENT * DEPENDENT * _product(given, given, moment):
            rested[i] = 1
            continue
        scale = 1.0 / math.sqrt(square)
        unit = Velocity(left.rise * scale, vec.scaled(left.spin, scale))
        along = _product(unit, Velocity(state[at.V], at.spin_of(state)), moment)
        if 0.5 * along * along > most:
            continue
        state[at.V] -= along * unit.rise
        vec.write_vector(
            state, at.W, vec.minus(at.spin_of(state), vec.scaled(unit.spin, along))
        )
        work.frame[rank, at.RISE] = unit.rise
        vec.write_row(work.frame, rank, at.SPIN, unit.spin)
        rank += 1
        rested[i] = 1
    if (
        rank == 3
    ):  # three contacts leave a turn about the vertical only, which never starts
        state[at.V] = 0.0
        vec.write_vector(state, at.W, vec.Vec3(0.0, 0.0, 0.0))


@inlined
def _product(a: Velocity, b: Velocity, moment: vec.Vec3) -> float:
    """Scalar product of two velocities in the metric of the kinetic energy."""
    return vec.dot_from(a.rise * b.rise, vec.times(moment, a.spin), b.spin)


@inlined
def _orthogonal(given: Velocity, frame: Array, rank: int, moment: vec.Vec3) -> Velocity:
    """What is left of a velocity without its components along the first rows of the frame."""
    left = given
    for _ in range(2):  # twice is enough to be orthogonal to rounding
        for k in range(rank):
            unit = Velocity(frame[k, at.RISE], vec.read_row(frame, k, at.SPIN))
            along = _product(left, unit, moment)
            left = Velocity(
                left.rise - along * unit.rise,
                vec.minus(left.spin, vec.scaled(unit.spin, along)),
            )
    return left
