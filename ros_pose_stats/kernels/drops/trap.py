"""Which pose a resting body is on its way to, and whether it can still leave it.

With less mechanical energy than the lowest saddle out of the present basin of R the outcome
of a drop is decided (section 4.D's reachable sets, taken one drop at a time).
"""

from __future__ import annotations

import math

from ...tolerances import MOST_GRANTS, PROGRESS, TRAP
from ..array_types import Array
from ..compilation import inlined
from ..vectors import Vec3, cross, dot, minus, read_vector, scaled, times
from .landing import lowest_corner
from .layout import (
    FACE,
    LIMIT,
    LOWEST,
    MODE,
    RESTING,
    SPARE,
    STEPS,
    TRAPPED,
    UNSETTLED,
    DropBody,
    DropRules,
    V,
    Work,
    Z,
    corner_of,
    spin_of,
    up_of,
)


@inlined
def judge_outcome(body: DropBody, rules: DropRules, top: float, work: Work) -> tuple[int, int]:
    """Whether and how the drop has ended, and the pose (-1 while it has not)."""
    resting = work.tally[MODE] == FACE
    if not resting and rules.to_rest:
        return UNSETTLED, -1
    left = energy(work.state, body.moment)
    if not resting and left >= top:
        return UNSETTLED, -1
    pose = pose_below(body, up_of(work.state), work.tally[LOWEST])
    if left < body.way_out[pose] - TRAP and not rules.to_rest:
        return TRAPPED, pose
    if resting:
        return RESTING, pose
    return UNSETTLED, -1


@inlined
def may_go_on(body: DropBody, rules: DropRules, work: Work) -> bool:
    """Whether there are steps left, or the last ones have brought the drop nearer to its end.

    A part that rolls needs steps by the square of its sides, and loses energy with every one;
    one that stands on an edge for ever loses none. No drop takes more than `MOST_GRANTS` times
    as many.
    """
    if work.tally[STEPS] < work.tally[LIMIT]:
        return True
    if work.tally[LIMIT] >= MOST_GRANTS * rules.most_steps:
        return False
    pose = pose_below(body, up_of(work.state), lowest_corner(work.state, body))
    spare = energy(work.state, body.moment) - body.rest[pose]
    if spare > (1.0 - PROGRESS) * work.clock[SPARE]:
        return False
    work.clock[SPARE] = spare
    work.tally[LIMIT] += rules.most_steps
    return True


@inlined
def energy(state: Array, moment: Array) -> float:
    """Mechanical energy z + v²/2 + w . I w / 2, the plate at 0."""
    spin = spin_of(state)
    turning = dot(times(read_vector(moment, 0), spin), spin)
    return float(state[Z] + 0.5 * state[V] * state[V] + 0.5 * turning)


@inlined
def pose_below(body: DropBody, up: Vec3, corner: int) -> int:
    """Pose that a descent in R(u) from u = -up ends in.

    Parameters
    ----------
    corner : int
        The lowest one, so that R(u) = u . r around here.

    Notes
    -----
    Going straight away from r, the direction u - s r leaves the corner's normal cone through
    the side for which s = (u . e) / (r . e) is smallest, among those with r . e < 0. On the
    arc between the normals of the two faces there, R falls away from the foot of the edge,
    to the right-hand face where e . (r x u) > 0. R falls all the way, so no saddle is passed,
    and a body flat on a face is told right whatever rounding does.
    """
    u, r = scaled(up, -1.0), corner_of(body, corner)
    nearest = math.inf
    pose = -1
    for k in range(body.side_start[corner], body.side_start[corner + 1]):
        j = body.side_end[k]
        e = minus(corner_of(body, j), r)
        fall = dot(r, e)
        if fall >= 0.0:
            continue
        s = dot(u, e) / fall
        if s < nearest:
            nearest = s
            right = dot(e, cross(r, u)) > 0.0
            pose = body.side_right[k] if right else body.side_left[k]
    return int(pose)
