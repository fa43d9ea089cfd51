"""Free rotation in one go: right, or refused with nothing changed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk, ellipkinc

from ros_pose_stats.kernels.drops.free_rotation import (
    NOME,
    STEEP,
    arithmetic_geometric,
    rotate_freely,
    theta_ratios,
)
from ros_pose_stats.kernels.drops.layout import P, V, W, Z

from .motions import GENERIC, SHAPES, fly, off_invariants, turning, turning_states

EXACT = 1e-11
USUAL = 6.0  # time of the fall from 20 radii; what a rounding does to the turn grows with time


def rotated(state, moment, time):
    """The state after a rotation in one go; None where that was refused, and nothing changed."""
    found = state.copy()
    if rotate_freely(found, moment, time):
        assert tuple(found[[Z, V]]) == tuple(state[[Z, V]])
        return found
    np.testing.assert_array_equal(found, state)
    return None


def assert_same_turn(found, state, moment, time):
    """As the power series has it, and on the invariants."""
    expected, speed = fly(state, moment, time), np.linalg.norm(state[W:])
    error = EXACT * max(1.0, time / USUAL)
    np.testing.assert_allclose(found[P:P + 3], expected[P:P + 3], rtol=0, atol=error)
    np.testing.assert_allclose(found[W:], expected[W:], rtol=0, atol=error * speed)
    assert moment @ found[W:] ** 2 == pytest.approx(moment @ state[W:] ** 2, rel=1e-12)
    assert off_invariants(found, moment) < 1e-12


@pytest.mark.parametrize("name", SHAPES)
def test_any_shape(name):
    moment = np.array(SHAPES[name])
    done = 0
    for k, state in enumerate(turning_states(moment, 60, seed=7)):
        time = 0.1 + 0.1 * k
        found = rotated(state, moment, time)
        if found is not None:
            done += 1
            assert_same_turn(found, state, moment, time)
    # What is refused costs steps: only the third of the states near an axis may be.
    assert done >= 40 or moment[0] == moment[2]


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("tilt", [0.0, 1e-12, 1e-6, 0.9 * STEEP, 1.1 * STEEP, 0.01, 0.1])
def test_near_a_permanent_rotation(axis, tilt):
    """Refused below STEEP, accepted well above; about the middle axis the separatrix is near."""
    moment = np.array(GENERIC)
    for k in range(12):
        momentum = np.eye(3)[axis] + tilt * np.roll((0.0, np.cos(k + 0.5), np.sin(k + 0.5)), axis)
        state = turning(moment, momentum * (-1.0) ** k, 4.0, seed=k)
        found = rotated(state, moment, 3.0)
        if found is not None:
            assert_same_turn(found, state, moment, 3.0)
        assert (found is None) or tilt > 0.5 * STEEP
        assert (found is not None) or axis == 1 or tilt < 3.0 * STEEP


@pytest.mark.parametrize("spin", [
    (0.0, 0.5, 1.0), (0.0, -0.5, 1.0), (0.0, 0.5, -1.0), (1.0, 0.5, 0.0), (1.0, -0.5, 0.0),
    (-1.0, 0.5, 0.0)])
def test_a_component_of_exactly_zero(spin):
    """At the start the amplitude is then exactly a quarter turn."""
    moment = np.array(GENERIC)
    state = turning(moment, moment * np.array(spin), 10.0, seed=1)
    assert_same_turn(rotated(state, moment, 3.0), state, moment, 3.0)


@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-9, 1e-5, 1e-3, 1e-2, 0.05, 0.2])
def test_near_the_separatrix(off):
    """On it L² = 2 E I2, that is w3 / w1 to the second power is I1 (I2 - I1) / I3 (I3 - I2)."""
    a, b, c = GENERIC
    steep = np.sqrt(a * (b - a) / (c * (c - b)))
    for k, side in enumerate((1.0 + off, 1.0 - off, -1.0 - off, -1.0 + off)):
        spin = np.array((1.0, 0.3 * (k + 1), side * steep))
        state = turning(np.array(GENERIC), np.array(GENERIC) * spin, 5.0, seed=k)
        found = rotated(state, np.array(GENERIC), 4.0)
        if found is not None:
            assert_same_turn(found, state, np.array(GENERIC), 4.0)
        assert (found is None) or off > 1e-5


def test_at_rest_is_refused():
    for moment in (SHAPES["generic"], SHAPES["isotropic"]):
        state = np.array((3.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
        assert rotated(state, np.array(moment), 2.0) is None


@pytest.mark.parametrize("time", [0.0, 1e-9, 60.0])
def test_times(time):
    """Sixty units are more than any drop from 20 radii is in the air for."""
    moment = np.array(GENERIC)
    for k, state in enumerate(turning_states(moment, 20, seed=8)):
        if k % 3 != 1 and (found := rotated(state, moment, time)) is not None:
            assert_same_turn(found, state, moment, time)


@pytest.mark.parametrize("m", [0.0, 1e-12, 0.1, 0.5, 0.9, 0.99])
def test_elliptic_functions(m):
    """Against scipy, up to the nome in use."""
    nome = np.exp(-np.pi * ellipk(1.0 - m) / ellipk(m)) if m else 0.0
    assert nome < NOME
    for phase in np.linspace(-7.0, 7.0, 57):
        mean, z = arithmetic_geometric(np.sqrt(1.0 - m), phase)
        assert mean == pytest.approx(np.pi / 2.0 / ellipk(m), rel=1e-14)
        u = ellipkinc(phase, m)
        assert z == pytest.approx(mean * u, abs=1e-13)
        assert theta_ratios(z, nome) == pytest.approx(ellipj(u, m)[:3], abs=1e-13)
