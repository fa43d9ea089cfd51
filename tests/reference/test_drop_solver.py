"""The reference drop solver against closed forms, quadratures and conserved quantities."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ros_pose_stats import shapes
from ros_pose_stats.mesh.mass_properties import solid_of

from ..bodies import random_polyhedron
from ..volume import few_quick
from .drop_solver import reference_drop

BIPYRAMID = np.vstack((np.diag((0.6, 0.5, 1.0)), -np.diag((0.6, 0.5, 1.0))))
BIPYRAMID_INERTIA = np.diag((0.2, 0.25, 0.1))


def scaled(surface):
    """Vertices and inertia of a solid of mass one and radius one."""
    solid = solid_of(*surface)
    points = surface[0] - solid.centroid
    radius = np.linalg.norm(points, axis=1).max()
    return points / radius, solid.inertia / solid.volume / radius**2


def direction(seed):
    down = np.random.default_rng(seed).standard_normal(3)
    return down / np.linalg.norm(down)


def energy(event, inertia):
    w = event.angular_velocity
    return event.height + event.velocity**2 / 2 + w @ inertia @ w / 2


def flight(event, inertia, times):
    """Heights of the centre of mass (T,) and up in body axes (T, 3), from Euler's equation."""
    def rates(_, y):
        return np.concatenate((np.linalg.solve(inertia, np.cross(inertia @ y[:3], y[:3])),
                               np.cross(y[3:], y[:3])))

    run = solve_ivp(rates, (0.0, times[-1]), np.concatenate((event.angular_velocity, event.up)),
                    t_eval=times, rtol=1e-12, atol=1e-13)
    return event.height + event.velocity * times - times**2 / 2, run.y[3:].T


def test_symmetric_top_precesses():
    points, inertia = scaled(shapes.prism(7, 1.0, 0.4))
    across, along = inertia[0, 0], inertia[2, 2]
    before, after = reference_drop(points, inertia, direction(3), 0.8, 20.0, events=2)
    lasted, w = after.time - before.time, before.angular_velocity
    momentum = before.rotation @ inertia @ w
    spin = Rotation.from_rotvec((0.0, 0.0, (1.0 - along / across) * w[2] * lasted))
    precession = Rotation.from_rotvec(momentum / across * lasted)
    expected = precession * Rotation.from_matrix(before.rotation) * spin
    assert lasted * np.linalg.norm(w) > 10.0
    assert after.rotation == pytest.approx(expected.as_matrix(), abs=1e-12)
    assert after.height == pytest.approx(
        before.height + before.velocity * lasted - lasted**2 / 2, abs=1e-12)


@pytest.mark.parametrize("height", [0.0, 5.0])
def test_elastic_drop_keeps_its_energy(height):
    """From height zero it slides on a vertex first."""
    points, inertia = scaled(random_polyhedron(9, 4))
    found = reference_drop(points, inertia, direction(4), 1.0, height, events=6)
    expected = max(height, np.max(points @ direction(4)))
    assert [energy(e, inertia) for e in found] == pytest.approx([expected] * 6, abs=1e-11)


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
def test_energy_lost_in_impacts(restitution):
    points, inertia = scaled(random_polyhedron(10, 5))
    found = reference_drop(points, inertia, direction(5), restitution, 4.0, events=6)
    for before, after in pairwise(found):
        arm = np.cross(points[after.vertex], after.up)
        mass = 1.0 / (1.0 + arm @ np.linalg.solve(inertia, arm))
        rebound = after.velocity + after.angular_velocity @ arm
        lost = (1.0 - restitution**2) / 2.0 * mass * (rebound / restitution) ** 2
        assert after.kind == "impact"
        assert energy(before, inertia) - energy(after, inertia) == pytest.approx(lost, abs=1e-11)


@pytest.mark.parametrize("restitution", [0.0, 0.2, 0.8])
@pytest.mark.parametrize("height", [0.0, 4.0])
def test_states_are_consistent(restitution, height):
    points, inertia = scaled(random_polyhedron(8, 6))
    for event in reference_drop(points, inertia, direction(6), restitution, height, events=6):
        assert event.up @ inertia @ event.angular_velocity == pytest.approx(0.0, abs=1e-13)
        assert event.rotation @ event.rotation.T == pytest.approx(np.eye(3), abs=1e-12)
        assert event.rotation[2] == pytest.approx(event.up, abs=0)
        heights = event.height + points @ event.up
        assert heights.min() == pytest.approx(0.0, abs=1e-12)
        assert heights[event.vertex] == pytest.approx(0.0, abs=1e-12)
        arms = np.cross(points, event.up)
        leaving = event.velocity + arms @ event.angular_velocity
        assert leaving[heights < 1e-11].min() > -1e-11


@pytest.mark.parametrize("seed", few_quick(range(4), 1))
def test_no_contact_is_missed(seed):
    """Each flight again, by another integrator, looking at many instants."""
    points, inertia = scaled(random_polyhedron(10, seed))
    found = reference_drop(points, inertia, direction(seed), 0.6, 3.0, events=8)
    for before, after in pairwise(found):
        times = np.linspace(0.0, after.time - before.time, 3001)
        height, up = flight(before, inertia, times)
        assert (height[:, None] + up @ points.T).min() > -1e-10


@pytest.mark.parametrize("restitution", [0.01, 0.3])
def test_vertical_bounces_to_rest(restitution):
    """Times of a bouncing ball, down to where its sequence of bounces is cut off."""
    found = reference_drop(BIPYRAMID, BIPYRAMID_INERTIA, (0.0, 0.0, 1.0), restitution, 3.0, 99)
    speeds = [2.0]
    while speeds[-1] > 1e-5:
        speeds.append(speeds[-1] * restitution)
    times = 2.0 + np.concatenate(([0.0], np.cumsum(2.0 * np.array(speeds[1:]))))
    assert [e.vertex for e in found] == [2] * len(speeds)
    assert [e.time for e in found] == pytest.approx(times, abs=1e-14)
    after = restitution * np.array(speeds[:-1])
    assert [e.velocity for e in found[:-1]] == pytest.approx(after, rel=1e-9)
    assert found[-1].velocity == 0.0


def tipping_time(length, inertia, first, last):
    """From rest, sliding on a point `length` below the centre of mass, in a plane.

    Angles from the vertical; from the conservation of energy. The square root that the
    integrand begins with goes into the variable: angle = first + s².
    """
    s, weights = np.polynomial.legendre.leggauss(60)
    top = np.sqrt(last - first)
    s, weights = (s + 1.0) * top / 2.0, weights * top / 2.0
    angle = first + s**2
    fallen = 2.0 * length * np.sin((angle + first) / 2.0) * np.sin(s**2 / 2.0)
    return weights @ (2.0 * s * np.sqrt((inertia + (length * np.sin(angle)) ** 2) / 2.0 / fallen))


@pytest.mark.parametrize("start", [0.1, 0.5])
def test_tips_on_a_vertex(start):
    down = (np.sin(start), 0.0, np.cos(start))
    event, = reference_drop(BIPYRAMID, BIPYRAMID_INERTIA, down, 0.5, 0.0, events=1)
    end = np.arctan2(1.0, 0.6)
    assert (event.kind, event.vertex) == ("impact", 0)
    assert event.time == pytest.approx(tipping_time(1.0, 0.25, start, end), abs=1e-12)
    assert event.height == pytest.approx(np.cos(end), abs=1e-12)


def test_tips_on_an_edge():
    points, inertia = scaled(shapes.box(0.8, 3.0, 2.0))
    corner = points.max(axis=0)
    end = np.arctan2(corner[0], corner[2])
    start = end - 0.3
    down = (np.sin(0.3), 0.0, np.cos(0.3))
    event, = reference_drop(points, inertia, down, 0.5, 0.0, events=1)
    expected = tipping_time(np.hypot(corner[0], corner[2]), inertia[1, 1], start, end)
    other = np.flatnonzero((points[:, 0] < 0.0) & (points[:, 2] > 0.0))
    assert (event.kind, event.vertex) == ("impact", other.min())
    assert event.time == pytest.approx(expected, abs=1e-12)
    assert event.height == pytest.approx(corner[2], abs=1e-12)


@pytest.mark.parametrize(("seed", "place"), [(10, 4), (23, 5)])
def test_released_vertex_leaves_with_no_acceleration(seed, place):
    """A heavy centre: swinging over its contact, the body pulls away from the plate."""
    points, inertia = scaled(random_polyhedron(6 + seed % 5, seed))
    found = reference_drop(points, 0.3 * inertia, direction(seed), 0.0, 1.5, events=place + 2)
    event, following = found[place:]
    assert event.kind == "release"
    assert following.time - event.time > 0.05
    height, up = flight(event, 0.3 * inertia, np.array((0.0, 0.001, 0.002)))
    _, early, later = height + up @ points[event.vertex]
    assert early > 0.0
    assert later / early == pytest.approx(8.0, rel=0.05)


def test_released_from_an_edge_it_slides_on_the_other_vertex():
    points, inertia = scaled(random_polyhedron(6, 0))
    event, following = reference_drop(points, 0.3 * inertia, direction(0), 0.0, 1.5, 7)[5:]
    heights = following.height + points @ following.up
    assert (event.kind, event.vertex, following.kind) == ("release", 1, "impact")
    assert np.abs(event.height + points[[1, 3]] @ event.up) == pytest.approx(0.0, abs=1e-12)
    assert heights[3] == pytest.approx(0.0, abs=1e-12)
    assert heights[1] > 1e-4


def test_face_at_rest_ends_the_drop():
    points, inertia = scaled(shapes.box(1.0, 1.0, 1.0))
    found = reference_drop(points, inertia, (0.0, 0.0, 1.0), 0.5, 0.0)
    assert found == []
    fallen, = reference_drop(points, inertia, (0.0, 0.0, 1.0), 0.0, 2.0)
    assert fallen.time == pytest.approx(np.sqrt(2.0 * (2.0 - points[:, 2].max())), abs=1e-14)
    assert fallen.vertex == np.flatnonzero(points[:, 2] > 0.0).min()
    assert abs(fallen.velocity) < 1e-11
