"""Free flight by power series: against scipy, closed forms and what is conserved."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ros_pose_stats.kernels.drops.free_motion import free_series, shorten
from ros_pose_stats.kernels.drops.layout import COLUMNS, FLIGHT, ORDER, PS, P, V, W, Z
from ros_pose_stats.kernels.drops.motion import advance
from ros_pose_stats.tolerances import TRUNCATION

from .motions import NO_CONTACT, SHAPES, energy_of, fly, off_invariants, turning_states

EXACT = 1e-11
CONSERVED = 1e-12

EVERY_SHAPE = pytest.mark.parametrize("moment", SHAPES.values(), ids=SHAPES)


def by_scipy(state, moment, time):
    """Up and angular velocity (6,) after a free rotation, by Euler's equations."""
    def rates(_, y):
        turned = np.cross(y[:3], y[3:])
        return np.concatenate((turned, np.cross(moment * y[3:], y[3:]) / moment))

    step = 0.1 / np.linalg.norm(state[W:])
    return solve_ivp(rates, (0.0, time), state[P:], method="DOP853", rtol=3e-14, atol=1e-16,
                     max_step=step).y[:, -1]


@pytest.mark.parametrize("moment", [SHAPES[name] for name in (
    "generic", "plate", "oblate but for 1e-14", "oblate but for 1e-05", "isotropic")])
def test_against_scipy(moment):
    moment = np.array(moment)
    for state in turning_states(moment, 3, seed=1):
        found, speed = fly(state, moment, 2.0), np.linalg.norm(state[W:])
        expected = by_scipy(state, moment, 2.0)
        np.testing.assert_allclose(found[P:P + 3], expected[:3], rtol=0, atol=EXACT)
        np.testing.assert_allclose(found[W:], expected[3:], rtol=0, atol=EXACT * speed)


@EVERY_SHAPE
def test_conserved(moment):
    moment = np.array(moment)
    for state in turning_states(moment, 12, seed=2):
        found = fly(state, moment, 5.0)
        assert energy_of(found, moment) == pytest.approx(energy_of(state, moment), rel=CONSERVED)
        assert np.linalg.norm(moment * found[W:]) == pytest.approx(
            np.linalg.norm(moment * state[W:]), rel=CONSERVED)
        assert off_invariants(found, moment) < CONSERVED


@EVERY_SHAPE
def test_back_again(moment):
    """With all velocities turned round the way leads back."""
    moment = np.array(moment)
    for state in turning_states(moment, 6, seed=3):
        there = fly(state, moment, 3.0)
        there[[V, W, W + 1, W + 2]] *= -1.0
        back = fly(there, moment, 3.0)
        back[[V, W, W + 1, W + 2]] *= -1.0
        size = max(1.0, np.linalg.norm(state[W:]), abs(there[V]), abs(there[Z]))
        np.testing.assert_allclose(back, state, rtol=0, atol=EXACT * size)


def test_symmetric_top():
    """The angular velocity circles the axis at (I3 - I1) / I1 of its part along it."""
    moment, time = np.array((0.2, 0.2, 0.3)), 4.0
    for state in turning_states(moment, 6, seed=4):
        found = fly(state, moment, time)
        rate = (0.2 - 0.3) / 0.2 * state[W + 2]
        turned = (state[W] + 1j * state[W + 1]) * np.exp(-1j * rate * time)
        speed = np.linalg.norm(state[W:])
        assert found[W] + 1j * found[W + 1] == pytest.approx(turned, abs=EXACT * speed)
        assert found[W + 2] == pytest.approx(state[W + 2], rel=1e-14)


def test_height_is_a_parabola():
    moment = np.array(SHAPES["generic"])
    for state in turning_states(moment, 6, seed=5):
        found = fly(state, moment, 1.7)
        height = state[Z] + 1.7 * state[V] - 1.7 ** 2 / 2.0
        assert (found[Z], found[V]) == pytest.approx((height, state[V] - 1.7), abs=1e-14)


@pytest.mark.parametrize("reach", [0.01, 0.3, 1.0, 3.0, 10.0])
def test_steps_of_any_length_converge(reach):
    """`shorten` finds how far a series holds: as far as two halves of the step agree."""
    moment, series = np.array(SHAPES["generic"]), np.zeros((ORDER + 1, COLUMNS))
    for state in turning_states(moment, 20, seed=6):
        step = reach / np.linalg.norm(state[W:])
        last = free_series(state, moment, step, TRUNCATION, series)
        step *= shorten(series, last, TRUNCATION)
        assert np.abs(series[last - 1:last + 1, PS:PS + 3]).max() < 1e-15
        found = state.copy()
        advance(found, series, NO_CONTACT, FLIGHT, last, step, 1.0)
        expected = fly(fly(state, moment, 0.5 * step), moment, 0.5 * step)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)
