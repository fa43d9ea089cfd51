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

"""Impacts, and sliding on a vertex and on an edge: energy, the contact and its
forces.
"""

import numpy as np
import pytest

from ros_pose_stats.core.kernels.vectors import Vec3

from .helpers import strike_vertex, vertex_velocity
from .motions import (
    SHAPES,
    VELOCITIES,
    P,
    V,
    W,
    Z,
    energy_of,
    off_invariants,
    slide,
    turning,
)

CONSERVED = 1e-12
MOMENTS = {
    "generic": (0.1, 0.2, 0.25),
    "needle": (1e-4, 0.3, 0.3),
    "plate": (0.1, 0.2, 0.3),
    "isotropic": (0.2, 0.2, 0.2),
}
LENGTHS = (1.0, 0.1, 1e-6)
every_moment = pytest.mark.parametrize(
    "moment", [*map(np.array, MOMENTS.values())], ids=MOMENTS
)
on_a_vertex_and_an_edge = pytest.mark.parametrize("vertices", [1, 2])


def sliding(moment, vertices, seed):
    """State (8,) that keeps its contact; this is a vertex, an edge's direction, its
    length.
    """
    random = np.random.default_rng(seed)
    up, across = np.linalg.qr(random.standard_normal((3, 3)))[0][:2]
    sideways = random.uniform(-0.5, 0.5, 2) @ (across, np.cross(up, across))
    r = sideways - random.uniform(0.3, 1.0) * up
    along = across if vertices == 2 else np.zeros(3)
    length = LENGTHS[seed % 3] if vertices == 2 else 1.0
    unspun = [moment * up]  # directions in which the spin has no part
    if vertices == 2:
        unspun.append(np.cross(along, up))
    basis = np.linalg.svd(np.array(unspun))[2][len(unspun) :]
    spin = random.uniform(0.2, 3.0) * random.standard_normal(len(basis)) @ basis
    state = np.zeros(8)
    state[P : P + 3] = up
    state[W:] = spin
    state[Z] = -up @ r
    state[V] = -spin @ np.cross(r, up)
    return state, np.concatenate((r, along, (length,)))


def points_of(contact, vertices):
    """The vertex, and the end of a unit edge."""
    return np.array((contact[:3], contact[:3] + contact[3:6]))[:vertices]


def slide_on(state, moment, contact, vertices, time):
    """The state (8,) after a time of sliding, whatever sign the forces have."""
    while time > 1e-12:
        step = min(time, 1.0 / max(1.0, np.linalg.norm(state[W:])))
        state, step, _ = slide(state, moment, contact, vertices, step)
        time -= step
    return state


def whole_step(state, moment, contact, vertices):
    """A step so short that its series need not be shortened."""
    duration = 0.4
    slid = None
    while slid is None or slid.step < duration:
        duration *= 0.5
        slid = slide(state, moment, contact, vertices, duration)
    return slid


def contact_forces(state, moment, points):
    """Forces (k,) that keep the points from accelerating, and the rates (2, 3) of up
    and spin.
    """
    up = state[P : P + 3]
    spin = state[W:]
    free = np.cross(moment * spin, spin) / moment
    arms = np.cross(points, up)
    fall = -1.0 + points @ np.cross(np.cross(up, spin), spin) + arms @ free
    forces = np.linalg.solve(1.0 + arms @ (arms / moment).T, -fall)
    return forces, np.array((np.cross(up, spin), free + forces @ arms / moment))


@every_moment
@on_a_vertex_and_an_edge
def test_energy_is_conserved(moment, vertices):
    for seed in range(15):
        state, contact = sliding(moment, vertices, seed)
        slid = slide_on(state, moment, contact, vertices, 0.5)
        energy = energy_of(state, moment)
        assert energy_of(slid, moment) == pytest.approx(
            energy, abs=CONSERVED * max(1.0, energy)
        )
        assert off_invariants(slid, moment) < CONSERVED


@every_moment
@on_a_vertex_and_an_edge
def test_the_contact_stays_on_the_plate(moment, vertices):
    """Heights and vertical velocities of the vertex, and of the far end of a unit
    edge.
    """
    for seed in range(15):
        state, contact = sliding(moment, vertices, seed)
        slid = slide(state, moment, contact, vertices, 0.2)
        up = slid.state[P : P + 3]
        points = points_of(contact, vertices)
        speed = max(1.0, np.linalg.norm(slid.state[W:]))
        assert np.abs(slid.state[Z] + points @ up).max() < CONSERVED
        assert np.abs(slid.state[V] + np.cross(points, up) @ slid.state[W:]).max() < (
            CONSERVED * speed
        )


@every_moment
@on_a_vertex_and_an_edge
def test_forces_and_rates_at_both_ends_of_a_step_are_those_of_a_direct_solution(
    moment, vertices
):
    for seed in range(15):
        state, contact = sliding(moment, vertices, seed)
        slid = whole_step(state, moment, contact, vertices)
        for fraction, moment_state in ((0.0, state), (1.0, slid.state)):
            forces, rates = contact_forces(
                moment_state, moment, points_of(contact, vertices)
            )
            # The last terms of the series count more in its derivatives: 16² of its
            # truncation.
            size = (
                1e-10
                * max(1.0, np.abs(forces).max(), np.abs(rates).max())
                / moment.min()
            )
            second = forces[-1] if vertices == 2 else 0.0
            assert slid.forces(fraction) == pytest.approx(
                [forces.sum(), second], abs=size
            )
            assert slid.rates(fraction) == pytest.approx(rates, abs=size)


def falling(moment, seed):
    """State (8,) and a point (3,) that moves down."""
    random = np.random.default_rng(seed)
    state = turning(
        moment, random.standard_normal(3), random.uniform(0.1, 5.0), seed + 1000
    )
    state[V] = -random.uniform(0.0, 5.0)
    r = random.standard_normal(3)
    r *= random.uniform(0.01, 1.0) / np.linalg.norm(r)
    if vertex_velocity(state, Vec3(*r)) > 0.0:
        state[VELOCITIES] *= -1.0
    return state, r


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", ["generic", "plate", "isotropic"])
def test_an_impact_takes_its_share_of_the_energy_of_the_approach(name, restitution):
    """(1 - restitution²) / 2 m_eff u², and the corner leaves at -restitution u; p . I w
    = 0.
    """
    moment = np.array(SHAPES[name])
    for seed in range(50):
        state, r = falling(moment, seed)
        speed = vertex_velocity(state, Vec3(*r))
        energy = energy_of(state, moment)
        arm = np.cross(r, state[P : P + 3])
        assert speed == pytest.approx(state[V] + state[W:] @ arm, abs=1e-14)
        strike_vertex(state, moment, Vec3(*r), speed, restitution)
        lost = (1.0 - restitution**2) / 2.0 * speed**2 / (1.0 + arm @ (arm / moment))
        assert energy - energy_of(state, moment) == pytest.approx(
            lost, abs=CONSERVED * max(1.0, energy)
        )
        velocity = vertex_velocity(state, Vec3(*r))
        assert velocity == pytest.approx(-restitution * speed, abs=CONSERVED)
        assert off_invariants(state, moment) < CONSERVED


def test_an_impact_keeps_the_momentum_of_a_thin_rod_normal():
    """The smallest moment the package lets through: 1e-12 of the largest."""
    moment = np.array(SHAPES["rod"])
    for seed in range(50):
        state, r = falling(moment, seed)
        r[1:] *= 1e-6  # on the rod
        strike_vertex(state, moment, Vec3(*r), vertex_velocity(state, Vec3(*r)), 0.5)
        assert off_invariants(state, moment) < CONSERVED
