"""One drop of a simulation computed again, with its whole motion, for plots and animations."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import RequestError
from ..kernels.drops.evolve import sample_motion
from ..kernels.drops.layout import (
    ALONG,
    CONTACT,
    CORNER,
    EDGE,
    FLIGHT,
    LENGTH,
    STATE,
    TAPE,
    TAPE_CONTACT,
    TAPE_EVENT,
    TAPE_MODE,
    TAPE_STATE,
    TAPE_TIME,
    TAPE_VERTEX,
    VERTEX,
    P,
    V,
    W,
    Z,
)
from ..mesh.vectors import lengths, turn_vectors
from ..records import DropEvent, DropScene, Part, Trajectory
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    GRAVITY,
)
from ..resting.orientation import resting_quaternions
from .drop_body import PreparedBody, drop_body
from .drops import DropOutcomes, compute_drops, drop_rules, release_height
from .request import drop_request, real_number
from .starts import random_starts

Array = NDArray[np.float64]

STATE_ON_TAPE = slice(TAPE_STATE, TAPE_STATE + STATE)

EVENTS = ("release", "arrival", "impact", "stop", "lift-off", "end")
MODES = ("flight", "vertex", "edge", "face")

FRAMES = 20.0
"""Samples in a time of sqrt(radius / g), unless an interval is given."""

FIRST_TAPE = 512


def record_drop(part: Part, drop: int = 0, restitution: float = DEFAULT_RESTITUTION,
                seed: int = 0, drop_height: float | None = None,
                start: ArrayLike | None = None, to_rest: bool = False,
                interval: float | None = None, *,
                cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
                round_sides: int = DEFAULT_ROUND_SIDES) -> Trajectory:
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
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    request = drop_request(None if start is None else 1, seed, 0.0, 1, _as_row(start))
    if isinstance(drop, bool) or not isinstance(drop, (int, np.integer)) or drop < 0:
        raise RequestError("the number of a drop, from 0", f"{drop!r}", "0 is the first")
    if interval is not None and not 0.0 < real_number("interval", interval) < math.inf:
        raise RequestError("an interval above 0 s", f"{interval}", "leave it out for a smooth one")
    body = drop_body(part, scene.cluster_tolerance, scene.round_sides)
    down = (random_starts(request.seed, int(drop), 1) if request.starts is None
            else request.starts)
    tape, outcomes = _record_tape(body, scene, down, to_rest)
    unit = math.sqrt(body.radius / GRAVITY)
    frame = 1.0 / FRAMES if interval is None else interval / unit
    times, states, turns = _samples(body, tape, down[0], frame)
    energy = _energy(body.arrays.moment, states) * part.mass * GRAVITY * body.radius
    return Trajectory(
        part.part_id, part.digest, body.radius, scene.restitution,
        release_height(scene, body.radius), down[0], int(outcomes.pose[0]),
        int(outcomes.impacts[0]), bool(not outcomes.trapped[0] and outcomes.pose[0] >= 0),
        _events(body, tape, unit), times * unit, states[:, Z] * body.radius,
        states[:, V] * body.radius / unit, turn_vectors(states[:, P:P + 3], body.axes.T),
        turn_vectors(states[:, W:W + 3], body.axes.T) / unit, turns, energy)


def _as_row(start: ArrayLike | None) -> ArrayLike | None:
    """The start as the only row of an array."""
    if start is None:
        return None
    if np.ndim(start) != 1:
        raise RequestError("one start as three numbers", f"shape {np.shape(start)}",
                           "record one drop at a time")
    return np.asarray(start)[None, :]


def _record_tape(body: PreparedBody, scene: DropScene, down: Array,
                 to_rest: bool) -> tuple[Array, DropOutcomes]:
    """Compute a drop with a tape that is long enough for all of its events."""
    rules = drop_rules(scene, body.radius, to_rest=to_rest)
    rows = FIRST_TAPE
    while True:
        tape = np.zeros((rows, TAPE))
        outcomes = compute_drops(body, rules, down, tape)
        wanted = int(tape[0, 0]) + 1
        if wanted <= rows:
            return tape[1:wanted], outcomes
        rows = wanted


def _events(body: PreparedBody, tape: Array, unit: float) -> tuple[DropEvent, ...]:
    speed = body.radius / unit
    found = []
    for row in tape:
        state = row[STATE_ON_TAPE]
        held = row[TAPE_CONTACT:TAPE_CONTACT + 2].astype(int)
        vertex = int(row[TAPE_VERTEX])
        found.append(DropEvent(
            float(row[TAPE_TIME]) * unit, EVENTS[int(row[TAPE_EVENT])],
            int(body.corner[vertex]) if vertex >= 0 else -1, MODES[int(row[TAPE_MODE])],
            tuple(int(body.corner[j]) for j in held if j >= 0), float(state[Z]) * body.radius,
            float(state[V]) * speed, *turn_vectors(
                np.stack((state[P:P + 3], state[W:W + 3] / unit)), body.axes.T)))
    return tuple(found)


def _samples(body: PreparedBody, tape: Array, down: Array,
             frame: float) -> tuple[Array, Array, Array]:
    """Times, states and orientations at the events and between them."""
    turn = resting_quaternions(down[None, :])[0]
    times, states, turns = [tape[:1, TAPE_TIME]], [tape[:1, STATE_ON_TAPE]], [turn[None, :]]
    for before, after in pairwise(tape):
        begin, span = before[TAPE_TIME], after[TAPE_TIME] - before[TAPE_TIME]
        if span > 0.0:
            inner = np.append(np.arange(1, math.ceil(span / frame)) * frame, span)
            np.minimum(inner, span, out=inner)
            state, orientation = np.empty((inner.size, STATE)), np.empty((inner.size, 4))
            mode = int(before[TAPE_MODE])
            sample_motion(body.arrays.moment, body.axes, mode if mode <= EDGE else FLIGHT,
                          _contact(body, before), before[STATE_ON_TAPE].copy(), turn, inner, state,
                          orientation)
            turn = orientation[-1]
            # The sum may round up beyond the event.
            times.append(np.minimum(begin + inner, after[TAPE_TIME]))
            states.append(state)
            turns.append(orientation)
        times.append(after[None, TAPE_TIME])
        states.append(after[None, STATE_ON_TAPE])
        turns.append(turn[None, :])
    return np.concatenate(times), np.concatenate(states), np.concatenate(turns)


def _contact(body: PreparedBody, row: Array) -> Array:
    """Vertex, direction of the edge and its length, as the kernels keep them."""
    contact = np.zeros(CONTACT)
    contact[LENGTH] = 1.0
    first, second = row[TAPE_CONTACT:TAPE_CONTACT + 2].astype(int)
    arrays = body.arrays
    if row[TAPE_MODE] >= VERTEX and first >= 0:
        contact[CORNER:CORNER + 3] = arrays.x[first], arrays.y[first], arrays.z[first]
    if second >= 0:
        end = np.array([arrays.x[second], arrays.y[second], arrays.z[second]])
        edge = end - contact[CORNER:CORNER + 3]
        contact[LENGTH] = lengths(edge[None])[0]
        contact[ALONG:ALONG + 3] = edge / contact[LENGTH]
    return contact


def _energy(moment: Array, states: Array) -> Array:
    x, y, z = states[:, W:W + 3].T
    spin = moment[0] * x * x + moment[1] * y * y + moment[2] * z * z
    return np.asarray(states[:, Z] + 0.5 * (states[:, V] * states[:, V] + spin))
