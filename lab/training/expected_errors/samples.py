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

"""Square errors of all methods on bodies of many families, with the inputs of the
fit.
"""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.estimators.fitted import (
    error_inputs,
    error_scale,
    reference_answers,
)
from ros_pose_stats.core.records import Array, DropScene, Index
from ros_pose_stats.core.resting.poses import RestingPoses

from ..split.samples import Sample
from ..split.table import scenes_of

DECIDED = 1e-6
"""Samples with a smaller mean error scale are left out: symmetry leaves one answer."""


class ErrorSamples(NamedTuple):
    """One method on bodies in scenes; U samples.

    Attributes
    ----------
    inputs : (U, 17) array
        As from `fitted.error_inputs`.
    scale : (U,) array
        Mean of `fitted.error_scale`.
    square, noise : (U,) arrays
        Mean square distance from the counted shares, and how much of it is the drops'
        own.
    freedom : (U,) array
        Degrees of freedom of such a mean square of the drops.
    poses : (U,) array of int
    """

    inputs: Array
    scale: Array
    square: Array
    noise: Array
    freedom: Array
    poses: Index


def error_samples(
    samples: Sequence[Sample], methods: Collection[str]
) -> dict[str, ErrorSamples]:
    """Samples by the name of the method; a body takes some ten milliseconds."""
    rows: dict[str, list[tuple[object, ...]]] = {name: [] for name in methods}
    answers_known = np.zeros((3, 0))
    of_body = None
    for row, resting, scene, answers in answered(samples, methods):
        if resting is not of_body:
            answers_known = reference_answers(resting)
            of_body = resting
        share, noise = counted(row)
        for name, estimate in answers.items():
            scale = error_scale(resting, estimate, answers_known)
            if scale.mean() > DECIDED:
                inputs = error_inputs(
                    resting, estimate[None], scene, answers_known, scale[None]
                )
                rows[name].append(
                    (
                        inputs[0],
                        float(scale.mean()),
                        float(np.mean(np.square(estimate - share))),
                        noise,
                        freedom(share),
                        share.size,
                    )
                )
    return {
        name: ErrorSamples(*(np.array(column) for column in zip(*columns, strict=True)))
        for name, columns in rows.items()
    }


def answered(
    samples: Sequence[Sample], methods: Collection[str] = tuple(ESTIMATORS)
) -> Iterator[tuple[Sample, RestingPoses, DropScene, dict[str, Array]]]:
    """Samples with poses, scene and the answers (P,) of methods."""
    blind: dict[str, Array] = {}
    of_body = None
    for row, resting, scene in scenes_of(samples):
        if resting is not of_body:
            blind = {}
            of_body = resting
        answers = {}
        for name in methods:
            entry = ESTIMATORS[name]
            answers[name] = (
                blind[name] if name in blind else entry.function(resting, scene)
            )
            if not entry.knows_scene:
                blind[name] = answers[name]
        yield row, resting, scene, answers


def counted(row: Sample) -> tuple[Array, float]:
    """Shares (P,) of the drops, and their mean square error."""
    settled = int(row.count.sum())
    share = row.count / settled
    return share, float(np.mean(share * (1.0 - share))) / (settled - 1)


def freedom(share: Array) -> float:
    """Squares of independent numbers that a sum of the squares of multinomial errors is
    like.
    """
    covariance = np.diag(share) - np.outer(share, share)
    squares = float(np.square(covariance).sum())
    return float(np.trace(covariance)) ** 2 / squares if squares > 0.0 else 1.0
