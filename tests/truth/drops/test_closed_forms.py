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

"""Moments of a drop that can be written down: bouncing, tipping, impacts."""

from itertools import pairwise

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import part_from_mesh, record_drop
from tests.truth.drops.recorded import (
    AS_ROUNDED,
    EXACT,
    impacts_of,
    recordings,
    with_corners,
)

BIPYRAMID = part_from_mesh(
    *shapes.hull_mesh(np.vstack((np.diag((0.6, 0.5, 1.0)), -np.diag((0.6, 0.5, 1.0))))),
    mass=1.0,
    inertia=np.diag((0.2, 0.25, 0.1)),
)
"""Of radius one; balanced on a tip it bounces as a ball does."""


def recorded(part, down, height, restitution=0.5, **options):
    """Released at rest; the height in radii."""
    trajectory = record_drop(
        part,
        start=down,
        restitution=restitution,
        interval=1e6,
        **EXACT,
        drop_height=height * record_drop(part).radius,
        **options,
    )
    return with_corners(part, trajectory)


@pytest.mark.parametrize("restitution", [0.05, 0.3])
def test_vertical_bounces_of_a_ball(restitution):
    """Times and speeds down to where the endless series of bounces is cut off, for
    1e-9.
    """
    trajectory, corners = recorded(BIPYRAMID, (0.0, 0.0, 1.0), 3.0, restitution)
    speeds = [2.0]
    while (speeds[-1] * restitution) ** 2 > 2e-9:
        speeds.append(speeds[-1] * restitution)
    arrivals = [event for event in trajectory.events if event.kind == "arrival"][
        : len(speeds)
    ]
    assert [corners.velocity(event) for event in arrivals] == pytest.approx(
        -np.array(speeds), rel=1e-9
    )
    times = 2.0 + np.concatenate(([0.0], np.cumsum(2.0 * np.array(speeds[1:]))))
    assert [corners.time(event) for event in arrivals] == pytest.approx(
        times, abs=AS_ROUNDED
    )


def first_landing(trajectory):
    """What came before the first corner to arrive, and that."""
    return next(
        (previous_event, event)
        for previous_event, event in pairwise(trajectory.events)
        if event.kind == "arrival" and event.time > 0.0
    )


def tipping_time(length, inertia, first, last):
    """From rest, sliding on a point `length` below the centre of mass, in a plane.

    Angles from the vertical; from the conservation of energy. The square root that the
    integrand begins with goes into the variable: angle = first + s².
    """
    s, weights = np.polynomial.legendre.leggauss(60)
    top = np.sqrt(last - first)
    s = (s + 1.0) * top / 2.0
    weights = weights * top / 2.0
    angle = first + s**2
    fallen = 2.0 * length * np.sin((angle + first) / 2.0) * np.sin(s**2 / 2.0)
    return weights @ (
        2.0 * s * np.sqrt((inertia + (length * np.sin(angle)) ** 2) / 2.0 / fallen)
    )


@pytest.mark.parametrize("start", [0.1, 0.5])
def test_tipping_on_a_corner(start):
    trajectory, corners = recorded(BIPYRAMID, (np.sin(start), 0.0, np.cos(start)), 1e-3)
    previous_event, arrival = first_landing(trajectory)
    end = np.arctan2(1.0, 0.6)
    assert previous_event.mode == "vertex"
    assert corners.time(arrival) == pytest.approx(
        tipping_time(1.0, 0.25, start, end), abs=AS_ROUNDED
    )
    assert arrival.height == pytest.approx(np.cos(end), abs=AS_ROUNDED)


def test_tipping_on_an_edge():
    part = part_from_mesh(*shapes.box(0.8, 3.0, 2.0))
    trajectory, corners = recorded(
        part, (np.sin(0.3), 0.0, np.cos(0.3)), 1e-3, to_rest=True
    )
    previous_event, arrival = first_landing(trajectory)
    corner = np.array((0.4, 1.5, 1.0)) / trajectory.radius
    end = np.arctan2(corner[0], corner[2])
    expected = tipping_time(
        np.hypot(corner[0], corner[2]), corners.moment[1, 1], end - 0.3, end
    )
    assert previous_event.mode == "edge"
    assert corners.time(arrival) == pytest.approx(expected, abs=AS_ROUNDED)
    assert arrival.height == pytest.approx(1.0, abs=AS_ROUNDED)


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
def test_energy_lost_in_impacts(restitution):
    """(1 - ρ²)/2 m_eff u² at each single one, with u = -(velocity after) / ρ."""
    part = part_from_mesh(*random_polyhedron(10, 5))
    impacts = 0
    for trajectory, corners in recordings(part, restitution, 5, **EXACT):
        for previous_event, event in impacts_of(trajectory):
            lost = corners.energy(previous_event) - corners.energy(event)
            assert lost == pytest.approx(
                corners.lost_at_impact(event, restitution), abs=1e-10
            )
            approach = corners.velocities(previous_event)[event.vertex]
            assert corners.velocities(event)[event.vertex] == pytest.approx(
                -restitution * approach, abs=1e-12
            )
            impacts += lost > 1e-3
    assert impacts > 20
