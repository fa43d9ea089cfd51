"""What fitted functions know of a body and of the scene."""

from __future__ import annotations

import math

import numpy as np

from ..records import DropScene
from ..records.scene import DEFAULT_DROP_RADII
from ..resting.poses import RestingPoses
from .estimator import Array
from .split_weights import HIGHEST_DROP, HIGHEST_RESTITUTION

LOWEST_DROP = 1.0
"""Radii."""

LEAST_CROWDING = 1e-4
"""Crowding of corners that logarithms start from."""


def scene_inputs(resting: RestingPoses, scene: DropScene) -> Array:
    """Restitution and log of the drop height in radii (2,), or the nearest that was fitted to."""
    radii = DEFAULT_DROP_RADII
    if scene.drop_height is not None:
        radii = scene.drop_height / resting.body.radius
    return np.array([min(scene.restitution, HIGHEST_RESTITUTION),
                     math.log(min(max(radii, LOWEST_DROP), HIGHEST_DROP))])


def corner_inputs(resting: RestingPoses) -> Array:
    """Logarithms of how far the body turns in few corners, at two reaches (2,)."""
    return np.asarray(np.log(resting.corner_crowding + LEAST_CROWDING))
