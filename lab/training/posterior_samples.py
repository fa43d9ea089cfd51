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

"""Estimates and counts of bodies, to which the prior of `hybrid` is fitted."""

from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import NamedTuple

import numpy as np

from lab.bodies.families import MADE, family_part, family_poses
from ros_pose_stats.core.estimators.estimate import estimator
from ros_pose_stats.core.estimators.expected import expected_error
from ros_pose_stats.core.records import Array, DropScene, Index
from ros_pose_stats.core.resting.poses import RestingPoses
from ros_pose_stats.core.statistics.prior import PosePrior, PriorFit
from study.dataset import Dataset, shipped_datasets

from .split.samples import FIT_SEED, HEIGHT, USUAL, read_samples

RESTITUTIONS = USUAL


class Sample(NamedTuple):
    """One body at one restitution.

    Attributes
    ----------
    body : int
        Number in its series.
    restitution : float
    estimate : (P,) array
    expected_error : float
    unit : (P,) array of int
    count : (P,) array of int
        Settled drops in each pose.
    """

    body: int
    restitution: float
    estimate: Array
    expected_error: float
    unit: Index
    count: Index

    def prior(self, fit: PriorFit | None = None) -> PosePrior:
        """Prior of this body around its estimate."""
        return PosePrior(
            self.estimate, self.unit, self.expected_error, self.restitution, fit
        )


def samples(method: str, stride: int = 1) -> list[Sample]:
    """Samples of every so many bodies of each reference dataset and each other
    family.
    """
    of_datasets = [
        sample
        for dataset in shipped_datasets()
        for sample in _of_dataset(
            dataset, method, range(0, dataset.spec.bodies, stride)
        )
    ]
    return [*of_datasets, *_of_families(method, stride)]


def _of_dataset(
    dataset: Dataset, method: str, numbers: Iterable[int]
) -> Iterator[Sample]:
    for number in numbers:
        resting = dataset.resting(number)
        span = slice(dataset.pose_starts[number], dataset.pose_starts[number + 1])
        for restitution in RESTITUTIONS:
            column = dataset.spec.restitutions.index(restitution)
            count = dataset.arrays["count"][span, column].sum(axis=1).astype(np.int64)
            yield sample_of(number, resting, restitution, method, count)


def _of_families(method: str, stride: int) -> Iterator[Sample]:
    """Samples of bodies from the usual height, of all families but random polyhedra."""
    usual_rows = (
        row
        for row in read_samples()
        if row.seed == FIT_SEED
        and row.family in MADE
        and row.number % stride == 0
        and row.height == HEIGHT
        and row.restitution in RESTITUTIONS
        and row.count.any()
    )
    for key, rows in groupby(usual_rows, lambda row: row[:3]):
        resting = family_poses(key[0], family_part(*key))
        for row in rows:
            yield sample_of(row.number, resting, row.restitution, method, row.count)


def sample_of(
    number: int, resting: RestingPoses, restitution: float, method: str, count: Index
) -> Sample:
    """Make a sample: a body with its estimate."""
    scene = DropScene(restitution)
    estimate = estimator(method).function(resting, scene)
    error = expected_error(method, resting, estimate, scene).part_error
    return Sample(number, restitution, estimate, error, resting.unit, count)
