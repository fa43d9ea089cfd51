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

"""Impacts, and what ends an infinite series of them.

Simultaneous impacts are a sequence of single ones, each at the vertex that approaches
fastest (section 3.D). Where all touching vertices are slow, the rest of the series is
replaced by impulses that stop them (appendix B).
"""

import math
from typing import NamedTuple

from ...tolerances import DEPENDENT
from ..array_types import Array
from ..compilation import inlined
from ..vectors import (
    Vec3,
    add,
    cross,
    dot_from,
    products,
    quotients,
    read_row,
    read_vector,
    scale,
    subtract,
    write_row,
    write_vector,
)
from . import layout


class Velocity(NamedTuple):
    """A velocity of the body."""

    rise: float  # of the centre of mass
    spin: Vec3


@inlined
def vertex_velocity(state: Array, r: Vec3) -> float:
    """Vertical velocity v + w . (r x p) of a vertex."""
    return dot_from(
        state[layout.V], layout.spin_of(state), cross(r, layout.up_of(state))
    )


@inlined
def strike_vertex(
    state: Array, moment: Array, r: Vec3, speed: float, restitution: float
) -> None:
    """One impact at a vertex that moves at `speed` < 0.

    The impulse is -(1 + restitution) u / (1/m + a . I^-1 a) with a = r x p.
    """
    arm = cross(r, layout.up_of(state))
    response = quotients(arm, read_vector(moment, 0))
    impulse = -(1.0 + restitution) * speed / dot_from(1.0, arm, response)
    state[layout.V] += impulse
    write_vector(state, layout.W, add(layout.spin_of(state), scale(response, impulse)))


@inlined
def stop_slow_vertices(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work
) -> None:
    """Bring the slow touching vertices to rest, and mark them in `rest_order`.

    Works on the velocity (v, w) in the metric of the kinetic energy: the component
    along each contact in turn, made orthogonal to those before it, is taken out. A
    contact is left out where this would cost more energy than `soft`, or than a share
    of what moves the body: its vertex is slow only because it is close to another one
    on a body that turns.

    The touching vertices are sorted by rising velocity.
    """
    state = work.state
    rested = work.rest_order
    moment = layout.moments_of(body)
    velocity = Velocity(state[layout.V], layout.spin_of(state))
    largest_cost = max(
        rules.soft, rules.soft_share * 0.5 * _product(velocity, velocity, moment)
    )
    rank = 0
    for i in range(work.tally[layout.VERTICES]):
        rested[i] = 0
        if abs(work.speed[i]) > rules.slow:
            continue
        # The constraint as a velocity: the direction in which an impulse changes it.
        arm = cross(layout.corner_of(body, work.vertices[i]), layout.up_of(state))
        constraint = Velocity(1.0, quotients(arm, moment))
        remainder = _orthogonal(constraint, work.frame, rank, moment)
        square = _product(remainder, remainder, moment)
        if rank == 3 or square < DEPENDENT * DEPENDENT * _product(
            constraint, constraint, moment
        ):
            rested[i] = 1
            continue
        inverse_length = 1.0 / math.sqrt(square)
        unit = Velocity(
            remainder.rise * inverse_length, scale(remainder.spin, inverse_length)
        )
        component = _product(
            unit, Velocity(state[layout.V], layout.spin_of(state)), moment
        )
        if 0.5 * component * component > largest_cost:
            continue
        state[layout.V] -= component * unit.rise
        write_vector(
            state,
            layout.W,
            subtract(layout.spin_of(state), scale(unit.spin, component)),
        )
        work.frame[rank, layout.RISE] = unit.rise
        write_row(work.frame, rank, layout.SPIN, unit.spin)
        rank += 1
        rested[i] = 1
    if rank == 3:
        # Three contacts leave a turn about the vertical only, which never starts.
        state[layout.V] = 0.0
        write_vector(state, layout.W, Vec3(0.0, 0.0, 0.0))


@inlined
def _product(a: Velocity, b: Velocity, moment: Vec3) -> float:
    """Scalar product of two velocities in the metric of the kinetic energy."""
    return dot_from(a.rise * b.rise, products(moment, a.spin), b.spin)


@inlined
def _orthogonal(velocity: Velocity, frame: Array, rank: int, moment: Vec3) -> Velocity:
    """A velocity without its components along the first rows of the frame."""
    remainder = velocity
    for _ in range(2):  # twice is enough to be orthogonal to rounding
        for k in range(rank):
            unit = Velocity(frame[k, layout.RISE], read_row(frame, k, layout.SPIN))
            component = _product(remainder, unit, moment)
            remainder = Velocity(
                remainder.rise - component * unit.rise,
                subtract(remainder.spin, scale(unit.spin, component)),
            )
    return remainder
