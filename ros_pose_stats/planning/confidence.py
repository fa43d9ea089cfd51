"""How sure an estimate is of a part, alone and as what drops are combined with.

Sentences about it are here, too; those of commands, library and node are the same.
"""

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..estimators.expected import expected_error
from ..estimators.registry import estimator
from ..records import DropScene
from ..records import scene as scenes
from ..resting.poses import RestingPoses
from ..statistics.errors import AT_A_LOOK, Judged, judge_counts
from ..statistics.fitted_prior import FITTED_METHOD
from ..statistics.prior import PosePrior

Counts = NDArray[np.int64]

FIRST_LOOK = 10
"""Drops before the first look at the error: an estimate may need no more."""

WORTHLESS = 0.02
"""An estimate that stands for less than this share of the drops needed is left out."""

SOON = 1.4
"""The first look, in drops for which the expected error is the target; its bound needs more."""

LEAST_POINTS = 0.01
"""What is told of an error that symmetry makes vanish."""


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

    `method`: the estimator; how its errors scatter over parts was fitted for the default one.
    """
    estimate = estimated(method, resting, scene)
    expected = expected_error(method, resting, estimate, scene).here
    return PosePrior(estimate, [pose.group for pose in resting.poses],
                     expected if knows(method, resting, scene) else math.nan, scene.restitution)


def prior_of(found: Estimated, resting: RestingPoses, scene: DropScene) -> PosePrior:
    """The same from an estimate that was made before, or from its message.

    `found`: of an estimator, of this part in this scene.
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
    return estimator(method).knows_scene or not low_drop(resting, scene)


def low_drop(resting: RestingPoses, scene: DropScene) -> bool:
    """Whether the part is released so low that its pose at release matters."""
    return (scene.drop_height is not None
            and scene.drop_height < scenes.LOW_DROP_RADII * resting.body.radius)


def estimate_bound(prior: PosePrior) -> float:
    """Error that an estimate alone keeps with 90 % confidence; infinite if nothing is known.

    How errors scatter over parts was fitted for the default estimator; others of larger errors
    scatter less, and keep the bound more often.
    """
    if not prior.known and len(prior.size) > 1:
        return math.inf
    return prior.updated(np.zeros(prior.unit.shape, dtype=np.int64)).error_quantile()


def worthwhile(prior: PosePrior, target_error: float) -> bool:
    """Whether an estimate, or symmetry, saves a share of the drops that is worth having."""
    return (len(prior.size) < len(prior.unit)
            or prior.strength > WORTHLESS * plain_drops(prior, target_error))


def plain_drops(prior: PosePrior, target_error: float) -> float:
    """Drops that have the target as their expected error, if the estimate is about right."""
    spread = prior.mean * (1.0 - prior.mean) / prior.size
    return float(spread.sum()) / (len(prior.unit) * target_error ** 2)


def first_look(prior: PosePrior, target_error: float, helped: bool) -> int:
    """Drops before the first look: a look costs as much as a dozen drops, and few are enough.

    It depends on part, scene and target alone, so the answer does not depend on the timing.
    """
    needed = plain_drops(prior, target_error) - (prior.strength if helped else 0.0)
    return max(FIRST_LOOK, int(SOON * needed))


def judge_drops(prior: PosePrior | None, counts: Counts) -> Judged:
    """What counts (P,) are worth with an estimate; alone without one, or where they refute it."""
    if prior is None or prior.contradicted(counts).any():
        return judge_counts(counts)
    posterior = prior.updated(counts)
    return Judged(posterior.expected_error, posterior.error_quantile(AT_A_LOOK))


def points(error: float) -> str:
    """An error as a number of points.

    `error`: a fraction.
    """
    return f"{max(100.0 * error, LEAST_POINTS):.2g} points"


def enough(what: str, bound: float, target_error: float) -> str:
    """Why an answer is kept: its bound keeps the target."""
    return (f"{what} is within {points(bound)} with 90 % confidence, and {points(target_error)} "
            f"were asked for.")


def not_enough(what: str, bound: float, target_error: float) -> str:
    """Why an answer is not: the beginning of a sentence."""
    return (f"{what} is within {points(bound)} with 90 % confidence, not within "
            f"{points(target_error)}")
