"""Sliding on a vertex and on an edge: energy, the contact and its forces."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.kernels.drops.free_motion import shorten
from ros_pose_stats.kernels.drops.layout import (
    ALONG,
    COLUMNS,
    CORNER,
    EDGE,
    FORCE,
    LENGTH,
    ORDER,
    PS,
    STATE,
    TORQUE,
    VERTEX,
    WS,
    ZS,
    P,
    V,
    W,
    Z,
)
from ros_pose_stats.kernels.drops.motion import advance
from ros_pose_stats.kernels.drops.sliding_motion import sliding_series
from ros_pose_stats.tolerances import TRUNCATION

from .motions import energy_of, off_invariants

CONSERVED = 1e-12
MOMENTS = {"generic": (0.1, 0.2, 0.25), "needle": (1e-4, 0.3, 0.3), "plate": (0.1, 0.2, 0.3),
           "isotropic": (0.2, 0.2, 0.2)}
EVERY_MOMENT = pytest.mark.parametrize("moment", MOMENTS.values(), ids=MOMENTS)
BOTH_MODES = pytest.mark.parametrize("mode", [VERTEX, EDGE])
LENGTHS = (1.0, 0.1, 1e-6)


def sliding(moment, mode, seed):
    """State (8,) that keeps its contact, the contact (7,) and its vertices (k, 3)."""
    random = np.random.default_rng(seed)
    up, other = np.linalg.qr(random.standard_normal((3, 3)))[0][:2]
    aside = random.uniform(-0.5, 0.5, 2) @ (other, np.cross(up, other))
    r = aside - random.uniform(0.3, 1.0) * up
    along, length = (other, LENGTHS[seed % 3]) if mode == EDGE else (np.zeros(3), 1.0)
    kept = [moment * up]  # directions in which the angular velocity has no part
    if mode == EDGE:
        kept.append(np.cross(along, up))
    basis = np.linalg.svd(np.array(kept))[2][len(kept):]
    spin = random.uniform(0.2, 3.0) * random.standard_normal(len(basis)) @ basis
    state = np.zeros(STATE)
    state[P:P + 3], state[W:] = up, spin
    state[Z], state[V] = -up @ r, -spin @ np.cross(r, up)
    vertices = np.array((r, r + length * along))[:mode]
    return state, np.concatenate((r, along, (length,))), vertices


def edge_of(contact):
    """The vertex and the end of a unit edge (2, 3)."""
    corner = contact[CORNER:CORNER + 3]
    return np.array((corner, corner + contact[ALONG:ALONG + 3]))


def slide(state, moment, contact, mode, step):
    """One step: the state (8,) at its end, its series, their last row and the length."""
    series = np.zeros((ORDER + 1, COLUMNS))
    last = sliding_series(state, moment, contact, mode == EDGE, step, TRUNCATION, series)
    step *= shorten(series, last, TRUNCATION)
    state = state.copy()
    advance(state, series, contact, mode, last, step, 1.0)
    return state, series, last, step


def slide_on(state, moment, contact, mode, time):
    """The state (8,) after a time of sliding, whatever sign the forces have."""
    while time > 1e-12:
        step = min(time, 1.0 / max(1.0, np.linalg.norm(state[W:])))
        state, *_, step = slide(state, moment, contact, mode, step)
        time -= step
    return state


def whole_step(state, moment, contact, mode):
    """As `slide`, with a step for which the series need not be shortened."""
    wanted, step = 0.2, 0.0
    while step < wanted:
        wanted *= 0.5
        found, series, last, step = slide(state, moment, contact, mode, wanted)
    return found, series, last, step


def contact_forces(state, moment, vertices):
    """Forces (k,) that keep the vertices from accelerating, and the rates (2, 3) of p and w."""
    up, spin = state[P:P + 3], state[W:]
    free = np.cross(moment * spin, spin) / moment
    arms = np.cross(vertices, up)
    fall = -1.0 + vertices @ np.cross(np.cross(up, spin), spin) + arms @ free
    forces = np.linalg.solve(1.0 + arms @ (arms / moment).T, -fall)
    return forces, np.array((np.cross(up, spin), free + forces @ arms / moment))


@EVERY_MOMENT
@BOTH_MODES
def test_energy_and_invariants(moment, mode):
    moment = np.array(moment)
    for seed in range(30):
        state, contact, _ = sliding(moment, mode, seed)
        found = slide_on(state, moment, contact, mode, 0.5)
        size = max(1.0, energy_of(state, moment))
        assert energy_of(found, moment) == pytest.approx(energy_of(state, moment),
                                                         abs=CONSERVED * size)
        assert off_invariants(found, moment) < CONSERVED


@EVERY_MOMENT
@BOTH_MODES
def test_contact_stays(moment, mode):
    """Heights and vertical velocities of its vertices, and of the far end of a unit edge."""
    moment = np.array(moment)
    for seed in range(30):
        state, contact, _ = sliding(moment, mode, seed)
        found, series, last, step = slide(state, moment, contact, mode, 0.2)
        up, points = found[P:P + 3], edge_of(contact)[:mode]
        speed = max(1.0, np.linalg.norm(found[W:]))
        assert np.abs(found[Z] + points @ up).max() < CONSERVED
        assert np.abs(found[V] + np.cross(points, up) @ found[W:]).max() < CONSERVED * speed
        climbed = series[1:last + 1, ZS] @ np.arange(1, last + 1) / step
        assert climbed == pytest.approx(found[V], abs=CONSERVED * speed)


@EVERY_MOMENT
@BOTH_MODES
def test_forces_and_rates(moment, mode):
    """At the start and at the end of a step, against a direct solution."""
    moment = np.array(moment)
    for seed in range(30):
        state, contact, _ = sliding(moment, mode, seed)
        unit = edge_of(contact)[:mode]
        found, series, last, step = whole_step(state, moment, contact, mode)
        for at, here in ((0.0, state), (1.0, found)):
            power = at ** np.arange(last + 1)
            forces, rates = contact_forces(here, moment, unit)
            ours = power @ series[:last + 1, [FORCE, TORQUE]] / step ** 2
            # The last terms of the series count more in its derivatives: ORDER² TRUNCATION.
            size = 1e-10 * max(1.0, np.abs(forces).max(), np.abs(rates).max()) / moment.min()
            assert ours[0] == pytest.approx(forces.sum(), abs=size)
            assert ours[1] == pytest.approx(forces[-1] if mode == EDGE else 0.0, abs=size)
            slopes = np.arange(1, last + 1) * power[:-1] @ series[1:last + 1] / step
            assert slopes[PS:PS + 3] == pytest.approx(rates[0], abs=size)
            assert slopes[WS:WS + 3] / step == pytest.approx(rates[1], abs=size)


@BOTH_MODES
def test_length_of_the_edge_does_not_matter(mode):
    """Two vertices 1e-6 apart carry a moment, too."""
    moment = np.array(MOMENTS["generic"])
    state, contact, _ = sliding(moment, mode, 2)
    expected = slide_on(state, moment, contact, mode, 0.3)
    contact[LENGTH] = 1e-9
    np.testing.assert_array_equal(slide_on(state, moment, contact, mode, 0.3), expected)
