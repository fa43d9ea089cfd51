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

"""Variants of a part side by side: which poses correspond, and whether they differ.

All differences of a comparison are tested together, so that variants that do not differ
are called different in at most 5 % of comparisons: Holm's method over the poses, and a
share of the 5 % for each look at the drops. Drops end when a difference shows, and so
flatter it: once the verdicts stand, as many fresh drops tell shares and sizes. On a
real plate variants that are alike are off alike, so most of the plate's error is gone
from their difference.
"""

import math
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from itertools import chain, islice
from typing import NamedTuple

import numpy as np

from ...base import errors
from ...core.records import DropScene, Part, PoseStatistics
from ...core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_PLATE_ERROR,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ...core.resting.poses import RestingPoses, poses_in
from ...core.simulation.request import SEEDS, drop_request
from ...core.simulation.simulate import counted_statistics
from ...core.statistics import feeding, pose_groups
from . import comparison, correspondence, describe, paired_drops

FIRST_LOOK = 1250
"""Drops of each variant before the first look; each look has twice as many as the one
before."""

MOST_DROPS = 20_000
"""Drops of each variant, if nothing ends them before: differences are known to a point
then."""

ONE_POINT = 0.01

MOST_VARIANTS = 26

LARGEST_RATIO = 9.0
"""Of two radii: beyond it lie those of a part in millimetres and in centimetres."""

SMALL_DIFFERENCE_ERROR = 0.1
"""Error of a difference that is nearly 0, over the plate's error of a single share."""

LARGE_DIFFERENCE_ERROR = 0.35
"""Error of a larger difference over the difference.

Both cover what rolled dice and simulated plates have shown, with single shares off by
up to 9 points (tests/truth/design).
"""

EXPORT_ERROR = 0.005
"""Standard deviation by which shares of two exports of one round part differ.

The drops see the facets of the file, not the part (docs/decisions.md).
"""

NO_SHARE = feeding.Bounded(0.0, 0.0, 0.0)


def compare(
    parts: Sequence[Part],
    wanted: Sequence[int] = (),
    drops: int = MOST_DROPS,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int | None = None,
    drop_height: float | None = None,
    workers: int | None = None,
    on_progress: Callable[[int, int], object] = lambda done, most: None,
    should_stop: Callable[[], bool] = lambda: False,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
    plate_error: float = DEFAULT_PLATE_ERROR,
) -> comparison.Comparison:
    """Compare the first variant of a part with others, dropped from the same starts.

    The drops that give the verdicts end where each of the others is expected to differ
    on a plate, in the share that a feeder accepts if one is asked for; where all
    differences are known to a point (half of their 90 % intervals); or at the most
    drops. As many afresh then give shares and differences.

    Parameters
    ----------
    parts : sequence of Part
        2 to 26.
    wanted : sequence of int
        Poses of the first variant that a feeder accepts; none asks for no feeder.
    drops : int
        The most of each variant for the verdicts, 1 to 1e9; as many are made afresh.
    seed : int, optional
        0 to 2^64 - 1; the fresh drop k of all variants depends on seed and k alone.
        Default: a fresh one.
    drop_height : float, optional
        Height of the centre of mass at release, metres, the same for all variants.
        Default: 20 radii of the first one.
    on_progress : callable
        Takes the number of drops done, and the most of them, of all variants.
    should_stop : callable
        After True the comparison ends with the drops done by then.
    plate_error : float
        Of a single share on the plate, a fraction from 0 to 1.
    restitution, workers, cluster_tolerance, round_sides
        As for `simulate`.

    Returns
    -------
    Comparison
        The same for the same request, whatever the workers.

    Raises
    ------
    RequestError
        If there is one part only, or one is more than 9 times as large as the first or
        that as it, or there is no such pose, or a number is out of its range.
    MeshError
        If the hull of a part does not enclose its centre of mass.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    request = drop_request(drops, seed, 0.0, workers)
    resting = _check_variants(parts, scene, wanted, plate_error)
    accepted_poses = tuple(sorted(set(map(int, wanted))))
    matches = [
        correspondence.find_correspondence(resting[0], variant)
        for variant in resting[1:]
    ]
    followed_poses = [match.follow(accepted_poses) for match in matches]
    tests = _ShareTests(
        [
            [*match.matches, *([poses] if accepted_poses else [])]
            for match, poses in zip(matches, followed_poses, strict=True)
        ],
        bool(accepted_poses),
        plate_error,
    )
    judged_drops, fresh_drops = (
        paired_drops.PairedDrops(
            parts,
            scene,
            drop_seed % SEEDS,
            request.workers,
            should_stop,
            [None, *(match.turn for match in matches)],
        )
        for drop_seed in (request.seed + SEEDS // 2, request.seed)
    )
    pairs, differences = tests.judge_and_measure(
        judged_drops, fresh_drops, request.drops, on_progress
    )
    accepted_by_variant = [accepted_poses, *(poses.second for poses in followed_poses)]
    return comparison.Comparison(
        tuple(parts),
        tuple(
            _statistics(part, pairs, number, accepted)
            for number, (part, accepted) in enumerate(
                zip(parts, accepted_by_variant, strict=True)
            )
        ),
        tuple(
            _compare_variant(number, match, accepted_poses, shares)
            for number, (match, shares) in enumerate(
                zip(matches, differences, strict=True), start=1
            )
        ),
        pairs.scene,
        request.seed,
        accepted_poses,
        plate_error,
        time.perf_counter() - begin,
    )


def _compare_variant(
    number: int,
    match: correspondence.Correspondence,
    accepted_poses: tuple[int, ...],
    shares: list[comparison.ShareDifference],
) -> comparison.VariantComparison:
    """A variant beside the first, pairs of poses and frequent ones first."""
    poses = [
        comparison.PoseComparison(matched_poses, share)
        for matched_poses, share in zip(match.matches, shares, strict=False)
    ]
    poses.sort(
        key=lambda pose: (
            not pose.poses.is_pair,
            -max(pose.share.first.value, pose.share.second.value),
        )
    )
    feeder = None
    if accepted_poses:
        feeder = comparison.FeederComparison(
            match.follow(accepted_poses),
            shares[-1],
            tuple(pose for pose in accepted_poses if match.partner[pose] < 0),
        )
    return comparison.VariantComparison(number, match, tuple(poses), feeder)


Differences = list[list[comparison.ShareDifference]]
"""Of each variant but the first, in the order of its tests."""


class _ShareTests(NamedTuple):
    """Shares that are tested together, and how their differences are judged."""

    # of each variant but the first; the poses that a feeder accepts are the last
    poses: list[list[correspondence.MatchedPoses]]
    has_feeder: bool
    plate_error: float  # of a single share

    def judge_and_measure(
        self,
        judged_drops: paired_drops.PairedDrops,
        fresh_drops: paired_drops.PairedDrops,
        most_drops: int,
        on_progress: Callable[[int, int], object],
    ) -> tuple[paired_drops.PairedDrops, Differences]:
        """Drop until the verdicts stand, then as often afresh for shares and sizes.

        The drops that gave these, the judged ones where a stop left no others; and the
        differences, with the chances of the verdicts.
        """
        total = 2 * most_drops * len(judged_drops.parts)
        verdicts = self.judge(
            judged_drops, most_drops, lambda drops_done: on_progress(drops_done, total)
        )
        fresh_drops.drop_until(
            judged_drops.drops,
            lambda drops_done: on_progress(
                judged_drops.outcome.size + drops_done, total
            ),
        )
        pairs = fresh_drops if fresh_drops.drops else judged_drops
        return pairs, [
            [
                difference._replace(
                    chance=verdict.chance, chance_on_plate=verdict.chance_on_plate
                )
                for difference, verdict in zip(fresh, judged, strict=True)
            ]
            for fresh, judged in zip(self.differences(pairs), verdicts, strict=True)
        ]

    def judge(
        self,
        pairs: paired_drops.PairedDrops,
        most_drops: int,
        on_progress: Callable[[int], object],
    ) -> Differences:
        """Drop until the verdicts stand; the differences with their chances.

        A look has a share of the 5 % in proportion to its drops: all looks together are
        wrong in no more than 5 %, since the sum of the chances bounds that of any.
        """
        looks = [most_drops]
        while looks[0] >= 2 * FIRST_LOOK:
            looks.insert(0, looks[0] // 2)
        for size in looks:
            pairs.drop_until(size, on_progress)
            differences = self._adjust(self.differences(pairs), size / sum(looks))
            was_stopped = pairs.drops < size
            if was_stopped or self._all_differ(differences) or _are_known(differences):
                break
        return differences

    def differences(self, pairs: paired_drops.PairedDrops) -> Differences:
        """What is tested, by some drops."""
        return [
            [self._difference(pairs, number, poses) for poses in tested_poses]
            for number, tested_poses in enumerate(self.poses, start=1)
        ]

    def _difference(
        self,
        pairs: paired_drops.PairedDrops,
        number: int,
        poses: correspondence.MatchedPoses,
    ) -> comparison.ShareDifference:
        is_in_first = pairs.is_in(0, poses.first)
        is_in_second = pairs.is_in(number, poses.second)
        difference = paired_drops.paired_difference(is_in_first, is_in_second)
        size = 0.0 if math.isnan(difference.value) else difference.value
        is_round = any(pairs.resting[variant].body.runs for variant in (0, number))
        # A variant that has no such pose never comes to rest in it.
        return comparison.ShareDifference(
            paired_drops.count_share(is_in_first) if poses.first else NO_SHARE,
            paired_drops.count_share(is_in_second) if poses.second else NO_SHARE,
            difference,
            EXPORT_ERROR if is_round else 0.0,
            min(
                math.sqrt(2.0) * self.plate_error,
                math.hypot(
                    SMALL_DIFFERENCE_ERROR * self.plate_error,
                    LARGE_DIFFERENCE_ERROR * size,
                ),
            ),
        )

    def _all_differ(self, differences: Differences) -> bool:
        """Whether each variant is expected to differ on a plate."""
        return all(
            any(
                share.on_plate == comparison.DIFFERENCE_SHOWN
                for share in (shares[-1:] if self.has_feeder else shares)
            )
            for shares in differences
        )

    def _adjust(self, differences: Differences, look_share: float) -> Differences:
        """Differences with their chances in the model and on a plate, of all tests.

        `look_share`: of the 5 %, for this look. What a plate adds is no matter of
        repeated looks.
        """
        keys = [
            (number, key)
            for number, poses in enumerate(self.poses)
            for key in _test_keys(poses)
        ]
        shares = list(chain.from_iterable(differences))
        distinct = dict(zip(keys, shares, strict=True))
        drop_chances = paired_drops.adjust_together(
            [share.difference.p_value for share in distinct.values()]
        ).tolist()
        file_chances = paired_drops.adjust_together(
            [
                _chance_beyond(share.difference, share.file_error)
                for share in distinct.values()
            ]
        ).tolist()

        chances = {}
        for (key, share), drop_chance, file_chance in zip(
            distinct.items(), drop_chances, file_chances, strict=True
        ):
            model_error = math.hypot(share.file_error, share.plate_error)
            plate_chance = _chance_beyond(share.difference, model_error)
            chances[key] = {
                "chance": min(1.0, drop_chance / look_share),
                "chance_on_plate": min(
                    1.0, max(file_chance / look_share, plate_chance)
                ),
            }
        adjusted = (
            share._replace(**chances[key])
            for key, share in zip(keys, shares, strict=True)
        )
        return [list(islice(adjusted, len(tests))) for tests in self.poses]


def _test_keys(tests: Sequence[correspondence.MatchedPoses]) -> list[Hashable]:
    """What each test of a variant is about.

    Where some poses gain, all others together lose as much: that is one test, not two.
    """
    tested_sets = [
        frozenset(
            (side, index) for side, indices in enumerate(poses) for index in indices
        )
        for poses in tests
    ]
    all_poses = frozenset().union(*tested_sets)
    return [frozenset((poses, all_poses - poses)) for poses in tested_sets]


def _are_known(differences: Differences) -> bool:
    """Whether all differences are known to a point, half of their intervals."""
    return all(
        share.difference.high - share.difference.low <= 2.0 * ONE_POINT
        for share in chain.from_iterable(differences)
    )


def _check_variants(
    parts: Sequence[Part], scene: DropScene, wanted: Sequence[int], plate_error: float
) -> list[RestingPoses]:
    """The variants at rest; raises RequestError where they cannot be compared so."""
    if not 0.0 <= plate_error <= 1.0:
        raise errors.RequestError(
            "a plate error from 0 to 1, as a fraction",
            f"{plate_error}",
            "0.05 is a plate that nobody has counted on",
        )
    if not 2 <= len(parts) <= MOST_VARIANTS:
        raise errors.RequestError(
            f"2 to {MOST_VARIANTS} variants to compare",
            f"{len(parts)}",
            "give the files of the variants, the one to compare with first",
        )
    resting = [poses_in(part, scene) for part in parts]
    for part in parts:
        part.require_known_error("a comparison")
    first_radius = resting[0].body.radius
    for number, variant in enumerate(resting):
        radius = variant.body.radius
        if max(radius, first_radius) > LARGEST_RATIO * min(radius, first_radius):
            raise errors.RequestError(
                f"variants of one scale, radii at most {LARGEST_RATIO:g} times apart",
                f"A with a radius of {1e3 * first_radius:.4g} mm and "
                f"{describe.letter(number)} with {1e3 * radius:.4g} mm",
                "export them in one unit",
            )
    if wanted:
        feeding.check_wanted_poses(wanted, len(resting[0].poses))
    return resting


def _chance_beyond(difference: paired_drops.PairedDifference, error: float) -> float:
    """Chance of a difference this large from the drops and a normal error."""
    spread = math.hypot(difference.standard_error, error)
    if difference.trials == 0 or spread == 0.0:
        return difference.p_value
    deviation = abs(difference.value) / (spread * math.sqrt(2.0))
    return max(difference.p_value, math.erfc(deviation))


def _statistics(
    part: Part,
    pairs: paired_drops.PairedDrops,
    variant: int,
    accepted_poses: Sequence[int],
) -> PoseStatistics:
    """Statistics of one variant, from the starts that all variants settled from."""
    resting = pairs.resting[variant]
    counts = np.bincount(
        pairs.outcome[variant, pairs.is_settled], minlength=len(resting.poses)
    )
    statistics = counted_statistics(
        part,
        resting,
        pairs.scene,
        counts,
        pairs.drops,
        int(pairs.touched[variant].sum()),
        pairs.seed,
        math.nan,
        uncertain="the pose of every variant",
    )
    lookalikes = pose_groups.warn_of_lookalikes(statistics, accepted_poses)
    return replace(statistics, warnings=(*statistics.warnings, *lookalikes))
