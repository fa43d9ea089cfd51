"""Probability of the four sides of a square prism: estimated, and counted over drops."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...estimators import ESTIMATORS
from ...mesh.parts import part_from_mesh
from ...records import DropScene, Part, StablePose
from ...resting.poses import resting_poses
from ...shapes import box
from ...simulation.simulate import simulate
from ...statistics.intervals import jeffreys_interval
from .results import LEVEL, SidesPoint

Array = NDArray[np.float64]

WIDTH = 0.01
"""Side of the square, metres. Nothing depends on it: drops start at a multiple of the radius."""

SCENE = DropScene(cluster_tolerance=0.0)
"""Of estimators that know the scene: the usual restitution and drop height."""

SQUARE_FACE = 0.9
"""A pose with a larger |down_z| lies on a square face; sides have 0, square faces 1."""


def square_prism(ratio: float) -> Part:
    """Square prism along z of the given length over width, homogeneous."""
    return part_from_mesh(*box(WIDTH, WIDTH, ratio * WIDTH))


def on_squares(poses: Iterable[StablePose]) -> list[StablePose]:
    """The poses on a square face of a prism along z."""
    return [pose for pose in poses if abs(pose.down[2]) > SQUARE_FACE]


def estimated_sides(ratios: ArrayLike) -> dict[str, Array]:
    """Probability of the four sides by every estimator, without clusters, in the usual scene.

    Parameters
    ----------
    ratios : (k,) array
        Length over width, above 0.

    Returns
    -------
    dict of str to (k,) array
        By the estimator's name, in the registry's order; 0 to 1.
    """
    lengths = np.asarray(ratios, dtype=np.float64)
    found = {name: np.empty_like(lengths) for name in ESTIMATORS}
    for place, ratio in enumerate(lengths.tolist()):
        resting = resting_poses(square_prism(ratio), 0.0)
        squares = [pose.index for pose in on_squares(resting.poses)]
        for name, estimator in ESTIMATORS.items():
            found[name][place] = 1.0 - estimator.function(resting, SCENE)[squares].sum()
    return found


def dropped_sides(ratio: float, restitution: float, drops: int, seed: int,
                  workers: int | None = None,
                  should_stop: Callable[[], bool] | None = None) -> SidesPoint | None:
    """Share of drops from 20 radii that come to rest on a side; None if stopped before the end.

    The parameters are those of `simulate`. Drops that did not settle are left out of the share.
    """
    found = simulate(square_prism(ratio), drops, restitution, seed, workers=workers,
                     should_stop=should_stop, cluster_tolerance=0.0)
    settled = found.drops - found.unsettled
    if found.drops < drops or not settled:
        return None
    return counted(ratio, settled - sum(pose.count for pose in on_squares(found.poses)), settled)


def counted(ratio: float, sides: int, trials: int) -> SidesPoint:
    """A share that was counted, with its interval."""
    low, high = jeffreys_interval(sides, trials, LEVEL)
    return SidesPoint(ratio, sides / trials, float(low), float(high), trials)
