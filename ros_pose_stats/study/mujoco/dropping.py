"""Whole drops by MuJoCo, at a chosen contact and time step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...records import Part
from .contact import Setting, choose_setting
from .plate import Array, Plate, random_turns


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


def mujoco_drops(part: Part, restitution: float, drops: int, seed: int,
                 penetration: float = 0.01, to_rest: bool = False) -> MujocoRun:
    """Drop a part from 20 radii, released at rest in random orientations.

    Parameters
    ----------
    part : Part
    restitution : float
        Above 0 and below 1; high enough that some time step gives it (0.2 does).
    drops, seed : int
    penetration : float
        Wanted depth of first impacts, in radii.
    to_rest : bool
        Whether to go on until the part rests, not only until its energy is below the barrier
        out of the pose that it is heading for.
    """
    plate = Plate(part)
    return dropped(plate, choose_setting(plate, restitution, penetration), drops, seed, to_rest)


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
