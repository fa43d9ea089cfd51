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

"""One drop of a simulation computed again, with its whole motion."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.errors import RequestError
from ..kernels.drops import evolve, layout
from ..mesh.vectors import lengths, resting_quaternions, turn_vectors
from ..records import Array, DropEvent, DropScene, Part, Trajectory
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    GRAVITY,
    is_whole_number,
    real_number,
)
from . import drop_body, drops
from .request import drop_request

STATE_ON_TAPE = slice(layout.TAPE_STATE, layout.TAPE_STATE + layout.STATE)

EVENTS = ("release", "arrival", "impact", "stop", "lift-off", "end")
MODES = ("flight", "vertex", "edge", "face")
FRAMES = 20.0  # samples in a time of sqrt(radius / g), unless an interval is given
FIRST_TAPE = 512
MOST_SAMPLES = 1_000_000


def record_drop(
    part: Part,
    drop: int = 0,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int = 0,
    drop_height: float | None = None,
    start: ArrayLike | None = None,
    to_rest: bool = False,
    interval: float | None = None,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> Trajectory:
    """Record the motion of one drop.

    Parameters
    ----------
    part : Part
    drop : int
        Number of the drop in a simulation by `simulate` with the same arguments; the
        motion is the very same.
    restitution, seed, drop_height, cluster_tolerance, round_sides
        As for `simulate`; take the seed out of its answer.
    start : (3,) array, optional
        Direction in the part frame that points down at release, in place of drop and
        seed.
    to_rest : bool
        Whether to go on, when the pose is certain, until the part lies still. On a
        finely tessellated curve that can be tens of thousands of ever smaller events.
    interval : float, optional
        Seconds between samples; default: a twentieth of sqrt(radius / g).

    Returns
    -------
    Trajectory

    Raises
    ------
    RequestError
        If a value is out of its range.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    return record_scene_drop(
        part,
        DropScene(restitution, drop_height, cluster_tolerance, round_sides),
        seed,
        drop,
        start,
        to_rest,
        interval,
    )


def record_scene_drop(
    part: Part,
    scene: DropScene,
    seed: int,
    drop: int,
    start: ArrayLike | None = None,
    to_rest: bool = False,
    interval: float | None = None,
) -> Trajectory:
    """Record a drop in a scene; see `record_drop`."""
    starts: Any = None if start is None else [start]
    request = drop_request(None if start is None else 1, seed, 0.0, 1, starts)
    if not is_whole_number(drop) or not 0 <= drop < 2**64:
        raise RequestError(
            "the number of a drop, from 0", f"{drop!r}", "0 is the first"
        )
    if interval is not None and not 0.0 < real_number("interval", interval) < math.inf:
        raise RequestError(
            "an interval above 0 s", f"{interval}", "leave it out for a smooth one"
        )
    body = drop_body.drop_body(part, scene)
    downs = request.starts
    if downs is None:
        downs = drops.release_directions(body, request.seed, int(drop), 1)
    tape, outcomes = _record_tape(body, scene, downs, to_rest)
    unit = math.sqrt(body.radius / GRAVITY)
    frame = 1.0 / FRAMES if interval is None else interval / unit
    duration = float(tape[-1, layout.TAPE_TIME])
    if not duration <= MOST_SAMPLES * frame:
        raise RequestError(
            f"at most {MOST_SAMPLES:,} samples of a drop",
            f"{duration * unit:.3g} s with one every {frame * unit:.3g} s",
            "sample it less often",
        )
    times, states, turns = _sample_motion(body, tape, downs[0], frame)
    height = states[:, layout.Z]
    velocity = states[:, layout.V]
    spin = states[:, layout.W : layout.W + 3]
    x, y, z = (body.arrays.moment * spin * spin).T
    energy = height + 0.5 * (velocity * velocity + (x + y + z))
    return Trajectory(
        part_id=part.part_id,
        part_digest=part.digest,
        radius=body.radius,
        restitution=scene.restitution,
        drop_height=scene.release_height(body.radius),
        down=downs[0],
        pose=int(outcomes.pose[0]),
        impacts=int(outcomes.impacts[0]),
        at_rest=bool(not outcomes.trapped[0] and outcomes.pose[0] >= 0),
        events=_read_events(body, tape, unit),
        times=times * unit,
        heights=height * body.radius,
        velocities=velocity * body.radius / unit,
        up=turn_vectors(states[:, layout.P : layout.P + 3], body.axes.T),
        angular_velocities=turn_vectors(spin, body.spin_axes.T) / unit,
        orientations=turns,
        energies=energy * part.mass * GRAVITY * body.radius,
    )


def _record_tape(
    body: drop_body.PreparedBody, scene: DropScene, downs: Array, to_rest: bool
) -> tuple[Array, drops.DropOutcomes]:
    """Compute a drop with a tape that is long enough for all of its events."""
    rules = drops.drop_rules(scene, body.radius, to_rest=to_rest)
    rows = FIRST_TAPE
    while True:
        tape = np.zeros((rows, layout.TAPE))
        outcomes = drops.compute_drops(body, rules, downs, tape)
        row_count = int(tape[0, 0]) + 1
        if row_count <= rows:
            return tape[1:row_count], outcomes
        rows = row_count


def _read_events(
    body: drop_body.PreparedBody, tape: Array, unit: float
) -> tuple[DropEvent, ...]:
    radius = body.radius
    speed = radius / unit
    states = tape[:, STATE_ON_TAPE]
    ups = turn_vectors(states[:, layout.P : layout.P + 3], body.axes.T)
    spins = states[:, layout.W : layout.W + 3] / unit
    spins = turn_vectors(spins, body.spin_axes.T)
    events = []
    for row, state, up, spin in zip(tape, states, ups, spins, strict=True):
        contacts = row[layout.TAPE_CONTACT : layout.TAPE_CONTACT + 2].astype(int)
        vertex = int(row[layout.TAPE_VERTEX])
        events.append(
            DropEvent(
                time=float(row[layout.TAPE_TIME]) * unit,
                kind=EVENTS[int(row[layout.TAPE_EVENT])],
                vertex=int(body.corner[vertex]) if vertex >= 0 else -1,
                mode=MODES[int(row[layout.TAPE_MODE])],
                contact=tuple(int(body.corner[j]) for j in contacts if j >= 0),
                height=float(state[layout.Z]) * radius,
                velocity=float(state[layout.V]) * speed,
                up=up,
                angular_velocity=spin,
            )
        )
    return tuple(events)


def _sample_motion(
    body: drop_body.PreparedBody, tape: Array, down: Array, frame: float
) -> tuple[Array, Array, Array]:
    """Times, states and orientations at the events and between them."""
    turn = resting_quaternions(down[None, :])[0]
    spin_axes = body.spin_axes
    times = [tape[:1, layout.TAPE_TIME]]
    states = [tape[:1, STATE_ON_TAPE]]
    turns = [turn[None, :]]
    for row, next_row in pairwise(tape):
        begin = row[layout.TAPE_TIME]
        span = next_row[layout.TAPE_TIME] - row[layout.TAPE_TIME]
        if span > 0.0:
            inner = np.append(np.arange(1, math.ceil(span / frame)) * frame, span)
            np.minimum(inner, span, out=inner)
            state = np.empty((inner.size, layout.STATE))
            orientation = np.empty((inner.size, 4))
            mode = int(row[layout.TAPE_MODE])
            evolve.sample_motion(
                body.arrays.moment,
                spin_axes,
                mode if mode <= layout.EDGE else layout.FLIGHT,
                _contact_of_row(body, row),
                row[STATE_ON_TAPE].copy(),
                turn,
                inner,
                state,
                orientation,
            )
            turn = orientation[-1]
            # The sum may round up beyond the event.
            times.append(np.minimum(begin + inner, next_row[layout.TAPE_TIME]))
            states.append(state)
            turns.append(orientation)
        times.append(next_row[None, layout.TAPE_TIME])
        states.append(next_row[None, STATE_ON_TAPE])
        turns.append(turn[None, :])
    return np.concatenate(times), np.concatenate(states), np.concatenate(turns)


def _contact_of_row(body: drop_body.PreparedBody, row: Array) -> Array:
    """Vertex, direction of the edge and its length, as the kernels keep them."""
    contact = np.zeros(layout.CONTACT)
    contact[layout.LENGTH] = 1.0
    first, second = row[layout.TAPE_CONTACT : layout.TAPE_CONTACT + 2].astype(int)
    arrays = body.arrays
    if row[layout.TAPE_MODE] >= layout.VERTEX and first >= 0:
        contact[layout.CORNER : layout.CORNER + 3] = (
            arrays.x[first],
            arrays.y[first],
            arrays.z[first],
        )
    if second >= 0:
        end = np.array([arrays.x[second], arrays.y[second], arrays.z[second]])
        edge = end - contact[layout.CORNER : layout.CORNER + 3]
        contact[layout.LENGTH] = lengths(edge[None])[0]
        contact[layout.DIRECTION : layout.DIRECTION + 3] = edge / contact[layout.LENGTH]
    return contact
