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

"""What a method says of the poses of a part, and the statistics that come of it."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...base import version
from .. import tolerances
from .notes import Note
from .part import Array, Index, Part
from .poses import StablePose
from .scene import HIGHEST_DROP, DropScene, height_warnings
from .statistics import PoseStatistics


class Shares(NamedTuple):
    """What a method says of all poses (P,), by their index, and how sure it is."""

    probability: Array
    low: Array  # bounds of the 90 % intervals
    high: Array
    standard_error: Array
    counts: Index  # drops that came to rest, or parts that were seen; 0 for an estimate
    expected_error: float
    largest_error: float

    def without_errors(self) -> "Shares":
        """The same of a part whose errors nobody knows."""
        unknown = np.full(self.probability.shape, math.nan)
        return Shares(
            self.probability, unknown, unknown, unknown, self.counts, math.nan, math.nan
        )


def pose_statistics(
    part: Part,
    radius: float,
    poses: Iterable[StablePose],
    shares: Shares,
    method: str,
    scene: DropScene,
    *,
    knows_scene: bool = True,
    drops: int = 0,
    unsettled: int = 0,
    seed: int = 0,
    seconds: float,
    warnings: Iterable[Note],
) -> PoseStatistics:
    """Statistics of a part by a method.

    `radius`: of its body, metres; `poses`: all of them, by index; `knows_scene`:
    whether the method knows the drop height; `warnings`: beside those of the part.
    """
    scene_warnings = (
        height_warnings("drop", scene.drop_height, radius, HIGHEST_DROP)
        if knows_scene
        else []
    )
    release_height = scene.release_height(radius) if knows_scene else math.nan
    if not part.error_known:
        shares = shares.without_errors()
    return PoseStatistics(
        part_id=part.part_id,
        part_digest=part.digest,
        radius=radius,
        method=method,
        **{**vars(scene), "drop_height": release_height},
        poses=rank_poses(poses, shares),
        drops=drops,
        unsettled=unsettled,
        seed=seed,
        expected_error=shares.expected_error,
        largest_error=shares.largest_error,
        seconds=seconds,
        warnings=(*part.warnings, *scene_warnings, *warnings),
        version=version.VERSION,
        unit=part.unit,
        unit_guessed=part.unit_guessed,
        bodies=part.bodies,
    )


def with_shares(
    model: PoseStatistics, method: str, shares: Shares, **changes: Any
) -> PoseStatistics:
    """The same part and scene by another method.

    `changes`: other fields that differ.
    """
    return replace(
        model,
        method=method,
        poses=rank_poses(model.by_index.values(), shares),
        expected_error=shares.expected_error,
        largest_error=shares.largest_error,
        **changes,
    )


def rank_poses(poses: Iterable[StablePose], shares: Shares) -> tuple[StablePose, ...]:
    """Poses with their shares and those of their groups, the most probable first.

    Those equal but for rounding stay in the order of their index.
    """
    pose_list = list(poses)
    columns = [column.tolist() for column in shares[:5]]
    group_sums: dict[int, float] = {}
    for pose, probability in zip(pose_list, columns[0], strict=True):
        group_sums[pose.group] = group_sums.get(pose.group, 0.0) + probability
    weighted_poses = [
        pose.with_values(
            probability=probability,
            probability_low=low,
            probability_high=high,
            standard_error=standard_error,
            count=count,
            group_probability=group_sums[pose.group],
        )
        for pose, probability, low, high, standard_error, count in zip(
            pose_list, *columns, strict=True
        )
    ]
    rank = rank_probabilities(columns[0])
    order = sorted(range(len(weighted_poses)), key=rank.__getitem__)
    return tuple(weighted_poses[k] for k in order)


def rank_probabilities(probabilities: Iterable[float]) -> list[int]:
    """Ranks by falling probability, NaN as 0; those equal but for rounding have one."""
    return tolerances.number_equal(
        [0.0 if math.isnan(share) else -share for share in probabilities],
        tolerances.SAME_SHARE,
    )
