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

"""Where the numbers of a drop stand in the arrays that the kernels share.

A state holds the height and velocity of the centre of mass, the vertical direction `up`
(p: the last row of the paper's R) and the angular velocity (w), both in principal axes.
The motion over one step is a power series in the fraction of the step: row k of
`series` holds the k-th coefficients, the angular velocity multiplied by the step.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Array1, Array2, Index, Index1, Index2
from ..compilation import inlined, kernel
from ..vectors import Vec3, dot_from, read_vector

# state (8,)
Z = 0
V = 1
P = 2  # 2, 3, 4
W = 5  # 5, 6, 7
STATE = 8

# columns of the series; those from FORCE on are filled while sliding only
WS = 0  # 0, 1, 2: angular velocity times the step
PS = 3  # 3, 4, 5: up
ZS = 6  # height
FORCE = 7  # sum of the contact forces times the step squared
TORQUE = 8  # the second force times the length of the edge, likewise
COLUMNS = 32

ORDER = 16
"""Highest power of the step; longer steps do not pay for the longer sums."""

# contact modes
FLIGHT = 0
VERTEX = 1
EDGE = 2
FACE = 3

# how a drop ended
UNSETTLED = 0
TRAPPED = 1
RESTING = 2
DRAWN = 3  # on one of several poses that are equally probable, still to be drawn

# contact (7,)
CORNER = 0  # 0, 1, 2: a vertex
DIRECTION = 3  # 3, 4, 5: direction of the edge, 0 for none
LENGTH = 6  # of the edge, 1 for none
CONTACT = 7

# tally (8,)
MODE = 0
VERTICES = 1  # touching vertices in `near`
IMPACTS = 2
EVENTS = 3  # impacts and steps
LOWEST = 4  # a low corner, where the last event was
SEARCH = 5  # number of the last search
LIMIT = 6  # of EVENTS, where the drop is given up or granted more
EXPECTED = 7  # neighbour that it is expected to roll on to, -1 for none
TALLY = 8

# clock (5,)
TIME = 0
STEP = 1  # the step that the series is for
EXPECTED_LANDING = 2  # time in which the next one is expected
REACH = 3  # length of the last sliding step
SPARE = 4  # energy above the pose below, when steps were last granted
CLOCK = 5

# columns of the load (C, 4) of a touching vertex
ARM = 0  # 0, 1, 2: a = r x p, the reach of a force there
FALL = 3  # its downward acceleration in free motion
LOAD = 4

# columns of the frame (3, 4): velocities of the body, orthogonal in the energy's metric
RISE = 0  # of the centre of mass
SPIN = 1  # 1, 2, 3: angular velocity
FRAME = 4

# columns of the balls (B, 4) and their ranges (B, 3)
BALL_CENTRE = 0  # 0, 1, 2
BALL_RADIUS = 3
BALL_BEGIN = 0  # first corner
BALL_END = 1  # last corner + 1
BALL_NEXT = 2  # node that follows the subtree

# columns of the rims (R, 11)
AXLE = 0  # 0, 1, 2: direction of its axis
AXLE_INERTIA = 3  # moment of inertia about the axis through the centre of mass
TILT = 4  # sine of the tilt at which the body tips over an end
TIPPING = 5  # energy besides the roll's that tips it over an end, at least
LOWEST_LEVEL = 6  # height of the centre of mass on the lowest facet
BUMPS = 7  # share of a roll's energy that going on from facet to facet keeps free
SINGLE = 8  # share that one facet, or an axis askew to the principal ones, sets free
SWING = 9  # by how much a unit of a roll's energy multiplies that besides it, at most
RIM_WAY_OUT = 10  # level of the edges over which a roll leaves it, infinite for none
RIM = 11

# columns of an outcome (k, 5) and its measures (k, 2)
POSE = 0
ENDING = 1
IMPACT_COUNT = 2
EVENT_COUNT = 3
TOUCHED = 4  # 1 where it was released touching the plate
DURATION = 0
ENERGY = 1

# what a row of the tape says has just happened
RELEASE = 0
ARRIVAL = 1  # a vertex reaches the plate
IMPACT = 2
STOP = 3  # slow vertices have been brought to rest
LIFT_OFF = 4  # a contact force has come down to 0
END = 5

# columns of the tape (T, 14)
TAPE_TIME = 0
TAPE_STATE = 1  # 1 ... 8
TAPE_EVENT = 9
TAPE_VERTEX = 10
TAPE_MODE = 11
TAPE_CONTACT = 12  # 12, 13: the vertices in contact, -1 for none
TAPE = 14


class DropBody(NamedTuple):
    """What a drop needs of a part; corners in the order of the ball tree's leaves."""

    x: Array1  # (C,) corners in principal axes about the centre of mass, in radii
    y: Array1
    z: Array1
    moment: Array1  # (3,) principal moments of inertia of unit mass, rising
    ball: Array2  # (B, 4)
    ball_range: Index2  # (B, 3)
    neighbour_start: Index1  # (C + 1,) neighbours of each corner along edges
    neighbour: Index1  # (E,) corner; both are empty for bodies of one ball
    neighbour_distance: Array1  # (E,) distance to it
    side_start: Index1  # (C + 1,) sides that leave a corner
    side_end: Index1  # (N,) corner at the far end
    side_left: Index1  # (N,) pose that the face to the left of a side descends to
    side_right: Index1  # (N,)
    pose_level: Array1  # (P,) level of each pose
    way_out: Array1  # (P,) level of the saddle that leads out of it
    unit_way_out: Array1  # (P,) that out of all poses as probable as it by symmetry
    rim: Array2  # (R, 11) what a rim does to a roll, see RIM
    rim_pose: Index1  # (R,) a pose that it has
    rim_poses: Index1  # (R,) how many it has
    corner_rim: Index1  # (C,) rim that a corner is on, -1 for none
    turn_limit: float  # radians by which a step near the plate turns the body at most


class DropRules(NamedTuple):
    """Scene and thresholds; `core.tolerances` gives their values and reasons."""

    restitution: float
    height: float  # of the centre of mass where it is released at rest, radii
    to_rest: bool  # go on when the outcome is decided
    draws: bool  # end where what remains is to draw one of equally probable poses
    truncation: float
    touching: float
    slow: float
    soft: float
    soft_share: float
    most_steps: int  # without progress


class Work(NamedTuple):
    """Scratch of a run of drops."""

    state: Array  # (8,)
    series: Array  # (ORDER + 1, COLUMNS)
    polynomial: Array  # (ORDER + 1,)
    local_polynomial: Array  # (ORDER + 1,)
    contact: Array  # (7,)
    frame: Array  # (3, 4)
    clock: Array  # (5,)
    tally: Index  # (8,)
    support: Index  # (2,) vertices in contact, -1 for none
    vertices: Index  # (C,) touching vertices
    rest_order: Index  # (C,) 1 where one has been brought to rest, 2 if released
    speed: Array  # (C,) their vertical velocities
    load: Array  # (C, 4)
    candidates: Index  # (C,) corners that may land during a step
    landing_bound: Array  # (C,) fraction of the step before which each of them does not
    queue: Index  # (C,)
    last_search: Index  # (C,) last search that came by a corner


@kernel
def new_work(corners: int) -> Work:
    """Scratch for a body of that many corners."""
    return Work(
        state=np.zeros(STATE),
        series=np.zeros((ORDER + 1, COLUMNS)),
        polynomial=np.zeros(ORDER + 1),
        local_polynomial=np.zeros(ORDER + 1),
        contact=np.zeros(CONTACT),
        frame=np.zeros((3, FRAME)),
        clock=np.zeros(CLOCK),
        tally=np.zeros(TALLY, np.int64),
        support=np.full(2, -1),
        vertices=np.zeros(corners, np.int64),
        rest_order=np.zeros(corners, np.int64),
        speed=np.zeros(corners),
        load=np.zeros((corners, LOAD)),
        candidates=np.zeros(corners, np.int64),
        landing_bound=np.zeros(corners),
        queue=np.zeros(corners, np.int64),
        last_search=np.zeros(corners, np.int64),
    )


@inlined
def corner_of(body: DropBody, j: int) -> Vec3:
    """Where a corner is in principal axes."""
    return Vec3(body.x[j], body.y[j], body.z[j])


@inlined
def moments_of(body: DropBody) -> Vec3:
    """Principal moments of inertia of unit mass."""
    return read_vector(body.moment, 0)


@inlined
def up_of(state: Array) -> Vec3:
    """Vertical direction."""
    return read_vector(state, P)


@inlined
def spin_of(state: Array) -> Vec3:
    """Angular velocity."""
    return read_vector(state, W)


@inlined
def coupling_of(moment: Array) -> Vec3:
    """Factors of w2 w3, w3 w1 and w1 w2 in the angular acceleration I^-1 (I w) x w."""
    return Vec3(
        (moment[1] - moment[2]) / moment[0],
        (moment[2] - moment[0]) / moment[1],
        (moment[0] - moment[1]) / moment[2],
    )


@inlined
def corner_height(state: Array, body: DropBody, j: int) -> float:
    """Height z + p . r of a corner above the plate."""
    return dot_from(state[Z], corner_of(body, j), up_of(state))


@inlined
def lowest_corner(state: Array, body: DropBody) -> int:
    """Lowest of all corners, the first of several."""
    low = math.inf
    lowest = 0
    for j in range(body.x.shape[0]):
        height = corner_height(state, body, j)
        if height < low:
            low = height
            lowest = j
    return lowest


@inlined
def write_tape(work: Work, tape: Array, event: int, vertex: int) -> None:
    """Add a row; on a tape without rows or at its end nothing is kept.

    Row 0 holds the number of rows wanted so far, so that the caller can come back with
    a longer tape. The contact mode is that before the event; `write_tape_contact` puts
    it right.
    """
    if tape.shape[0] == 0:
        return
    tape[0, 0] += 1.0
    row = int(tape[0, 0])
    if row >= tape.shape[0]:
        return
    tape[row, TAPE_TIME] = work.clock[TIME]
    for i in range(STATE):
        tape[row, TAPE_STATE + i] = work.state[i]
    tape[row, TAPE_EVENT] = event
    tape[row, TAPE_VERTEX] = vertex
    write_tape_contact(work, tape)


@inlined
def write_tape_contact(work: Work, tape: Array) -> None:
    """Correct the contact mode of the last row."""
    if tape.shape[0] == 0:
        return
    row = int(tape[0, 0])
    if row < tape.shape[0]:
        mode = work.tally[MODE]
        tape[row, TAPE_MODE] = mode
        tape[row, TAPE_CONTACT] = work.support[0] if mode > 0 else -1
        tape[row, TAPE_CONTACT + 1] = work.support[1] if mode > 1 else -1
