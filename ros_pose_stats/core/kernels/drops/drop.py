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

"""Drops from release to a certain outcome, from one event to the next."""

import math
from typing import NamedTuple

from ...tolerances import LONG_DROP, MOST_GRANTS, PROGRESS, TRAP
from ..array_types import Array, Array2, Fixed2, Index, Index2
from ..compilation import entry_kernel, inlined
from ..vectors import Vec3, cross, dot, products, read_row, read_vector, scale, subtract
from . import layout
from .detect import detect_event
from .evolve import LONGEST_STEP, move_to_event, prepare_step
from .resolve import apply_event, resolve_landing


@entry_kernel
def run_drops(
    body: layout.DropBody,
    rules: layout.DropRules,
    releases: Fixed2,
    outcome: Index2,
    measure: Array2,
    tape: Array2,
) -> None:
    """Simulate drops (section 3, appendices A and B).

    `releases` (k, 8): state at release; see `layout`. A body that reaches below the
    plate is lifted onto it; `outcome` (k, 5): filled; see `layout` for its columns. The
    pose is -1 where a drop is unsettled; `measure` (k, 2): filled with duration and
    energy left, in sqrt(radius / g) and m g radius; `tape` (T, 14): filled with the
    events of the last drop from row 1 on; empty for none.
    """
    work = layout.new_work(body.x.shape[0])
    highest_exit = HighestExit(_highest(body.way_out), _highest(body.unit_way_out))
    for i in range(releases.shape[0]):
        _release_body(
            body, rules, releases[i], highest_exit.of_pose, work, outcome[i], tape
        )
        _follow_drop(body, rules, highest_exit, work, outcome[i], measure[i], tape)


class HighestExit(NamedTuple):
    """Levels above which no drop is decided but by a roll."""

    of_pose: float
    of_unit: float  # from `LONG_DROP` on, where poses are drawn


@inlined
def _highest(levels: Array) -> float:
    highest = 0.0
    for level in levels:
        highest = max(highest, level)
    return highest


@inlined
def _release_body(
    body: layout.DropBody,
    rules: layout.DropRules,
    release: Array,
    highest_exit: float,
    work: layout.Work,
    outcome: Index,
    tape: Array,
) -> None:
    """Put the body above the plate, touching it where the height is too low to fit."""
    state = work.state
    tally = work.tally
    for k in range(layout.STATE):
        state[k] = release[k]
    # Where the search for the lowest corner begins decides ties: nothing of the last
    # drop may be left.
    tally[layout.MODE] = layout.FLIGHT
    tally[layout.VERTICES] = 0
    tally[layout.LOWEST] = 0
    tally[layout.EXPECTED] = -1
    tally[layout.IMPACTS] = 0
    tally[layout.EVENTS] = 0
    tally[layout.LIMIT] = rules.most_steps
    work.clock[layout.SPARE] = math.inf
    work.support[0] = work.support[1] = -1
    work.clock[layout.TIME] = 0.0
    work.clock[layout.REACH] = LONGEST_STEP
    work.clock[layout.EXPECTED_LANDING] = math.inf
    outcome[layout.TOUCHED] = 0
    if state[layout.Z] <= max(1.0, highest_exit) + rules.touching:
        tally[layout.LOWEST] = layout.lowest_corner(state, body)
        lowest_height = layout.corner_height(state, body, tally[layout.LOWEST])
        if lowest_height < 0.0:
            state[layout.Z] -= lowest_height
            outcome[layout.TOUCHED] = 1
        for j in range(body.x.shape[0]):
            if layout.corner_height(state, body, j) <= rules.touching:
                work.vertices[tally[layout.VERTICES]] = j
                tally[layout.VERTICES] += 1
    if tape.shape[0] > 0:
        tape[0, 0] = 0.0
    layout.write_tape(work, tape, layout.RELEASE, -1)


@inlined
def _follow_drop(
    body: layout.DropBody,
    rules: layout.DropRules,
    highest_exit: HighestExit,
    work: layout.Work,
    outcome: Index,
    measure: Array,
    tape: Array,
) -> None:
    """Go from event to event until the outcome is certain or steps have run out."""
    tally = work.tally
    has_landed = tally[layout.VERTICES] > 0
    ending, pose = judge_outcome(body, rules, highest_exit, work)
    while ending == layout.UNSETTLED and may_go_on(body, rules, work):
        if has_landed:
            has_landed = not resolve_landing(body, rules, work, tape)
            ending, pose = judge_outcome(body, rules, highest_exit, work)
        if has_landed or ending != layout.UNSETTLED:
            continue
        tally[layout.EVENTS] += 1
        last = prepare_step(body, rules, work)
        if last > 0:  # else it has turned freely, high above the plate
            event = detect_event(body, rules, work, last)
            move_to_event(body, work, last, event)
            has_landed = apply_event(body, rules, work, event, tape)
    outcome[layout.POSE] = pose
    outcome[layout.ENDING] = ending
    outcome[layout.IMPACT_COUNT] = tally[layout.IMPACTS]
    outcome[layout.EVENT_COUNT] = tally[layout.EVENTS]
    measure[layout.DURATION] = work.clock[layout.TIME]
    measure[layout.ENERGY] = energy(work.state, body.moment)
    layout.write_tape(work, tape, layout.END, -1)


@inlined
def judge_outcome(
    body: layout.DropBody,
    rules: layout.DropRules,
    highest_exit: HighestExit,
    work: layout.Work,
) -> tuple[int, int]:
    """Whether and how the drop has ended, and the pose (-1 while it has not)."""
    is_resting = work.tally[layout.MODE] == layout.FACE
    if not is_resting and rules.to_rest:
        return layout.UNSETTLED, -1
    remaining_energy = energy(work.state, body.moment)
    rim = body.corner_rim[work.tally[layout.LOWEST]]
    if (
        rim >= 0
        and not rules.to_rest
        and (rules.draws or body.rim_poses[rim] == 1)
        and remaining_energy < body.rim[rim, layout.RIM_WAY_OUT] - TRAP
        and rolls_upright(body, rules, work, rim, remaining_energy)
    ):
        ending = layout.TRAPPED if body.rim_poses[rim] == 1 else layout.DRAWN
        return ending, int(body.rim_pose[rim])
    may_draw = rules.draws and work.tally[layout.EVENTS] >= LONG_DROP
    level = highest_exit.of_unit if may_draw else highest_exit.of_pose
    if not is_resting and remaining_energy >= level:
        return layout.UNSETTLED, -1
    pose = pose_below(body, layout.up_of(work.state), work.tally[layout.LOWEST])
    if not rules.to_rest and remaining_energy < body.way_out[pose] - TRAP:
        return layout.TRAPPED, pose
    if may_draw and remaining_energy < body.unit_way_out[pose] - TRAP:
        return layout.DRAWN, pose
    if is_resting:
        return layout.RESTING, pose
    return layout.UNSETTLED, -1


@inlined
def rolls_upright(
    body: layout.DropBody,
    rules: layout.DropRules,
    work: layout.Work,
    rim: int,
    total_energy: float,
) -> bool:
    """Whether the body rolls on a rim without the energy to tip over one of its ends.

    A rim is a ring of facets along an axis a. Rolling upright on it the body has w = a
    and v = -s, s = (a x c) . up, with c the corner that it goes over. The rest of its
    velocity is orthogonal to that in the metric of the kinetic energy, so that the
    energies of both add up to the whole. The height of the centre of mass with the axis
    level goes with the roll, too. On a round rim of a body that is alike all round the
    plate's push has no moment about the axle: the energy of the roll is for ever lost
    for tipping, and what is left must reach the rise over an end.
    Facets, and masses beside the axle or askew to it, set some of the roll free, the
    more the faster it can become. The plate moves up and down under a part that rolls
    on facets. What bounces on a plate that moves at random has (1 + e) / (1 - e) times
    the energy that the plate's own velocity is worth. Where the centre of mass goes up
    and down, the weight changes, and the height that the body has tipped by counts for
    more, or less.
    """
    corner = work.tally[layout.LOWEST]
    up = layout.up_of(work.state)
    axle = read_row(body.rim, rim, layout.AXLE)
    lean = dot(axle, up)
    if abs(lean) > body.rim[rim, layout.TILT]:
        return False
    place = layout.corner_of(body, corner)
    level_height = (lean * dot(axle, place) - dot(up, place)) / math.sqrt(
        1.0 - lean * lean
    )
    arm = dot(cross(axle, place), up)
    momentum = dot(products(layout.moments_of(body), axle), layout.spin_of(work.state))
    momentum -= arm * work.state[layout.V]
    roll = 0.5 * momentum * momentum / (body.rim[rim, layout.AXLE_INERTIA] + arm * arm)
    freed = body.rim[rim, layout.BUMPS] * (
        (1.0 + rules.restitution) / (1.0 - rules.restitution)
    )
    freed += body.rim[rim, layout.SINGLE]
    most_roll = roll + max(level_height - body.rim[rim, layout.LOWEST_LEVEL], 0.0)
    across = total_energy - roll - level_height + freed * most_roll
    across *= 1.0 + body.rim[rim, layout.SWING] * most_roll
    return bool(across < body.rim[rim, layout.TIPPING] - TRAP)


@inlined
def may_go_on(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work
) -> bool:
    """Whether there are steps left, or the last ones brought the end nearer.

    A part that rolls needs steps by the square of its sides, and loses energy with
    every one; one that stands on an edge for ever loses none. No drop takes more than
    `MOST_GRANTS` times as many.
    """
    if work.tally[layout.EVENTS] < work.tally[layout.LIMIT]:
        return True
    if work.tally[layout.LIMIT] >= MOST_GRANTS * rules.most_steps:
        return False
    pose = pose_below(
        body, layout.up_of(work.state), layout.lowest_corner(work.state, body)
    )
    spare_energy = energy(work.state, body.moment) - body.pose_level[pose]
    if spare_energy > (1.0 - PROGRESS) * work.clock[layout.SPARE]:
        return False
    work.clock[layout.SPARE] = spare_energy
    work.tally[layout.LIMIT] += rules.most_steps
    return True


@inlined
def energy(state: Array, moment: Array) -> float:
    """Mechanical energy z + v²/2 + w . I w / 2, the plate at 0."""
    spin = layout.spin_of(state)
    rotational = dot(products(read_vector(moment, 0), spin), spin)
    return float(
        state[layout.Z] + 0.5 * state[layout.V] * state[layout.V] + 0.5 * rotational
    )


@inlined
def pose_below(body: layout.DropBody, up: Vec3, corner: int) -> int:
    """Pose that a descent in R(u) from u = -up ends in.

    `corner`: the lowest one, so that R(u) = u . r around here.

    Notes
    -----
    Going straight away from r, the direction u - s r leaves the corner's
    normal cone through the side for which s = (u . e) / (r . e) is smallest, among
    those with r . e < 0. On the arc between the normals of the two faces there, R falls
    away from the foot of the edge, to the right-hand face where e . (r x u) > 0. R
    falls all the way, so no saddle is passed, and a body flat on a face is told right
    whatever rounding does.
    """
    u = scale(up, -1.0)
    r = layout.corner_of(body, corner)
    nearest = math.inf
    pose = -1
    for k in range(body.side_start[corner], body.side_start[corner + 1]):
        j = body.side_end[k]
        e = subtract(layout.corner_of(body, j), r)
        fall = dot(r, e)
        if fall >= 0.0:
            continue
        s = dot(u, e) / fall
        if s < nearest:
            nearest = s
            is_right_hand = dot(e, cross(r, u)) > 0.0
            pose = body.side_right[k] if is_right_hand else body.side_left[k]
    return int(pose)
