"""States of drops and how the kernels carry them on, for the tests of the kernels.

The helpers of the kernels can be called from Python one by one; each is compiled then.
"""

from __future__ import annotations

import numpy as np

from ros_pose_stats.kernels.drops.free_motion import free_series, shorten
from ros_pose_stats.kernels.drops.layout import COLUMNS, CONTACT, FLIGHT, ORDER, STATE, P, V, W, Z
from ros_pose_stats.kernels.drops.motion import advance
from ros_pose_stats.tolerances import TRUNCATION

NO_CONTACT = np.zeros(CONTACT)
GENERIC = (0.1, 0.2, 0.25)
SHAPES = {
    "generic": GENERIC, "needle": (1e-6, 0.3, 0.3 + 1e-9), "rod": (1e-12, 0.33, 0.33),
    "plate": (0.1, 0.2, 0.3 - 1e-9), "round plate": (0.15, 0.15, 0.3),
    "isotropic": (0.2, 0.2, 0.2), "oblate": (0.2, 0.2, 0.3), "prolate": (0.1, 0.3, 0.3),
    **{f"oblate but for {d:g}": (0.2, 0.2 + d, 0.3) for d in (1e-14, 1e-9, 1e-5, 1e-2)},
    **{f"prolate but for {d:g}": (0.1, 0.3, 0.3 + d) for d in (1e-14, 1e-9, 1e-5, 1e-2)},
    **{f"isotropic but for {d:g}": (0.2, 0.2 + d, 0.2 + 3 * d) for d in (1e-14, 1e-9, 1e-5)},
}


def turning(moment, momentum, speed, seed):
    """State (8,) of a body turning about the angular momentum's direction (3,) in its axes."""
    random = np.random.default_rng(seed)
    state = np.zeros(STATE)
    up = np.cross(momentum, random.standard_normal(3))
    spin = np.asarray(momentum) / moment
    state[Z], state[V] = random.uniform(1.0, 3.0), random.uniform(-1.0, 1.0)
    state[P:P + 3] = up / np.linalg.norm(up)
    state[W:] = speed * spin / np.linalg.norm(spin)
    return state


def turning_states(moment, count, seed):
    """States (count, 8) with the angular momentum in any direction, every third one near an axis.

    Speeds from 0.5 to 8.
    """
    random = np.random.default_rng(seed)
    states = []
    for k in range(count):
        momentum = random.standard_normal(3)
        if k % 3 == 1:
            momentum *= 10.0 ** random.uniform(-9.0, 0.0, 3)
        states.append(turning(moment, momentum, random.uniform(0.5, 8.0), 1000 * seed + k))
    return np.array(states)


def fly(state, moment, time):
    """The state (8,) after a free flight, by power series."""
    state, series = state.copy(), np.zeros((ORDER + 1, COLUMNS))
    left = time
    while left > 1e-15:
        step = min(1.0 / np.linalg.norm(state[W:]), left)
        last = free_series(state, moment, step, TRUNCATION, series)
        step *= shorten(series, last, TRUNCATION)
        advance(state, series, NO_CONTACT, FLIGHT, last, step, 1.0)
        left -= step
    return state


def energy_of(state, moment):
    """Mechanical energy, the plate at 0."""
    return state[Z] + state[V] ** 2 / 2.0 + moment @ state[W:] ** 2 / 2.0


def off_invariants(state, moment):
    """How far |p| is from 1 and the angular momentum from normal to p."""
    momentum = moment * state[W:]
    return max(abs(np.linalg.norm(state[P:P + 3]) - 1.0),
               abs(state[P:P + 3] @ momentum) / max(np.linalg.norm(momentum), 1e-30))
