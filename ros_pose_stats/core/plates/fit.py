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

"""The restitution and the drop height that explain what was counted on a plate.

Of the scenes of a grid the one nearest to what `likelihood` makes of the counts, and
how far off parts are in what the others ask for.
"""

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from ...base import errors, text
from ..estimators.expected import expected_error
from ..estimators.split import split
from ..records import Array
from ..records.scene import DEFAULT_PLATE_ERROR, DEFAULT_ROUND_SIDES, Numbering
from ..statistics.chi_square import goodness_of_fit
from .counts import CountedPart
from .likelihood import (
    HEIGHTS,
    RESTITUTIONS,
    ROUND_SIDES,
    ExplainedPart,
    SceneGrid,
    is_rolling_part,
    nearest_scene,
    weigh_scenes,
)

FEWEST_COUNTS = 50  # parts of all kinds together

MOST_PARTS = 16
"""Kinds; those counted most. More of them hardly change a fit, and each takes its
time."""

UNKNOWN_SIDES = DEFAULT_ROUND_SIDES, min(ROUND_SIDES), max(ROUND_SIDES)
"""What counts without round parts say: nothing is excluded."""

DEFAULT_NUMBER = 0  # of the default scene among all of a grid

INTERVAL_FALL = 2.7055
"""Twice the fall of the logarithm of the likelihood at the bounds of a 90 % interval
(Wilks)."""

UNTESTED_WEIGHT = 0.1
"""Parts that the error of an unknown plate counts as, beside those that a fit was
tested on; chosen on plates that the study does not judge."""

STRANGE_CHANCE = 0.01
"""Chance at which one of the parts of a plate is said to stand out though it does not,
at most; Bonferroni's bound over the parts."""

FEWEST_TO_STAND_OUT = 3  # parts; of two that differ nobody can tell which is wrong

AS_DEFAULT = -1.0  # drop height of the default scene: 20 radii of each part

Interval = tuple[float, float, float]
"""A fitted value and the bounds of its 90 % interval."""


@dataclass(frozen=True, eq=False)
class PartEvidence:
    """What one part says about a plate."""

    part_id: str
    part_digest: str
    total: int
    # indices of the poses of each group, whose poses look alike
    poses: tuple[tuple[int, ...], ...]
    observed: Array  # (G,); shares of the groups as counted
    expected: Array  # (G,); the same in the fitted scene
    # root mean square of their difference, the noise of the counts taken off; 0 to 1
    error: float
    numbering: Numbering  # of its poses
    # (P,); probabilities in the scene that the other parts ask for, in the default one
    # where there are none
    left_out: Array
    left_out_error: float  # the error there
    default_error: float  # the error in the default scene
    chance: float  # of counts as far from what the other parts make likely


@dataclass(frozen=True, eq=False)
class PlateFit:
    """The scene that stands for a plate."""

    restitution: Interval  # effective
    drop_height: Interval  # effective, metres, or AS_DEFAULT
    # effective sides a turn of round parts, and the least and most of those looked at
    # that the counts do not exclude
    round_sides: tuple[int, int, int]
    default_weight: float  # probability that the default scene explains the counts best
    # expected root mean square error, over groups of poses, on an uncounted part
    plate_error: float
    default_error: float  # the same of the default scene, judged by the same parts
    p_value: float  # of the counts in the fitted scene; NaN where nothing can test it
    total: int  # parts of all kinds
    parts: tuple[PartEvidence, ...]  # by digest
    seconds: float = math.nan

    @property
    def is_better(self) -> bool:
        """Whether the parts are predicted better by each other than by the default.

        Where one stands out nobody knows: its error is most of both.
        """
        return self.strange_part is None and self.plate_error < self.default_error

    @property
    def strange_part(self) -> PartEvidence | None:
        """The part that the others contradict beyond chance, if one does."""
        if len({part.part_digest for part in self.parts}) < FEWEST_TO_STAND_OUT:
            return None
        strangest = min(self.parts, key=lambda part: part.chance)
        if strangest.chance < STRANGE_CHANCE / len(self.parts):
            return strangest
        return None

    @property
    def verdict(self) -> str:
        """In words, which part stands out, if one does, and whether to use the fit."""
        strange_part = self.strange_part
        warning = ""
        if strange_part is not None:
            warning = (
                f"{strange_part.part_id} stands out, "
                f"{text.percent(strange_part.left_out_error)} points from what the "
                "other parts ask for: count it again or leave it out; "
            )
        if len({part.part_digest for part in self.parts}) == 1:
            return (
                f"{warning}do not use it: one part cannot tell whether the default is "
                "as good, count another one"
            )
        fitted_points = text.percent(self.plate_error)
        default_points = text.percent(self.default_error)
        advice = "do not use it: the default is as good"
        if self.is_better:
            advice = "use it"
        elif self.plate_error < self.default_error:
            advice = "do not use it before that"
        return (
            f"{warning}{advice} (expected error on another part {fitted_points} "
            f"points, by the default {default_points})"
        )


def fit_plate(counted_parts: Sequence[CountedPart]) -> PlateFit:
    """Fit restitution, drop height and what rolling loses to counts of parts.

    The fitted scene is the one, default or of the grid, whose shares are nearest to
    those averaged over all scenes by their probability. The same counts give the same
    fit to the last bit, in any order. Poses that look alike count together.
    """
    begin = time.perf_counter()
    usable_parts = choose_parts(counted_parts)
    has_rolling = any(map(is_rolling_part, usable_parts))
    sides = ROUND_SIDES if has_rolling else ROUND_SIDES[:1]
    grid = SceneGrid([part.resting.body.radius for part in usable_parts], sides)
    parts = [ExplainedPart(part, grid) for part in usable_parts]

    logarithm, weight = weigh_scenes(parts, grid)
    fitted_number = nearest_scene(parts, weight)
    scene = grid.scenes[fitted_number]
    other_numbers = [_scene_by_other_parts(part, parts, grid) for part in parts]

    profiles = logarithm[1:].reshape(len(sides), RESTITUTIONS.size, HEIGHTS)
    return PlateFit(
        restitution=_interval(
            RESTITUTIONS, profiles.max(axis=(0, 2)), scene.restitution
        ),
        drop_height=_interval(
            grid.height, profiles.max(axis=(0, 1)), scene.drop_height or AS_DEFAULT
        ),
        round_sides=(
            _sides_interval(sides, profiles.max(axis=(1, 2)), scene.round_sides)
            if has_rolling
            else UNKNOWN_SIDES
        ),
        default_weight=float(weight[0]),
        plate_error=math.sqrt(_plate_square(parts, fitted_number, other_numbers)),
        default_error=math.sqrt(
            _plate_square(parts, fitted_number, [DEFAULT_NUMBER] * len(parts))
        ),
        p_value=_p_value(parts, fitted_number, grid),
        total=sum(part.total for part in usable_parts),
        parts=tuple(
            _part_evidence(part, parts, fitted_number, other_number)
            for part, other_number in zip(parts, other_numbers, strict=True)
        ),
        seconds=time.perf_counter() - begin,
    )


def _scene_by_other_parts(
    part: ExplainedPart, parts: Sequence[ExplainedPart], grid: SceneGrid
) -> int:
    """Number of the scene that the other parts ask for; the default one without any."""
    others = _other_parts(part, parts)
    return nearest_scene(others, weigh_scenes(others, grid)[1])


def _other_parts(
    part: ExplainedPart, parts: Sequence[ExplainedPart]
) -> list[ExplainedPart]:
    return [other for other in parts if other.digest != part.digest]


def _part_evidence(
    part: ExplainedPart,
    parts: Sequence[ExplainedPart],
    fitted_number: int,
    other_number: int,
) -> PartEvidence:
    """What a part says, given the fitted scene and the one of the other parts."""
    counted_part = part.counted_part
    group = counted_part.resting.group
    return PartEvidence(
        part_id=counted_part.part.part_id,
        part_digest=part.digest,
        total=counted_part.total,
        poses=tuple(
            tuple(np.flatnonzero(group == number).tolist())
            for number in range(part.group_counts.size)
        ),
        observed=part.group_counts / part.group_counts.sum(),
        expected=part.shares[fitted_number],
        error=math.sqrt(max(part.square_error(fitted_number), 0.0)),
        numbering=counted_part.numbering,
        left_out=(part.shares[other_number] / np.bincount(group))[group],
        left_out_error=math.sqrt(max(part.square_error(other_number), 0.0)),
        default_error=math.sqrt(max(part.square_error(DEFAULT_NUMBER), 0.0)),
        chance=part.chance_beside(_other_parts(part, parts)),
    )


def _plate_square(
    parts: Sequence[ExplainedPart], fitted_number: int, other_numbers: Sequence[int]
) -> float:
    """Square of the error on an uncounted part, by what the others predict of each."""
    unknown = DEFAULT_PLATE_ERROR**2
    has_others = len({part.digest for part in parts}) > 1
    tests: dict[str, tuple[float, float]] = {}  # weight and square error, by digest
    for part, other_number in zip(parts, other_numbers, strict=True):
        test = (
            (unknown / (unknown + part.noise)) ** 2,
            part.square_error(other_number if has_others else fitted_number),
        )
        tests[part.digest] = max(tests.get(part.digest, (0.0, 0.0)), test)

    if not has_others:
        # The scene was fitted to this very part, which can only speak against the
        # plate.
        return max(unknown, tests.popitem()[1][1])
    total = max(sum(weight * square for weight, square in tests.values()), 0.0)
    return (total + UNTESTED_WEIGHT * unknown) / (
        sum(weight for weight, _ in tests.values()) + UNTESTED_WEIGHT
    )


def choose_parts(counted_parts: Iterable[CountedPart]) -> list[CountedPart]:
    """Parts that a fit can use, by digest; equally numbered counts are added up."""
    sums: dict[tuple[str, Numbering], CountedPart] = {}
    for part in counted_parts:
        key = part.part.digest, part.numbering
        if key in sums:
            sums[key] = replace(sums[key], counts=sums[key].counts + part.counts)
        else:
            sums[key] = part
    parts = [sums[key] for key in sorted(sums)]

    usable_parts = [part for part in parts if part.total and part.by_group.size > 1]
    usable_parts.sort(key=lambda part: -part.total)
    usable_parts = usable_parts[:MOST_PARTS]
    if not usable_parts and any(part.total for part in parts):
        raise errors.RequestError(
            "counts of a part that can lie in two ways",
            text.listed([part.part.part_id for part in parts]) or "none",
            "count another part on this plate",
        )
    total = sum(part.total for part in usable_parts)
    if total < FEWEST_COUNTS:
        raise errors.RequestError(
            f"at least {FEWEST_COUNTS} counted parts",
            f"{total}",
            f"count {FEWEST_COUNTS - total} more",
        )
    return [part for part in parts if part in usable_parts]


def _interval(values: Array, profile: Array, fitted: float) -> Interval:
    """A value with the outermost ones at which a profile crosses its level."""
    level = profile.max() - 0.5 * INTERVAL_FALL
    likely = np.flatnonzero(profile >= level)
    first, last = likely[[0, -1]]
    low_ends = [max(first - 1, 0), first]
    high_ends = [min(last + 1, values.size - 1), last]
    low = float(np.interp(level, profile[low_ends], values[low_ends]))
    high = float(np.interp(level, profile[high_ends], values[high_ends]))
    if fitted == AS_DEFAULT:
        return fitted, low, high
    return fitted, min(low, fitted), max(high, fitted)


def _sides_interval(
    sides: Sequence[int], profile: Array, fitted: int
) -> tuple[int, int, int]:
    """Sides a turn with the least and the most that a profile does not exclude."""
    is_likely = profile >= profile.max() - 0.5 * INTERVAL_FALL
    likely = np.array(sides)[is_likely].tolist()
    return fitted, min(fitted, *likely), max(fitted, *likely)


def _p_value(
    parts: Sequence[ExplainedPart], scene_number: int, grid: SceneGrid
) -> float:
    """Chance of counts this far from a scene with two or three fitted numbers."""
    statistic = 0.0
    degrees_of_freedom = -2 - (len(grid.sides) > 1)
    scene = grid.scenes[scene_number]
    for part in parts:
        resting = part.with_sides(scene.round_sides).resting
        probability = split(resting, scene)
        expected = expected_error("split", resting, probability, scene)
        test = goodness_of_fit(
            part.group_counts,
            part.shares[scene_number],
            np.bincount(resting.group, expected.pose_errors),
        )
        if not test.has_too_few_counts:
            statistic += test.statistic
            degrees_of_freedom += test.degrees_of_freedom
    if degrees_of_freedom <= 0:
        return math.nan
    return float(chdtrc(degrees_of_freedom, statistic))
