"""Which pose a resting body is on its way to, and whether it can still leave it.

With less mechanical energy than the lowest saddle out of the present basin of R the outcome
of a drop is decided (section 4.D's reachable sets, taken one drop at a time).

A body that rolls on a rim keeps the energy of its roll for long, though it does not help it to
tip over: upright and without friction the spin about the rim's axis stays what it is, or turns
into height and back, but for a little at each facet. It is left out there.
"""

import math

from ...tolerances import MOST_GRANTS, PROGRESS, TRAP
from ..array_types import Array
from ..compilation import inlined
from ..vectors import Vec3, cross, dot, minus, read_row, read_vector, scaled, times
from . import layout as at
from .layout import DropBody, DropRules, Work, corner_of, lowest_corner, spin_of, up_of


@inlined
def judge_outcome(body: DropBody, rules: DropRules, top: float, work: Work) -> tuple[int, int]:
    """Whether and how the drop has ended, and the pose (-1 while it has not)."""
    resting = work.tally[at.MODE] == at.FACE
    if not resting and rules.to_rest:
        return at.UNSETTLED, -1
    left = energy(work.state, body.moment)
    rim = _rim_below(body, rules, work, left)
    if not resting and left >= top and rim < 0:
        return at.UNSETTLED, -1
    pose = pose_below(body, up_of(work.state), work.tally[at.LOWEST])
    if not rules.to_rest and (left < body.way_out[pose] - TRAP or pose == rim):
        return at.TRAPPED, pose
    if resting:
        return at.RESTING, pose
    return at.UNSETTLED, -1


@inlined
def _rim_below(body: DropBody, rules: DropRules, work: Work, left: float) -> int:
    """Pose on whose rim the body rolls without energy to tip over, -1 for none.

    The plate moves up and down under a part that rolls on facets. What bounces on a plate that
    moves at random has (1 + e) / (1 - e) times the energy that the plate's own velocity is worth.
    """
    corner = work.tally[at.LOWEST]
    pose = body.roll_pose[corner]
    if pose < 0:
        return -1
    turning = dot(read_row(body.rim, pose, at.AXLE), spin_of(work.state))
    roll = turning * turning + body.roll_climb[corner]
    freed = body.rim[pose, at.BUMPS] * ((1.0 + rules.restitution) / (1.0 - rules.restitution))
    freed = (freed + body.rim[pose, at.SINGLE]) * roll
    stays = left - turning * turning + freed < body.roll_level[corner] - TRAP
    return int(pose) if stays else -1


@inlined
def may_go_on(body: DropBody, rules: DropRules, work: Work) -> bool:
    """Whether there are steps left, or the last ones have brought the drop nearer to its end.

    A part that rolls needs steps by the square of its sides, and loses energy with every one;
    one that stands on an edge for ever loses none. No drop takes more than `MOST_GRANTS` times
    as many.
    """
    if work.tally[at.STEPS] < work.tally[at.LIMIT]:
        return True
    if work.tally[at.LIMIT] >= MOST_GRANTS * rules.most_steps:
        return False
    pose = pose_below(body, up_of(work.state), lowest_corner(work.state, body))
    spare = energy(work.state, body.moment) - body.rest[pose]
    if spare > (1.0 - PROGRESS) * work.clock[at.SPARE]:
        return False
    work.clock[at.SPARE] = spare
    work.tally[at.LIMIT] += rules.most_steps
    return True


@inlined
def energy(state: Array, moment: Array) -> float:
    """Mechanical energy z + v²/2 + w . I w / 2, the plate at 0."""
    spin = spin_of(state)
    turning = dot(times(read_vector(moment, 0), spin), spin)
    return float(state[at.Z] + 0.5 * state[at.V] * state[at.V] + 0.5 * turning)


@inlined
def pose_below(body: DropBody, up: Vec3, corner: int) -> int:
    """Pose that a descent in R(u) from u = -up ends in.

    `corner`: the lowest one, so that R(u) = u . r around here.

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
