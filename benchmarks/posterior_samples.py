"""Estimates and counts of the bodies of the reference datasets, as the posterior takes them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.benchmark.dataset import Dataset, shipped_datasets
from ros_pose_stats.estimators.expected import expected_error
from ros_pose_stats.geometry.poses import RestingPoses
from ros_pose_stats.planning.prior import estimated
from ros_pose_stats.statistics.posterior import PosePrior, PriorFit

Array = NDArray[np.float64]
Index = NDArray[np.int64]

RESTITUTIONS = (0.2, 0.5, 0.8)


class Sample(NamedTuple):
    """One body at one restitution.

    Attributes
    ----------
    body : int
        Number in its dataset.
    restitution : float
    estimate : (P,) array
    expected_error : float
    group : (P,) array of int
    blocks : (10, P) array of int
        Counts of the poses in each hundred drops.
    """

    body: int
    restitution: float
    estimate: Array
    expected_error: float
    group: Index
    blocks: Index

    def prior(self, fit: PriorFit | None = None) -> PosePrior:
        """What the estimate says of this body."""
        return PosePrior(self.estimate, self.group, self.expected_error, self.restitution, fit)


def samples(method: str, every: int = 1) -> list[Sample]:
    """Of every so many bodies of each reference dataset, restitution by restitution."""
    return [sample for dataset in shipped_datasets()
            for sample in _samples(dataset, method, range(0, dataset.spec.bodies, every))]


def _samples(dataset: Dataset, method: str, numbers: Iterable[int]) -> Iterator[Sample]:
    for number in numbers:
        resting = dataset.resting(number)
        span = slice(dataset.pose_starts[number], dataset.pose_starts[number + 1])
        for restitution in RESTITUTIONS:
            which = dataset.spec.restitutions.index(restitution)
            yield sample_of(number, resting, restitution, method,
                            dataset.arrays["count"][span, which].T.astype(np.int64))


def sample_of(number: int, resting: RestingPoses, restitution: float, method: str,
              blocks: Index) -> Sample:
    """A body, estimated."""
    estimate = estimated(method, resting)
    error = expected_error(method, resting, estimate, restitution).here
    group = np.array([pose.group for pose in resting.poses])
    return Sample(number, restitution, estimate, error, group, blocks)
