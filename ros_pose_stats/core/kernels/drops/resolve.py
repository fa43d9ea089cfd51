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

"""What happens at an event: impacts and a new contact, or the end of a contact."""

import math

from ...tolerances import AT_REST, PULL, SINKING
from ..array_types import Array
from ..compilation import inlined
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    dot_from,
    length,
    quotients,
    read_row,
    read_vector,
    scale,
    subtract,
    write_row,
    write_vector,
)
from . import layout
from .detect import LANDING, NOTHING, Event, Path, time_to_plate
from .impacts import stop_slow_vertices, strike_vertex, vertex_velocity

LANDING_MARGIN = 1.25
"""Steps in flight end this much after the time of the next expected landing."""


@inlined
def apply_event(
    body: layout.DropBody,
    rules: layout.DropRules,
    work: layout.Work,
    event: Event,
    tape: Array,
) -> bool:
    """Note the vertices that an event is about, and let go of a contact that pulls.

    Returns whether vertices have landed, which is to be resolved.
    """
    tally = work.tally
    tally[layout.VERTICES] = 0
    if event.kind == NOTHING:
        return False
    if event.kind == LANDING:
        for i in range(event.candidate_count):
            if (
                layout.corner_height(work.state, body, work.candidates[i])
                <= rules.touching
            ):
                work.vertices[tally[layout.VERTICES]] = work.candidates[i]
                tally[layout.VERTICES] += 1
        layout.write_tape(work, tape, layout.ARRIVAL, event.corner)
        return True
    tally[layout.VERTICES] = 1
    work.vertices[0] = work.support[event.kind]
    work.rest_order[0] = 2
    tally[layout.MODE] = release_vertex(body, work, event.kind)
    layout.write_tape(work, tape, layout.LIFT_OFF, work.vertices[0])
    return False


@inlined
def resolve_landing(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work, tape: Array
) -> bool:
    """Resolve an event at the touching vertices: afterwards none of them approaches.

    Each round the fastest vertex is struck. Once all are slow they are brought to rest,
    and the contact is chosen; one that could not be (see `stop_slow_vertices`) is
    struck.

    Returns false where the steps granted ran out before.
    """
    state = work.state
    vertices = work.vertices
    tally = work.tally
    tally[layout.MODE] = layout.FLIGHT
    is_done = False
    while tally[layout.EVENTS] < tally[layout.LIMIT]:
        _sort_by_speed(body, work)
        struck = 0
        speed = work.speed[0]
        if speed > AT_REST:
            is_done = True
            break
        if speed >= -rules.slow:
            stop_slow_vertices(body, rules, work)
            layout.write_tape(work, tape, layout.STOP, vertices[0])
            struck, speed = _fastest_vertex(body, work)
            if struck < 0:
                measure_loads(body, work)
                tally[layout.MODE] = choose_contact(body, work)
                is_done = True
                break
        j = vertices[struck]
        strike_vertex(
            state, body.moment, layout.corner_of(body, j), speed, rules.restitution
        )
        tally[layout.IMPACTS] += 1
        tally[layout.EVENTS] += 1
        layout.write_tape(work, tape, layout.IMPACT, j)
    _expect_landing(body, rules, work)
    layout.write_tape_contact(work, tape)
    return is_done


@inlined
def _sort_by_speed(body: layout.DropBody, work: layout.Work) -> None:
    """Velocities of the touching vertices, the one that approaches fastest first."""
    # Equal ones by turns: an edge that lands level would always tip the part the same
    # way.
    tie = AT_REST if work.tally[layout.EVENTS] % 2 == 0 else -AT_REST
    for i in range(work.tally[layout.VERTICES]):
        j = work.vertices[i]
        u = vertex_velocity(work.state, layout.corner_of(body, j))
        k = i
        while k > 0 and work.speed[k - 1] > u + tie:
            work.speed[k], work.vertices[k] = work.speed[k - 1], work.vertices[k - 1]
            k -= 1
        work.speed[k] = u
        work.vertices[k] = j
        work.rest_order[i] = 0


@inlined
def _fastest_vertex(body: layout.DropBody, work: layout.Work) -> tuple[int, float]:
    """The touching vertex that still approaches fastest, -1 for none, and its velocity.

    One that was too fast to be stopped, but was stopped by the others, is at rest like
    them.
    """
    struck = -1
    fastest = -AT_REST
    for i in range(work.tally[layout.VERTICES]):
        if work.rest_order[i] == 0:
            j = work.vertices[i]
            u = vertex_velocity(work.state, layout.corner_of(body, j))
            if abs(u) <= AT_REST:
                work.rest_order[i] = 1
            elif u < fastest:
                struck = i
                fastest = u
    return struck, fastest


@inlined
def _expect_landing(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work
) -> None:
    """Note a lowest corner, and when the next landing is expected.

    That is of a corner that has just been struck, or of a neighbour that the body rolls
    on to.
    """
    state = work.state
    tally = work.tally
    lowest_height = time_expected = math.inf
    tally[layout.EXPECTED] = -1
    for i in range(tally[layout.VERTICES]):
        j = work.vertices[i]
        height = layout.corner_height(state, body, j)
        if height < lowest_height:
            lowest_height = height
            tally[layout.LOWEST] = j
        path = _path_of_vertex(body, work, j)
        if work.rest_order[i] == 0 and path.slope > AT_REST:
            time_expected = min(time_expected, time_to_plate(path))
        if body.neighbour.shape[0] == 0:
            continue
        for k in range(body.neighbour_start[j], body.neighbour_start[j + 1]):
            neighbour = body.neighbour[k]
            path = _path_of_vertex(body, work, neighbour)
            if path.height > rules.touching:
                landing_time = time_to_plate(path)
                if landing_time < time_expected:
                    time_expected = landing_time
                    tally[layout.EXPECTED] = neighbour
    work.clock[layout.EXPECTED_LANDING] = LANDING_MARGIN * time_expected


@inlined
def _path_of_vertex(body: layout.DropBody, work: layout.Work, j: int) -> Path:
    """Height of a vertex in time by its velocity and, in flight, its acceleration."""
    r = layout.corner_of(body, j)
    fall = (
        _fall_of(body, work.state, r)
        if work.tally[layout.MODE] == layout.FLIGHT
        else 0.0
    )
    return Path(
        layout.corner_height(work.state, body, j),
        vertex_velocity(work.state, r),
        -0.5 * fall,
    )


@inlined
def _fall_of(body: layout.DropBody, state: Array, r: Vec3) -> float:
    """Downward acceleration of a vertex in free motion.

    It is 1 - ((p x w) x w) . r - a . I^-1 (I w) x w with a = r x p.
    """
    g = layout.coupling_of(body.moment)
    p = layout.up_of(state)
    w = layout.spin_of(state)
    a = cross(r, p)
    return (
        1.0
        - dot(p, w) * dot(w, r)
        + dot(w, w) * dot(p, r)
        - a.x * g.x * w.y * w.z
        - a.y * g.y * w.z * w.x
        - a.z * g.z * w.x * w.y
    )


@inlined
def measure_loads(body: layout.DropBody, work: layout.Work) -> None:
    """Reach a = r x p and free downward acceleration of every touching vertex."""
    for i in range(work.tally[layout.VERTICES]):
        r = layout.corner_of(body, work.vertices[i])
        write_row(work.load, i, layout.ARM, cross(r, layout.up_of(work.state)))
        work.load[i, layout.FALL] = _fall_of(body, work.state, r)


@inlined
def choose_contact(body: layout.DropBody, work: layout.Work) -> int:
    """Contact mode: none, one or two of the vertices at rest, or a face.

    `measure_loads` has measured them. The vertices in contact are noted in `support`
    and `contact`.
    """
    active = work.support
    count = work.tally[layout.VERTICES]
    active[0] = active[1] = -1
    largest_fall = 0.0
    for i in range(count):
        if work.rest_order[i] == 1:
            largest_fall = max(largest_fall, work.load[i, layout.FALL])
    if largest_fall <= PULL:
        return layout.FLIGHT
    is_still = _is_still_on_three(work)
    for i in range(count):
        if work.rest_order[i] == 0 or work.load[i, layout.FALL] <= PULL:
            continue
        mode = _try_vertex(body, work, i, is_still)
        if mode != layout.FLIGHT:
            return mode
    for i in range(count):
        for k in range(i + 1, count):
            if work.rest_order[i] == 0 or work.rest_order[k] == 0:
                continue
            mode = _try_edge(body, work, i, k, is_still)
            if mode != layout.FLIGHT:
                return mode
    active[0] = active[1] = -1
    return layout.FACE


@inlined
def _try_vertex(
    body: layout.DropBody, work: layout.Work, i: int, is_still: bool
) -> int:
    """Mode if one vertex carries the body, `FLIGHT` if it does not."""
    arm = read_row(work.load, i, layout.ARM)
    fall = work.load[i, layout.FALL]
    response = quotients(arm, layout.moments_of(body))
    force = fall / dot_from(1.0, arm, response)
    turning = scale(response, force)
    if not _carries(work, i, i, force, turning):
        return layout.FLIGHT
    if is_still and not _lifts(work, force, turning):
        return layout.FACE
    work.support[0] = work.vertices[i]
    _write_contact(body, work)
    return layout.VERTEX


@inlined
def _try_edge(
    body: layout.DropBody, work: layout.Work, i: int, k: int, is_still: bool
) -> int:
    """Mode if two vertices carry the body by forces that push, `FLIGHT` if they do not.

    They are held from here on.
    """
    work.support[0], work.support[1] = work.vertices[i], work.vertices[k]
    _write_contact(body, work)
    m = layout.moments_of(body)
    size = work.contact[layout.LENGTH]
    a = read_row(work.load, i, layout.ARM)
    c = cross(read_vector(work.contact, layout.DIRECTION), layout.up_of(work.state))
    m11 = _response(1.0, a, a, m)
    m12 = _response(0.0, a, c, m)
    m22 = _response(0.0, c, c, m)
    fall = work.load[i, layout.FALL]
    fall_difference = (work.load[k, layout.FALL] - fall) / size
    share = 1.0 / (m11 * m22 - m12 * m12)
    force = share * (m22 * fall - m12 * fall_difference)
    torque = share * (m11 * fall_difference - m12 * fall)
    far_force = torque / size
    if far_force < -PULL or force - far_force < -PULL or not math.isfinite(far_force):
        return layout.FLIGHT
    turning = quotients(add(scale(a, force), scale(c, torque)), m)
    if not _carries(work, i, k, force, turning):
        return layout.FLIGHT
    if is_still and not _lifts(work, force, turning):
        return layout.FACE
    return layout.EDGE


@inlined
def _response(start: float, a: Vec3, b: Vec3, m: Vec3) -> float:
    """A number, plus a . I^-1 b."""
    return start + a.x * b.x / m.x + a.y * b.y / m.y + a.z * b.z / m.z


@inlined
def _rise_of_vertex(work: layout.Work, k: int, force: float, turning: Vec3) -> float:
    """Upward acceleration of a touching vertex under a force and its turning."""
    return (
        dot_from(force, read_row(work.load, k, layout.ARM), turning)
        - work.load[k, layout.FALL]
    )


@inlined
def _carries(
    work: layout.Work, first: int, second: int, force: float, turning: Vec3
) -> bool:
    """Whether no other vertex at rest would sink under these accelerations."""
    for k in range(work.tally[layout.VERTICES]):
        if work.rest_order[k] == 0 or k in (first, second):
            continue
        if _rise_of_vertex(work, k, force, turning) < -SINKING:
            return False
    return True


@inlined
def _lifts(work: layout.Work, force: float, turning: Vec3) -> bool:
    """A vertex at rest would rise."""
    for k in range(work.tally[layout.VERTICES]):
        if (
            work.rest_order[k] == 1
            and _rise_of_vertex(work, k, force, turning) > SINKING
        ):
            return True
    return False


@inlined
def _is_still_on_three(work: layout.Work) -> bool:
    """Three vertices or more are at rest and hold the body still.

    It then rests on the face even where two of them alone could carry it, as across the
    middle of a rectangle.
    """
    state = work.state
    if state[layout.V] != 0.0:
        return False
    if (
        state[layout.W] != 0.0
        or state[layout.W + 1] != 0.0
        or state[layout.W + 2] != 0.0
    ):
        return False
    count = 0
    for i in range(work.tally[layout.VERTICES]):
        count += work.rest_order[i]
    return count >= 3


@inlined
def _write_contact(body: layout.DropBody, work: layout.Work) -> None:
    """Note vertex, direction and length of the contact."""
    contact = work.contact
    second_vertex = work.support[1]
    corner = layout.corner_of(body, work.support[0])
    write_vector(contact, layout.CORNER, corner)
    write_vector(contact, layout.DIRECTION, Vec3(0.0, 0.0, 0.0))
    contact[layout.LENGTH] = 1.0
    if second_vertex >= 0:
        edge = subtract(layout.corner_of(body, second_vertex), corner)
        size = length(edge)
        write_vector(contact, layout.DIRECTION, divide(edge, size))
        contact[layout.LENGTH] = size


@inlined
def release_vertex(body: layout.DropBody, work: layout.Work, position: int) -> int:
    """Release one of the vertices in contact; return the mode that is left."""
    if position == 0:
        work.support[0] = work.support[1]
    work.support[1] = -1
    if work.support[0] < 0:
        return layout.FLIGHT
    _write_contact(body, work)
    return layout.VERTEX
