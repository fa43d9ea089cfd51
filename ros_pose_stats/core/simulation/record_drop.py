"""One drop of a simulation computed again, with its whole motion, for plots and animations."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.errors import RequestError
from ..kernels.drops import evolve, layout as at
from ..mesh.vectors import lengths, resting_quaternions, turn_vectors
from ..records import Array, DropEvent, DropScene, Part, Trajectory
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    GRAVITY,
    real_number,
)
from . import drop_body, drops
from .request import drop_request

STATE_ON_TAPE = slice(at.TAPE_STATE, at.TAPE_STATE + at.STATE)

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
        Number of the drop in a simulation by `simulate` with the same arguments; the motion is
        the very same.
    restitution, seed, drop_height, cluster_tolerance, round_sides
        As for `simulate`; take the seed out of its answer.
    start : (3,) array, optional
        Direction in the part frame that points down at release, in place of drop and seed.
    to_rest : bool
        Whether to go on, when the pose is certain, until the part lies still. On a finely
        tessellated curve that can be tens of thousands of ever smaller events.
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
    return drop_recorded(
        part,
        DropScene(restitution, drop_height, cluster_tolerance, round_sides),
        seed,
        drop,
        start,
        to_rest,
        interval,
    )


def drop_recorded(
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
    whole = isinstance(drop, (int, np.integer)) and not isinstance(drop, bool)
    if not whole or not 0 <= drop < 2**64:
        raise RequestError(
            "the number of a drop, from 0", f"{drop!r}", "0 is the first"
        )
    if interval is not None and not 0.0 < real_number("interval", interval) < math.inf:
        raise RequestError(
            "an interval above 0 s", f"{interval}", "leave it out for a smooth one"
        )
    body = drop_body.drop_body(part, scene)
    down = (
        drops.random_starts(request.seed, int(drop), 1)
        if request.starts is None
        else request.starts
    )
    tape, outcomes = _record_tape(body, scene, down, to_rest)
    unit = math.sqrt(body.radius / GRAVITY)
    frame = 1.0 / FRAMES if interval is None else interval / unit
    duration = float(tape[-1, at.TAPE_TIME])
    if not duration <= MOST_SAMPLES * frame:
        raise RequestError(
            f"at most {MOST_SAMPLES:,} samples of a drop",
            f"{duration * unit:.3g} s with one every {frame * unit:.3g} s",
            "sample it less often",
        )
    times, states, turns = _samples(body, tape, down[0], frame)
    spin = states[:, at.W : at.W + 3]
    x, y, z = (body.arrays.moment * spin * spin).T
    energy = (
        (states[:, at.Z] + 0.5 * (states[:, at.V] * states[:, at.V] + (x + y + z)))
        * part.mass
        * GRAVITY
        * body.radius
    )
    return Trajectory(
        part.part_id,
        part.digest,
        body.radius,
        scene.restitution,
        scene.release_height(body.radius),
        down[0],
        int(outcomes.pose[0]),
        int(outcomes.impacts[0]),
        bool(not outcomes.trapped[0] and outcomes.pose[0] >= 0),
        _events(body, tape, unit),
        times * unit,
        states[:, at.Z] * body.radius,
        states[:, at.V] * body.radius / unit,
        turn_vectors(states[:, at.P : at.P + 3], body.axes.T),
        turn_vectors(states[:, at.W : at.W + 3], body.axes.T) / unit,
        turns,
        energy,
    )


def _record_tape(
    body: drop_body.PreparedBody, scene: DropScene, down: Array, to_rest: bool
) -> tuple[Array, drops.DropOutcomes]:
    """Compute a drop with a tape that is long enough for all of its events."""
    rules = drops.drop_rules(scene, body.radius, to_rest=to_rest)
    rows = FIRST_TAPE
    while True:
        tape = np.zeros((rows, at.TAPE))
        outcomes = drops.compute_drops(body, rules, down, tape)
        wanted = int(tape[0, 0]) + 1
        if wanted <= rows:
            return tape[1:wanted], outcomes
        rows = wanted


def _events(
    body: drop_body.PreparedBody, tape: Array, unit: float
) -> tuple[DropEvent, ...]:
    speed = body.radius / unit
    found = []
    for row in tape:
        state = row[STATE_ON_TAPE]
        held = row[at.TAPE_CONTACT : at.TAPE_CONTACT + 2].astype(int)
        vertex = int(row[at.TAPE_VERTEX])
        found.append(
            DropEvent(
                float(row[at.TAPE_TIME]) * unit,
                EVENTS[int(row[at.TAPE_EVENT])],
                int(body.corner[vertex]) if vertex >= 0 else -1,
                MODES[int(row[at.TAPE_MODE])],
                tuple(int(body.corner[j]) for j in held if j >= 0),
                float(state[at.Z]) * body.radius,
                float(state[at.V]) * speed,
                *turn_vectors(
                    np.stack((state[at.P : at.P + 3], state[at.W : at.W + 3] / unit)),
                    body.axes.T,
                ),
            )
        )
    return tuple(found)


def _samples(
    body: drop_body.PreparedBody, tape: Array, down: Array, frame: float
) -> tuple[Array, Array, Array]:
    """Times, states and orientations at the events and between them."""
    turn = resting_quaternions(down[None, :])[0]
    times = [tape[:1, at.TAPE_TIME]]
    states = [tape[:1, STATE_ON_TAPE]]
    turns = [turn[None, :]]
    for before, after in pairwise(tape):
        begin = before[at.TAPE_TIME]
        span = after[at.TAPE_TIME] - before[at.TAPE_TIME]
        if span > 0.0:
            inner = np.append(np.arange(1, math.ceil(span / frame)) * frame, span)
            np.minimum(inner, span, out=inner)
            state = np.empty((inner.size, at.STATE))
            orientation = np.empty((inner.size, 4))
            mode = int(before[at.TAPE_MODE])
            evolve.sample_motion(
                body.arrays.moment,
                body.axes,
                mode if mode <= at.EDGE else at.FLIGHT,
                _contact(body, before),
                before[STATE_ON_TAPE].copy(),
                turn,
                inner,
                state,
                orientation,
            )
            turn = orientation[-1]
            # The sum may round up beyond the event.
            times.append(np.minimum(begin + inner, after[at.TAPE_TIME]))
            states.append(state)
            turns.append(orientation)
        times.append(after[None, at.TAPE_TIME])
        states.append(after[None, STATE_ON_TAPE])
        turns.append(turn[None, :])
    return np.concatenate(times), np.concatenate(states), np.concatenate(turns)


def _contact(body: drop_body.PreparedBody, row: Array) -> Array:
    """Vertex, direction of the edge and its length, as the kernels keep them."""
    contact = np.zeros(at.CONTACT)
    contact[at.LENGTH] = 1.0
    first, second = row[at.TAPE_CONTACT : at.TAPE_CONTACT + 2].astype(int)
    arrays = body.arrays
    if row[at.TAPE_MODE] >= at.VERTEX and first >= 0:
        contact[at.CORNER : at.CORNER + 3] = (
            arrays.x[first],
            arrays.y[first],
            arrays.z[first],
        )
    if second >= 0:
        end = np.array([arrays.x[second], arrays.y[second], arrays.z[second]])
        edge = end - contact[at.CORNER : at.CORNER + 3]
        contact[at.LENGTH] = lengths(edge[None])[0]
        contact[at.DIRECTION : at.DIRECTION + 3] = edge / contact[at.LENGTH]
    return contact
