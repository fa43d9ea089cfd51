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

"""How far what cameras counted is from a prediction: one rule for node and bags."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base import text
from ..records import Array, Index, PoseStatistics
from .chi_square import ChiSquare, distance_chance, goodness_of_fit, homogeneity
from .errors import root_mean_square

BEYOND_CHANCE = 0.001
"""Chance below which counts are beyond what chance and a prediction's own error
explain."""

REFUTED = 0.05
"""Chance below which counts refute the model enough to be worth more than it alone."""

USUAL_ERRORS = 2.0
"""Errors of a plate, or of a prediction on it, up to which a difference is nothing
strange."""


@dataclass(frozen=True, eq=False)
class Forecast:
    """What a method says of the poses (K,) that a camera counts, and how sure it is."""

    probability: Array  # (K,)
    errors: Array  # (K,); standard errors; NaN where none are known
    plate_error: float  # expected of a real plate beside them, a fraction
    # (K,) int; drops from which the probabilities were counted, None where they were
    # not
    drop_counts: Index | None
    group: Index  # (K,) int; poses of one number look alike
    index: Index  # (K,) int; of the poses

    @cached_property
    def group_number(self) -> Index:
        """Group of each pose (K,), numbered from 0."""
        return np.unique(self.group, return_inverse=True)[1]

    def test_by_pose(self, counts: Index) -> ChiSquare:
        """Whether chance explains counts (K,); poses of a group share their error."""
        return self._test(counts, np.arange(counts.size), self.group_number)

    def test_by_group(self, counts: Index) -> ChiSquare:
        """The same where a camera cannot tell poses of a group apart."""
        return self._test(counts, self.group_number, np.arange(counts.size))

    def _test(self, counts: Index, bins: Index, unit: Index) -> ChiSquare:
        observed = np.bincount(bins, counts)
        if self.drop_counts is not None:
            return homogeneity(observed, np.bincount(bins, self.drop_counts))
        predicted = np.nan_to_num(np.bincount(bins, self.probability))
        if not predicted.sum() > 0.0:
            # Nothing was predicted.
            return goodness_of_fit(np.zeros(1), np.ones(1))
        return goodness_of_fit(
            observed,
            predicted,
            np.bincount(bins, self.errors),
            unit[: observed.size],
        )

    def describe_gap(self, counts: Index) -> str:
        """How far counts (K,) are from it; empty where chance may explain that."""
        if not self.test_by_group(counts).p_value < BEYOND_CHANCE:
            return ""
        share = counts / counts.sum()
        difference = np.abs(share - self.probability)
        worst = int(difference.argmax())
        gap = root_mean_square(difference)
        usual = ""
        if gap > USUAL_ERRORS * self.plate_error:
            usual = f", where a plate usually is {_points(self.plate_error)} off"
        return (
            f"what the cell counted is {_points(gap)} from the model (root mean square "
            f"over the poses){usual}, beyond chance and the model's own error, in pose "
            f"{self.index[worst]} most: counted {text.percent(share[worst])} %, "
            f"predicted {text.percent(self.probability[worst])} %"
            + "".join(f"; {words}" for words in self.describe_unreported(counts))
        )

    def describe_unreported(self, counts: Index) -> list[str]:
        """Which poses a camera never reports though parts must lie in them, if any.

        It may not tell poses of a group apart: groups are looked at as a whole.
        """
        number = self.group_number
        predicted = np.bincount(number, self.probability)
        error = np.hypot(np.bincount(number, self.errors), self.plate_error)
        least = np.maximum(0.0, predicted - USUAL_ERRORS * error)
        is_unlikely = (1.0 - least) ** counts.sum() < BEYOND_CHANCE
        is_unseen = np.bincount(number, counts) == 0
        unreported = np.flatnonzero((is_unseen & is_unlikely)[number])
        if not unreported.size:
            return []
        share = text.percent(float(self.probability[unreported].sum()))
        names = text.name_poses(self.index[unreported].tolist())
        return [f"the camera never reports {names}, predicted {share} %"]


def share_errors(
    probability: Array, standard_error: Array, expected_error: float
) -> Array:
    """Standard errors (K,) of shares, else from their expected error; maybe NaN."""
    spread = probability * (1.0 - probability)
    if np.isfinite(standard_error).all() or not spread.sum() > 0.0:
        return standard_error
    return np.asarray(expected_error * np.sqrt(spread * spread.size / spread.sum()))


def describe_use(statistics: PoseStatistics) -> str:
    """Whether an observed answer says more than the model alone; empty for others."""
    if not statistics.counted_parts or math.isnan(statistics.model_gap):
        return ""
    probability = np.array([pose.probability for pose in statistics.poses])
    square = np.array(probability.size * statistics.model_gap**2)
    chance = distance_chance(square, probability, statistics.counted_parts)
    gap = f"{_points(statistics.model_gap)} between it and what was counted"
    if chance < REFUTED:
        return f"use it: the default is refuted, chance does not explain the {gap}"
    return f"do not use it: the default is as good, chance explains the {gap}"


def _points(error: float) -> str:
    return f"{100.0 * error:.2g} points"
