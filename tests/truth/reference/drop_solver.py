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

"""A polyhedron dropped on a frictionless plate, by scipy's DOP853 and a search for
events.

Lengths in units of the body's radius, mass and gravity one. The state is one vector:
height and vertical velocity of the centre of mass, the rotation matrix (body to world,
nine numbers), the angular velocity in body axes, and the height of every vertex above
the plate. The last follow from the others, but are integrated too: a bounce far below
the rounding of the height of the centre of mass keeps its digits. Equations: sections
3.B-D and appendices A and B of the paper.
"""

from dataclasses import dataclass
from functools import partial
from itertools import combinations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

NEAR = 1e-9
SLOW = 5e-4  # Zeno point: height (appendix B), and speed over 1 - restitution
SHARE = 1e-4
COST = 1e-9  # of the kinetic energy, or of m g radius: most that a stop may cost
TOUCHING = 1e-11  # height of a vertex that takes part in an impact
TIED = 1e-12  # height of a vertex that came down with the first one
STILL = 1e-12  # speed that counts as none: an endless sequence of impacts ends here
NO_FORCE = 1e-11  # of a vertex released along with another
NOISE = 1e-14  # mean speed below which a vertex that just left has not come back
LONGEST = 1000.0  # time without an event after which the search is given up
Z = 0
V = 1
UP = slice(8, 11)
W = slice(11, 14)
GAPS = slice(14, None)  # UP: last row of R


@dataclass(frozen=True)
class ReferenceEvent:
    """State just after an event, in the units of the module.

    `vertex` is the one that came down or was let go, the lowest index among ties.
    """

    time: float
    kind: str  # "impact" or "release"
    vertex: int
    height: float
    velocity: float
    up: np.ndarray  # (3,), body axes
    rotation: np.ndarray  # (3, 3), body to world
    angular_velocity: np.ndarray  # (3,), body axes


def skew(a):
    """Matrix of a ×, (3, 3)."""
    x, y, z = a
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


class Body:
    """Vertices (V, 3) about the centre of mass and the inertia (3, 3) for unit mass."""

    def __init__(self, points, inertia):
        self.points = np.asarray(points, dtype=float)
        self.across = np.array([skew(point) for point in self.points])
        self.inertia = np.asarray(inertia, dtype=float)
        self.inverse = np.linalg.inv(self.inertia)

    def arms(self, state):
        """r × up of every vertex, (V, 3)."""
        return self.across @ state[UP]

    def velocities(self, state):
        """Vertical, of every vertex, (V,)."""
        return state[V] + self.arms(state) @ state[W]

    def free_turn(self, w):
        """Angular acceleration without contact, (3,)."""
        return self.inverse @ (skew(self.inertia @ w) @ w)

    def free_fall(self, state, vertices=slice(None)):
        """Vertical accelerations without contact of the vertices `which` (k,), (k,)."""
        up = state[UP]
        w = state[W]
        centripetal = w * (up @ w) - up * (w @ w)
        return (
            self.across[vertices] @ up @ self.free_turn(w)
            + self.points[vertices] @ centripetal
            - 1.0
        )

    def response(self, state, vertices):
        """What unit vertical forces at `which` (k,) do to their accelerations, (k,
        k).
        """
        arms = self.across[vertices] @ state[UP]
        return 1.0 + arms @ self.inverse @ arms.T

    def forces(self, state, contacts):
        """Contact forces that keep `contacts` (k,) from accelerating, (k,)."""
        return np.linalg.solve(
            self.response(state, contacts), -self.free_fall(state, contacts)
        )

    def push(self, state, vertices, impulses):
        """Apply vertical impulses (k,) at the vertices `which` (k,), in place."""
        state[V] += np.sum(impulses)
        state[W] += self.inverse @ (self.arms(state)[vertices].T @ impulses)

    def rates(self, contacts, _, state):
        """Time derivative of the state while it slides on `contacts` (k,)."""
        arms = self.arms(state)
        turning = self.free_turn(state[W])
        lift = -1.0
        if contacts:
            forces = self.forces(state, contacts)
            turning = turning + self.inverse @ (forces @ arms[contacts])
            lift += forces.sum()
        attitude = (state[2:11].reshape(3, 3) @ skew(state[W])).ravel()
        return np.concatenate(
            ((state[V], lift), attitude, turning, state[V] + arms @ state[W])
        )

    def watch(self, contacts, state):
        """Force of each contact, height of each other vertex, (V,): an event below
        zero.
        """
        watched = state[GAPS].copy()
        if contacts:
            watched[contacts] = self.forces(state, contacts)
        return watched

    def halt(self, state, vertices):
        """Impulses, of either sign, that take all velocity from `which` (k,), in
        place.
        """
        needed = -self.velocities(state)[vertices]
        self.push(
            state, vertices, np.linalg.lstsq(self.response(state, vertices), needed)[0]
        )

    def kinetic(self, state):
        """Kinetic energy."""
        return 0.5 * (state[V] ** 2 + state[W] @ self.inertia @ state[W])

    def supports(self, state, resting):
        """Those of the touching, still vertices that press on; None when a face
        rests.
        """
        free = self.free_fall(state)
        for contacts in (list(c) for k in range(3) for c in combinations(resting, k)):
            forces = self.forces(state, contacts) if contacts else np.zeros(0)
            arms = self.arms(state)
            accelerations = (
                free + (1.0 + arms @ self.inverse @ arms[contacts].T) @ forces
            )
            if (forces > 0.0).all() and (accelerations[resting] > -1e-9).all():
                return contacts
        return None


def first_below_zero(watch, times, values):
    """Earliest time at which an entry of watch(t), (V,), turns negative, and its index.

    `values` are those at the times. A dip between two samples counts: the minimum is
    looked for wherever three of them leave room for one below zero.
    """
    roots = []
    for j, line in enumerate(values.T):
        for i in np.flatnonzero((line[:-1] >= 0.0) & (line[1:] < 0.0))[:1]:
            start = times[i + 1] if line[i] == 0.0 else times[i]
            roots.append((_root(watch, j, start, times[i + 1]), j))
        quotient = line[:-2]
        middle = line[1:-1]
        right = line[2:]
        dip = (middle >= 0.0) & (middle <= np.minimum(quotient, right))
        for i in np.flatnonzero(dip & (middle < quotient + right - 2.0 * middle)):
            low = minimize_scalar(
                lambda t, j=j: watch(t)[j],
                method="bounded",
                bounds=(times[i], times[i + 2]),
                options={"xatol": 1e-12},
            ).x
            if watch(low)[j] < 0.0 <= line[i]:
                roots.append((_root(watch, j, times[i] or times[i + 1], low), j))
    return min(roots, default=None)


def _root(watch, j, start, end):
    """Where watch(t)[j] turns negative; the start where it already is."""
    if watch(start)[j] <= 0.0:
        return start
    return brentq(lambda t: watch(t)[j], start, end, xtol=1e-15, rtol=1e-14)


def integrate(rates, state, duration, **options):
    """scipy's result; the equations do not know the time, so it counts from zero."""
    return solve_ivp(
        rates,
        (0.0, duration),
        state,
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
        dense_output=True,
        **options,
    )


def sample_times(steps):
    """Eight to a step; towards the start ever closer, for bounces of any length."""
    inside = (steps[:-1, None] + np.diff(steps)[:, None] * np.arange(8) / 8).ravel()
    early = steps[1] / 8 * 2.0 ** np.arange(-30, 0)
    return np.concatenate((inside[:1], early, inside[1:], steps[-1:]))


def next_event(body, state, contacts):
    """Duration until a vertex comes down or a force ends, the state there, the
    vertex.
    """
    rates = partial(body.rates, contacts)
    passed = 0.0
    while passed < LONGEST:
        step = 0.1 / max(np.linalg.norm(state[W]), 0.5)
        run = integrate(rates, state, 10.0 * step, max_step=step)

        def watch(t, run=run, passed=passed):
            return body.watch(contacts, run.sol(t)) + NOISE * (passed + t)

        times = sample_times(run.t)
        values = np.array([body.watch(contacts, sample) for sample in run.sol(times).T])
        event = first_below_zero(
            watch, times, values + NOISE * (passed + times)[:, None]
        )
        if event is not None:
            # The interpolant is not as good as the steps: one more step, to the root.
            i = np.searchsorted(run.t, event[0]) - 1
            state = integrate(rates, run.y[:, i], event[0] - run.t[i]).y[:, -1]
            late = 0.0 if event[1] in contacts else polish(body, state, rates, event[1])
            return float(passed + event[0] + late), state, event[1]
        # The last step is done again, so that no minimum is an end point in both runs.
        passed = passed + run.t[-2]
        state = run.y[:, -2]
    raise RuntimeError("no event")


def polish(body, state, rates, vertex):
    """Newton steps to height zero, in place; how much later that is."""
    late = 0.0
    for _ in range(3):
        change = -state[GAPS][vertex] / body.velocities(state)[vertex]
        if not abs(change) < 1e-7:  # grazing: as close as it gets
            break
        state += change * rates(0.0, state)
        late += change
    return late


def let_go(body, state, contacts, vertex, _):
    """End the contact at `vertex`, and any whose force ends with it; in place.

    First vertex let go, contacts that stay.
    """
    forces = dict(zip(contacts, body.forces(state, contacts), strict=True))
    stay = [j for j in contacts if j != vertex and forces[j] > NO_FORCE]
    body.halt(state, contacts)  # a drift down would bring it back at once
    state[GAPS][contacts] = 0.0
    return min(set(contacts) - set(stay)), stay


def strike(body, state, contacts, vertex, restitution):
    """Impacts at the touching vertices, or the end of infinitely many; in place.

    First vertex to come down, touching vertices without velocity afterwards.
    """
    body.halt(state, contacts)  # what the integration let drift
    tied = np.flatnonzero(
        (state[GAPS] < TIED) & (body.velocities(state) < 0.0)
    ).tolist()
    first = min(set(tied) - set(contacts) | {vertex})
    touching = np.flatnonzero(state[GAPS] < NEAR)
    speeds = body.velocities(state)
    slow = SLOW * (1.0 - restitution)
    resting = []
    most = max(COST, SHARE * body.kinetic(state))
    for j in (
        sorted(touching, key=speeds.__getitem__)
        if (speeds[touching] > -slow).all()
        else ()
    ):
        halted = state.copy()
        body.halt(halted, [*resting, j])
        if speeds[j] < slow and body.kinetic(state) - body.kinetic(halted) <= most:
            state[:] = halted
            resting.append(j)
    state[GAPS][resting] = 0.0
    touching = np.flatnonzero(state[GAPS] < TOUCHING)
    while (speeds := body.velocities(state)[touching]).min() < -STILL:
        hit = touching[[np.argmin(speeds)]]
        impulse = -(1.0 + restitution) * speeds.min() / body.response(state, hit)[0]
        body.push(state, hit, impulse)
    resting = touching[np.abs(speeds) < 10.0 * STILL]
    body.halt(state, resting)
    state[GAPS][resting] = 0.0
    state[GAPS][state[GAPS] < TOUCHING] = 0.0
    return first, resting.tolist()


def released(body, down, height):
    """State at rest with `down` (3,), body axes, pointing down; on the plate if too
    low.
    """
    up = -np.asarray(down, dtype=float) / np.linalg.norm(down)
    axis = np.linalg.svd(up[None])[2][1]
    height = max(height, np.max(-body.points @ up))
    gaps = height + body.points @ up
    gaps[gaps < TOUCHING] = 0.0
    rows = (axis, np.cross(up, axis), up)
    return np.concatenate(((height, 0.0), *rows, np.zeros(3), gaps))


def reference_drop(points, inertia, down, restitution, height, events=5):
    """First events of a drop from rest; fewer when the body comes to rest.

    Vertices (V, 3) about the centre of mass, the inertia (3, 3) there for mass one and
    `down` (3,) in body axes; where the body would not fit under the height it starts on
    the plate.
    """
    body = Body(points, inertia)
    state = released(body, down, height)
    contacts = body.supports(state, np.flatnonzero(state[GAPS] == 0.0).tolist())
    return follow(body, state, contacts, restitution, events)


def reference_flip(points, inertia, down, point, kick, restitution, events=5):
    """First events of a resting body after the plate hits it, and the impacts that go
    with that.

    `at` (3,) is the place, in body axes, `kick` the energy over the weight.
    """
    body = Body(points, inertia)
    state = released(body, down, 0.0)
    contacts = []
    arm = np.cross(point, state[UP])
    impulse = np.sqrt(2.0 * kick / (1.0 + arm @ body.inverse @ arm))
    state[V] = impulse
    state[W] = impulse * body.inverse @ arm
    touching = np.flatnonzero(state[GAPS] == 0.0)
    if body.velocities(state)[touching].min() < 0.0:
        contacts = body.supports(
            state, strike(body, state, [], touching[0], restitution)[1]
        )
    return follow(body, state, contacts, restitution, events)


def follow(body, state, contacts, restitution, events):
    """Events that follow a state on given contacts; see `reference_drop`."""
    time = 0.0
    history = []
    while (
        len(history) < events
        and contacts is not None
        and not at_rest(body, state, contacts)
    ):
        duration, state, vertex = next_event(body, state, contacts)
        time += duration
        kind, ending = ("release", let_go) if vertex in contacts else ("impact", strike)
        first, resting = ending(body, state, contacts, vertex, restitution)
        contacts = body.supports(state, resting)
        history.append(
            ReferenceEvent(
                time,
                kind,
                first,
                float(state[Z]),
                float(state[V]),
                state[UP].copy(),
                state[2:11].reshape(3, 3).copy(),
                state[W].copy(),
            )
        )
    return history


def at_rest(body, state, contacts):
    """Whether nothing moves and nothing will."""
    return bool(np.abs(body.rates(contacts, 0.0, state)).max() < 1e-9)
