"""The estimate that drops are combined with."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..estimators.expected import expected_error
from ..estimators.registry import estimator
from ..geometry.poses import RestingPoses
from ..records import DropScene
from ..records.scene import LOW_DROP_RADII
from ..statistics.posterior import PosePrior
from ..statistics.posterior.fitted import FITTED_METHOD


def pose_prior(resting: RestingPoses, scene: DropScene, method: str = FITTED_METHOD) -> PosePrior:
    """What an estimate says before the first drop.

    A drop so low that the estimator does not know it leaves next to nothing of its worth, so
    that drops have the say.

    Parameters
    ----------
    resting : RestingPoses
    scene : DropScene
    method : str
        The estimator; how its errors scatter over parts was fitted for the default one.
    """
    base = estimator(method)
    estimate = estimated(base.name, resting, scene)
    expected = expected_error(base.name, resting, estimate, scene).here
    return PosePrior(estimate, [pose.group for pose in resting.poses],
                     expected if knows(base.name, resting, scene) else math.nan, scene.restitution)


def estimated(method: str, resting: RestingPoses, scene: DropScene) -> NDArray[np.float64]:
    """Probabilities (P,) by an estimator, in the order of `index`."""
    return estimator(method).function(resting, scene)


def knows(method: str, resting: RestingPoses, scene: DropScene) -> bool:
    """Whether the drop height is one that an estimator knows, or a usual one."""
    return estimator(method).knows_drop_height or not low_drop(resting, scene)


def low_drop(resting: RestingPoses, scene: DropScene) -> bool:
    """Whether the part is released so low that its pose at release matters."""
    return (scene.drop_height is not None
            and scene.drop_height < LOW_DROP_RADII * resting.body.radius)
