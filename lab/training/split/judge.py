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

"""Errors of split on families of bodies that a fit has not seen."""

from collections.abc import Sequence

import numpy as np

from lab.frame.documents import markdown_table
from ros_pose_stats.core.estimators.fitted import SplitFit
from ros_pose_stats.core.estimators.split import split
from ros_pose_stats.core.records import Array

from .samples import JUDGE_SEED, Sample
from .table import scenes_of


def errors_by_family(
    samples: Sequence[Sample], all_fits: Sequence[Sequence[SplitFit]]
) -> dict[str, Array]:
    """Root mean square errors (n,) of n sets of fits, in points, by family.

    Over the poses of the bodies for judging in all of their scenes, the noise of the
    drops taken off.
    """
    squares: dict[str, Array] = {}
    poses: dict[str, int] = {}
    judging = (row for row in samples if row.seed == JUDGE_SEED)
    for row, resting, scene in scenes_of(judging):
        settled = int(row.count.sum())
        share = row.count / settled
        noise = float((share * (1.0 - share)).sum()) / (settled - 1)
        away = [split(resting, scene, fits) - share for fits in all_fits]
        squares[row.family] = (
            squares.get(row.family, np.zeros(len(all_fits)))
            + np.square(away).sum(axis=1)
            - noise
        )
        poses[row.family] = poses.get(row.family, 0) + share.size
    squares["all"] = np.sum(list(squares.values()), axis=0)
    poses["all"] = sum(poses.values())
    return {
        family: 100.0 * np.sqrt(np.maximum(total / poses[family], 0.0))
        for family, total in squares.items()
    }


def errors_table(errors: dict[str, Array], names: Sequence[str]) -> str:
    """Markdown, a family a row."""
    rows = [
        (family, *(f"{value:.2f}" for value in values))
        for family, values in errors.items()
    ]
    return markdown_table(("family", *names), rows)
