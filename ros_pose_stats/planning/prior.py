"""The estimate that drops are combined with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..estimators.expected import expected_error
from ..estimators.registry import estimator
from ..records import DropScene
from ..records.scene import LOW_DROP_RADII
from ..resting.poses import RestingPoses
from ..statistics.posterior import PosePrior
from ..statistics.posterior.fitted import FITTED_METHOD


class Estimated(Protocol):
    """Of an estimate, its method, its poses with `index`, `group` and `probability`, its error."""

    @property
    def method(self) -> str: ...  # noqa: D102 - as in PoseStatistics
    @property
    def poses(self) -> Sequence[Any]: ...  # noqa: D102
    @property
    def expected_error(self) -> float: ...  # noqa: D102


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
    estimate = estimated(method, resting, scene)
    expected = expected_error(method, resting, estimate, scene).here
    return PosePrior(estimate, [pose.group for pose in resting.poses],
                     expected if knows(method, resting, scene) else math.nan, scene.restitution)


def prior_of(found: Estimated, resting: RestingPoses, scene: DropScene) -> PosePrior:
    """The same from an estimate that was made before, or from its message.

    Parameters
    ----------
    found : PoseStatistics
        Of an estimator, of this part in this scene.
    resting : RestingPoses
    scene : DropScene
    """
    poses = sorted(found.poses, key=lambda pose: pose.index)
    expected = found.expected_error if knows(found.method, resting, scene) else math.nan
    return PosePrior([pose.probability for pose in poses], [pose.group for pose in poses],
                     expected, scene.restitution)


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
