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

"""States of drops (height, velocity, up, spin) and how the kernels carry them on.

All that the tests of motions know about arrays of the kernels stands here.
"""

from typing import NamedTuple

import numpy as np

from ros_pose_stats.core.kernels.drops.layout import (
    COLUMNS,
    CONTACT,
    FLIGHT,
    FORCE,
    ORDER,
    PS,
    STATE,
    TORQUE,
    WS,
    P,
    V,
    W,
    Z,
)

from .helpers import (
    advance_state,
    free_series,
    rotate_freely,
    shorten_series,
    sliding_series,
)

TRUNCATION = (
    1e-16  # so that rounding alone parts the kernels from what is expected of them
)
VELOCITIES = [V, W, W + 1, W + 2]
GENERIC = (0.1, 0.2, 0.25)
SHAPES = {
    "generic": GENERIC,
    "needle": (1e-6, 0.3, 0.3 + 1e-9),
    "rod": (1e-12, 0.33, 0.33),
    "plate": (0.1, 0.2, 0.3 - 1e-9),
    "round plate": (0.15, 0.15, 0.3),
    "isotropic": (0.2, 0.2, 0.2),
    "oblate": (0.2, 0.2, 0.3),
    "prolate": (0.1, 0.3, 0.3),
    **{f"oblate but for {d:g}": (0.2, 0.2 + d, 0.3) for d in (1e-14, 1e-9, 1e-5)},
    **{f"prolate but for {d:g}": (0.1, 0.3, 0.3 + d) for d in (1e-9, 1e-2)},
    **{f"isotropic but for {d:g}": (0.2, 0.2 + d, 0.2 + 3 * d) for d in (1e-14, 1e-5)},
}


class Slid(NamedTuple):
    """A step of sliding: the state (8,) at its end, and how its forces and rates go."""

    state: np.ndarray
    step: float
    series: np.ndarray

    def forces(self, fraction):
        """Sum of the forces, and the second times the edge's length, at a share of the
        step.
        """
        power = fraction ** np.arange(len(self.series))
        return power @ self.series[:, [FORCE, TORQUE]] / self.step**2

    def rates(self, fraction):
        """Rates (2, 3) of up and spin."""
        power = np.arange(1, len(self.series)) * fraction ** np.arange(
            len(self.series) - 1
        )
        slopes = power @ self.series[1:] / self.step
        return np.array((slopes[PS : PS + 3], slopes[WS : WS + 3] / self.step))


def turning(moment, momentum, speed, seed):
    """State of a body turning about the angular momentum's direction (3,) in its
    axes.
    """
    random = np.random.default_rng(seed)
    state = np.zeros(STATE)
    up = np.cross(momentum, random.standard_normal(3))
    spin = np.asarray(momentum) / moment
    state[Z] = random.uniform(1.0, 3.0)
    state[V] = random.uniform(-1.0, 1.0)
    state[P : P + 3] = up / np.linalg.norm(up)
    state[W:] = speed * spin / np.linalg.norm(spin)
    return state


def turning_states(moment, count, seed):
    """States (count, 8) of all directions, every third near an axis; speeds from 0.5 to
    8.
    """
    random = np.random.default_rng(seed)
    states = []
    for k in range(count):
        momentum = random.standard_normal(3)
        if k % 3 == 1:
            momentum *= 10.0 ** random.uniform(-9.0, 0.0, 3)
        states.append(
            turning(moment, momentum, random.uniform(0.5, 8.0), 1000 * seed + k)
        )
    return np.array(states)


def fly(state, moment, time):
    """The state after a free flight, by power series step by step."""
    state = state.copy()
    series = np.zeros((ORDER + 1, COLUMNS))
    while time > 1e-15:
        step = min(1.0 / np.linalg.norm(state[W:]), time)
        last = free_series(state, moment, step, TRUNCATION, series)
        step *= shorten_series(series, last, TRUNCATION)
        advance_state(state, series, np.zeros(CONTACT), FLIGHT, last, step, 1.0)
        time -= step
    return state


def turn_at_once(state, moment, time):
    """The state after a free rotation in one go; None where that was refused,
    untouched.
    """
    turned = state.copy()
    if rotate_freely(turned, moment, time):
        assert tuple(turned[[Z, V]]) == tuple(state[[Z, V]])
        return turned
    np.testing.assert_array_equal(turned, state)
    return None


def slide(state, moment, contact, vertices, step):
    """One step of sliding on one vertex or two."""
    series = np.zeros((ORDER + 1, COLUMNS))
    last = sliding_series(
        state, moment, contact, vertices == 2, step, TRUNCATION, series
    )
    step *= shorten_series(series, last, TRUNCATION)
    state = state.copy()
    advance_state(state, series, contact, vertices, last, step, 1.0)
    return Slid(state, step, series[: last + 1])


def energy_of(state, moment):
    """Mechanical energy, the plate at 0."""
    return state[Z] + state[V] ** 2 / 2.0 + moment @ state[W:] ** 2 / 2.0


def off_invariants(state, moment):
    """How far |p| is from 1 and the angular momentum from normal to p."""
    momentum = moment * state[W:]
    return max(
        abs(np.linalg.norm(state[P : P + 3]) - 1.0),
        abs(state[P : P + 3] @ momentum) / max(np.linalg.norm(momentum), 1e-30),
    )
