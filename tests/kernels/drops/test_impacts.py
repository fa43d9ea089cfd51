"""Impacts, and the impulses that end an infinite series of them."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.kernels.drops.drop import run_drops
from ros_pose_stats.kernels.drops.impacts import stop_slow, strike, vertex_velocity
from ros_pose_stats.kernels.drops.layout import (
    ENERGY,
    IMPACT_COUNT,
    NEAR,
    POSE,
    STATE,
    TAPE,
    DropRules,
    P,
    V,
    W,
    Z,
    corner_of,
    new_work,
)
from ros_pose_stats.kernels.vectors import Vec3
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.tolerances import MOST_STEPS, SLOW, SOFT, TOUCHING, TRUNCATION

from ...bodies import random_polyhedron
from .motions import SHAPES, energy_of, off_invariants, turning

EXACT = 1e-12


def prepared(surface):
    return drop_body(part_from_mesh(*surface), 0.0, 0).arrays


def corners(body):
    return np.column_stack((body.x, body.y, body.z))


def falling(moment, seed):
    """State (8,) and a point (3,) that moves down."""
    random = np.random.default_rng(seed)
    state = turning(moment, random.standard_normal(3), random.uniform(0.1, 5.0), seed + 1000)
    state[V] = -random.uniform(0.0, 5.0)
    r = random.standard_normal(3)
    r *= random.uniform(0.01, 1.0) / np.linalg.norm(r)
    if vertex_velocity(state, Vec3(*r)) > 0.0:
        state[[V, W, W + 1, W + 2]] *= -1.0
    return state, r


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.8, 1.0])
@pytest.mark.parametrize("moment", [SHAPES[name] for name in ("generic", "plate", "isotropic")])
def test_strike(moment, restitution):
    """Energy lost is (1 - restitution²) / 2 m_eff u²; p . I w stays 0."""
    moment = np.array(moment)
    for seed in range(100):
        state, r = falling(moment, seed)
        speed, before = vertex_velocity(state, Vec3(*r)), energy_of(state, moment)
        arm = np.cross(r, state[P:P + 3])
        assert speed == pytest.approx(state[V] + state[W:] @ arm, abs=1e-14)
        strike(state, moment, Vec3(*r), speed, restitution)
        size = max(1.0, before)
        lost = (1.0 - restitution ** 2) / 2.0 * speed ** 2 / (1.0 + arm @ (arm / moment))
        assert before - energy_of(state, moment) == pytest.approx(lost, abs=EXACT * size)
        assert vertex_velocity(state, Vec3(*r)) == pytest.approx(-restitution * speed, abs=EXACT)
        assert off_invariants(state, moment) < EXACT


def test_strike_keeps_a_thin_rod_normal():
    """The smallest moment the package lets through: 1e-12 of the largest."""
    moment = np.array(SHAPES["rod"])
    for seed in range(50):
        state, r = falling(moment, seed)
        r[1:] *= 1e-6  # on the rod
        strike(state, moment, Vec3(*r), vertex_velocity(state, Vec3(*r)), 0.5)
        assert off_invariants(state, moment) < EXACT


def slow_contact(body, count, seed):
    """State (8,) in which `count` corners of a face or an edge touch and are slow."""
    random, points = np.random.default_rng(seed), corners(body)
    state = np.zeros(STATE)
    up = random.standard_normal(3)
    if count == 3:  # flat on a face of the hull
        up = -np.eye(3)[int(np.argmax(np.ptp(points, axis=0)))]
    state[P:P + 3] = up / np.linalg.norm(up)
    state[V] = random.uniform(-1.0, 1.0) * 0.1 * SLOW
    state[W:] = random.uniform(-1.0, 1.0, 3) * 0.1 * SLOW
    state[W:] -= (state[P:P + 3] @ (body.moment * state[W:])
                  / (state[P:P + 3] @ (body.moment * state[P:P + 3])) * state[P:P + 3])
    near = np.argsort(points @ state[P:P + 3])[:count]
    state[Z] = -(points[near] @ state[P:P + 3]).min()
    return state, near


def stopped(state, body, near, soft=SOFT):
    """What `stop_slow` makes of a state: the state and which corners it brought to rest."""
    speed = np.array([vertex_velocity(state, corner_of(body, j)) for j in near])
    order = np.argsort(speed, kind="stable")
    work = new_work(body.x.shape[0])
    work.state[:], work.tally[NEAR] = state, len(near)
    work.near[:len(near)], work.speed[:len(near)] = near[order], speed[order]
    stop_slow(body, DropRules(0.5, 5.0, True, TRUNCATION, TOUCHING, SLOW, soft, 1000), work)
    return work.state, near[order], work.rested[:len(near)]


@pytest.mark.parametrize("count", [1, 2])
def test_stop_slow(count):
    """Velocities of the corners become 0; the least energy that takes is all that goes."""
    body = prepared(random_polyhedron(12, 1))
    for seed in range(50):
        state, near = slow_contact(body, count, seed)
        arms = np.cross(corners(body)[near], state[P:P + 3])
        before = energy_of(state, body.moment)
        speeds = state[V] + arms @ state[W:]
        response = 1.0 + arms @ (arms / body.moment).T
        needed = speeds @ np.linalg.solve(response, speeds) / 2.0
        found, _, rested = stopped(state, body, near)
        assert rested.all()
        assert np.abs(found[V] + arms @ found[W:]).max() < 1e-15
        assert 0.0 <= needed <= SOFT
        assert before - energy_of(found, body.moment) == pytest.approx(needed, abs=1e-15)
        assert abs(state[P:P + 3] @ (body.moment * found[W:])) < 1e-15


def test_stop_slow_on_a_face():
    """Three contacts leave no velocity at all; the fourth one of a box adds nothing."""
    body = prepared(shapes.box(1.0, 2.0, 3.0))
    for seed in range(20):
        state, near = slow_contact(body, 3, seed)
        near = np.flatnonzero(np.abs(state[Z] + corners(body) @ state[P:P + 3]) < TOUCHING)
        found, _, rested = stopped(state, body, near)
        assert len(near) == 4 and rested.all()
        assert tuple(found[[V, W, W + 1, W + 2]]) == (0.0, 0.0, 0.0, 0.0)


def test_what_would_cost_more_than_soft_is_left():
    body = prepared(random_polyhedron(12, 2))
    state, near = slow_contact(body, 2, 5)
    unchanged = state.copy()
    found, _, rested = stopped(state, body, near, soft=0.0)
    assert not rested.any()
    np.testing.assert_array_equal(found, unchanged)


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_a_thousand_elastic_impacts_keep_the_energy(seed):
    """After 1 500 to 2 500 impacts the worst of 24 drops is off by 4e-14 of the energy."""
    body = prepared(random_polyhedron(10, seed))
    states = np.zeros((8, STATE))
    ups = np.random.default_rng(seed).standard_normal((8, 3))
    states[:, Z], states[:, P:P + 3] = 5.0, ups / np.linalg.norm(ups, axis=1)[:, None]
    outcome, measure = np.zeros((8, 5), dtype=np.int64), np.zeros((8, 2))
    rules = DropRules(1.0, 5.0, True, TRUNCATION, TOUCHING, SLOW, SOFT, 15_000)
    run_drops(body, rules, states, outcome, measure, np.zeros((0, TAPE)))
    assert rules.most_steps < MOST_STEPS
    assert outcome[:, IMPACT_COUNT].min() > 1000 and (outcome[:, POSE] == -1).all()
    np.testing.assert_allclose(measure[:, ENERGY], 5.0, rtol=3e-13)
