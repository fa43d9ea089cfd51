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

"""Free flight, step by step and in one go: scipy, closed forms and what is
conserved.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .motions import (
    GENERIC,
    SHAPES,
    P,
    V,
    W,
    Z,
    energy_of,
    fly,
    off_invariants,
    turn_at_once,
    turning,
    turning_states,
)

EXACT = 1e-11
CONSERVED = 1e-12
EVERY_SHAPE = pytest.mark.parametrize(
    "moment", [*map(np.array, SHAPES.values())], ids=SHAPES
)


def by_scipy(state, moment, time):
    """Up and spin (6,) after a free rotation, by Euler's equations."""

    def rates(_, y):
        turned = np.cross(y[:3], y[3:])
        return np.concatenate((turned, np.cross(moment * y[3:], y[3:]) / moment))

    step = 0.1 / np.linalg.norm(state[W:])
    return solve_ivp(
        rates,
        (0.0, time),
        state[P:],
        method="DOP853",
        rtol=3e-14,
        atol=1e-16,
        max_step=step,
    ).y[:, -1]


def assert_same_turn(turn, expected, error=EXACT):
    """Up and spin of two states, or (6,) of them."""
    speed = np.linalg.norm(expected[-3:])
    np.testing.assert_allclose(turn[-6:-3], expected[-6:-3], rtol=0, atol=error)
    np.testing.assert_allclose(turn[-3:], expected[-3:], rtol=0, atol=error * speed)


@pytest.mark.parametrize(
    "name", ["generic", "plate", "oblate but for 1e-05", "isotropic"]
)
def test_against_scipy(name):
    moment = np.array(SHAPES[name])
    for state in turning_states(moment, 3, seed=1):
        assert_same_turn(fly(state, moment, 2.0), by_scipy(state, moment, 2.0))


@EVERY_SHAPE
def test_energy_and_angular_momentum_are_conserved(moment):
    for state in turning_states(moment, 12, seed=2):
        flown = fly(state, moment, 5.0)
        assert energy_of(flown, moment) == pytest.approx(
            energy_of(state, moment), rel=CONSERVED
        )
        assert np.linalg.norm(moment * flown[W:]) == pytest.approx(
            np.linalg.norm(moment * state[W:]), rel=CONSERVED
        )
        assert off_invariants(flown, moment) < CONSERVED


def test_the_spin_of_a_symmetric_top_circles_its_axis_and_the_height_is_a_parabola():
    """At the rate (I3 - I1) / I1 of its part along the axis."""
    moment = np.array((0.2, 0.2, 0.3))
    time = 4.0
    for state in turning_states(moment, 6, seed=4):
        flown = fly(state, moment, time)
        rate = (0.2 - 0.3) / 0.2 * state[W + 2]
        turned = (state[W] + 1j * state[W + 1]) * np.exp(-1j * rate * time)
        speed = np.linalg.norm(state[W:])
        assert flown[W] + 1j * flown[W + 1] == pytest.approx(turned, abs=EXACT * speed)
        assert flown[W + 2] == pytest.approx(state[W + 2], rel=1e-14)
        height = state[Z] + time * state[V] - time**2 / 2.0
        assert (flown[Z], flown[V]) == pytest.approx(
            (height, state[V] - time), abs=1e-13
        )


def assert_right_or_refused(state, moment, time):
    """A turn in one go is that of many steps; whether it was made."""
    turned = turn_at_once(state, moment, time)
    if turned is None:
        return False
    # What a rounding does to the turn grows with time; six units is the fall from 20
    # radii.
    assert_same_turn(turned, fly(state, moment, time), EXACT * max(1.0, time / 6.0))
    assert moment @ turned[W:] ** 2 == pytest.approx(moment @ state[W:] ** 2, rel=1e-12)
    assert off_invariants(turned, moment) < CONSERVED
    return True


@EVERY_SHAPE
def test_in_one_go_it_is_right_or_refused(moment):
    turns = [
        assert_right_or_refused(state, moment, 0.1 + 0.2 * k)
        for k, state in enumerate(turning_states(moment, 30, seed=7))
    ]
    # What is refused costs steps: only the third of the states that is near an axis may
    # be.
    assert sum(turns) >= 20 or moment[0] == moment[2]


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("tilt", [0.0, 1e-12, 1e-6, 1e-3, 0.01, 0.1])
def test_in_one_go_near_a_permanent_rotation(axis, tilt):
    moment = np.array(GENERIC)
    for k in range(6):
        momentum = np.eye(3)[axis] + tilt * np.roll(
            (0.0, np.cos(k + 0.5), np.sin(k + 0.5)), axis
        )
        state = turning(moment, momentum * (-1.0) ** k, 4.0, seed=k)
        turn = assert_right_or_refused(state, moment, 3.0)
        assert turn or axis == 1 or tilt < 0.01
        assert not turn or tilt > 0.0


@pytest.mark.parametrize("offset", [0.0, 1e-15, 1e-9, 1e-5, 1e-3, 0.05, 0.2])
def test_in_one_go_near_the_separatrix(offset):
    """On it L² = 2 E I2, that is (w3 / w1)² = I1 (I2 - I1) / I3 (I3 - I2)."""
    a, b, c = moment = np.array(GENERIC)
    steep = np.sqrt(a * (b - a) / (c * (c - b)))
    for k, side in enumerate(
        (1.0 + offset, 1.0 - offset, -1.0 - offset, -1.0 + offset)
    ):
        spin = np.array((1.0, 0.3 * (k + 1), side * steep))
        turn = assert_right_or_refused(
            turning(moment, moment * spin, 5.0, seed=k), moment, 4.0
        )
        assert turn or offset < 0.05


@pytest.mark.parametrize("spin", [(0.0, 0.5, 1.0), (0.0, 0.5, -1.0), (-1.0, 0.5, 0.0)])
def test_in_one_go_with_a_component_of_exactly_zero(spin):
    """At the start the amplitude is then exactly a quarter turn."""
    moment = np.array(GENERIC)
    assert assert_right_or_refused(
        turning(moment, moment * spin, 10.0, seed=1), moment, 3.0
    )


def test_in_one_go_for_no_time_for_long_and_from_rest():
    moment = np.array(GENERIC)
    for time in (0.0, 1e-9, 60.0):  # more than any drop from 20 radii is in the air for
        for state in turning_states(moment, 12, seed=8)[::3]:
            assert assert_right_or_refused(state, moment, time)
    assert (
        turn_at_once(np.array((3.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)), moment, 2.0)
        is None
    )
