"""Soft contacts of MuJoCo with a wanted restitution and depth, and the time steps they need.

A direct `solref = (-stiffness, -damping)` lets the depth x of a touching vertex obey
x'' + 2 zeta omega x' + omega² x = 0, whatever the leverage, until the force would pull. With
zeta = cos(phi), phi being imaginary above zeta = 1, this gives

    restitution = exp(-2 phi / tan(phi)),    duration = 2 phi / (omega sin(phi)),
    depth       = speed sqrt(restitution) / omega.

`setting` aims these at the wanted restitution and depth and corrects the aim by what first
impacts from 20 radii show.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .plate import HEIGHT, Array, Plate, random_turns

IMPACTS, CORRECTIONS = 64, 4


@dataclass(frozen=True)
class Setting:
    """A contact and time step, and what 64 first impacts from 20 radii show of them.

    Attributes
    ----------
    stiffness, damping, step : float
    steps : int
        Time steps in a contact.
    penetration : float
        Median over the impacts of the greatest depth.
    restitution : float
        Median over the impacts of the vertex's speed after by that before.
    low, high : float
        10 % and 90 % quantiles of the same.
    typical : float
        Median absolute error of restitution.
    """

    stiffness: float
    damping: float
    step: float
    steps: int
    penetration: float
    restitution: float
    low: float
    high: float
    typical: float


def contact(restitution: float, depth: float, steps: int) -> tuple[float, float, float]:
    """Stiffness, damping and time step by the closed forms above, for a fall from 20 radii."""
    low, high = 0.0, 1e3  # of zeta; restitution falls with it
    for _ in range(100):
        zeta = 0.5 * (low + high)
        phi = cmath.acos(zeta)
        if (2.0 * phi / cmath.tan(phi)).real < -math.log(restitution):
            low = zeta
        else:
            high = zeta
    omega = math.sqrt(2.0 * (HEIGHT - 1.0) * restitution) / depth
    return omega**2, 2.0 * zeta * omega, (2.0 * phi / cmath.sin(phi)).real / omega / steps


def setting(plate: Plate, restitution: float, penetration: float, steps: int) -> Setting:
    """A contact of so many time steps, the aim corrected by what comes out."""
    rng = np.random.default_rng(0)
    turns, phases = random_turns(rng, IMPACTS), rng.random(IMPACTS)
    aim, depth = restitution, penetration
    for _ in range(CORRECTIONS + 1):
        found = contact(aim, depth, steps)
        plate.soften(*found)
        impacts = np.array(list(map(plate.first_impact, turns, phases)))
        deepest, ratio = np.median(impacts, axis=0).tolist()
        aim = min(max(aim * restitution / ratio, 0.05), 0.99)
        depth *= penetration / deepest
    low, high = np.quantile(impacts[:, 1], (0.1, 0.9)).tolist()
    typical = float(np.median(np.abs(impacts[:, 1] - restitution)))
    return Setting(*found, steps, deepest, ratio, low, high, typical)


@dataclass(frozen=True, eq=False)
class MujocoRun:
    """Drops by MuJoCo.

    Attributes
    ----------
    drops : int
    seconds : float
        Inside `mj_step` only; the model is compiled and the setting chosen before.
    step, penetration, restitution : float
        Those of the setting: medians over first impacts.
    poses : (drops, 3) array
        Direction that points down at the end, part axes.
    index : (drops,) array of int
        Stable pose, as in `resting_poses`, that each drop ended in.
    steps : int
        Of all drops.
    """

    drops: int
    seconds: float
    step: float
    penetration: float
    restitution: float
    poses: Array
    index: NDArray[np.int64]
    steps: int


def dropped(plate: Plate, setting: Setting, drops: int, seed: int,
            to_rest: bool = False) -> MujocoRun:
    """Drop at a given setting."""
    plate.soften(setting.stiffness, setting.damping, setting.step)
    levels = plate.rested if to_rest else plate.decided
    seconds, steps, downs, index = zip(
        *(plate.drop(turn, levels) for turn in random_turns(np.random.default_rng(seed), drops)),
        strict=True)
    return MujocoRun(drops, sum(seconds), setting.step, setting.penetration,
                     setting.restitution, np.array(downs), np.array(index), sum(steps))
