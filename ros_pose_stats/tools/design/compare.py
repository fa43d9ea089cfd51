"""Variants of a part side by side: which poses correspond, and whether they differ.

All differences of a comparison are tested together, so that variants that do not differ are called
different in at most 5 % of comparisons: Holm's method over the poses, and a share of the 5 % for
each look at the drops. Drops end when a difference shows, and so flatter it: once the verdicts
stand, as many fresh drops tell shares and sizes. On a real plate variants that are alike are off
alike, so most of the plate's error is gone from their difference.
"""

import math
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace

import numpy as np

from ...base import errors
from ...core.records import DropScene, Part, PoseStatistics
from ...core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_PLATE_ERROR,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
)
from ...core.resting import poses as stable
from ...core.simulation import request, simulate
from ...core.statistics import feeding, pose_groups
from . import (
    comparison,
    correspondence,
    describe,
    paired_drops,
    shares as wanted_shares,
)

FIRST_LOOK = 1250
"""Drops of each variant before the first look; each look has twice as many as the one before."""

MOST_DROPS = 20_000
"""Drops of each variant, if nothing ends them before: differences are known to a point then."""

ONE_POINT = 0.01

MOST_VARIANTS = 26

LARGEST_RATIO = 9.0
"""Of two radii: beyond it lie those of a part in millimetres and in centimetres."""

LEFT = 0.1  # error of a difference that is nearly 0, over the plate's error of a single share

KEPT = 0.35
"""Error of a larger difference over the difference. Both cover what rolled dice and simulated
plates have shown, with single shares off by up to 9 points (tests/truth/design)."""

EXPORTED = 0.005
"""Standard deviation by which shares of two exports of one round part differ: the drops see the
facets of the file, not the part (docs/measured/exports.md)."""


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
    """Compare the first variant of a part with each of the others, dropped from the same starts.

    The drops that give the verdicts end where each of the others is expected to differ on a
    plate, in the share that a feeder accepts if one is asked for; where all differences are known
    to a point (half of their 90 % intervals); or at the most drops. As many afresh then give
    shares and differences.

    Parameters
    ----------
    parts : sequence of Part
        2 to 26.
    wanted : sequence of int
        Poses of the first variant that a feeder accepts; none asks for no feeder.
    drops : int
        The most of each variant for the verdicts, 1 to 1e9; as many are made afresh.
    seed : int, optional
        0 to 2^64 - 1; the fresh drop k of all variants depends on seed and k alone. Default: a
        fresh one.
    drop_height : float, optional
        Height of the centre of mass at release, metres, the same for all variants. Default: 20
        radii of the first one.
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
        If there is one part only, or one is more than 9 times as large as the first or that as
        it, or there is no such pose, or a number is out of its range.
    MeshError
        If the hull of a part does not enclose its centre of mass.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    asked = request.drop_request(drops, seed, 0.0, workers)
    resting = _prepared(parts, scene, wanted, plate_error)
    accepted = tuple(sorted(set(map(int, wanted))))
    matches = [
        correspondence.find_correspondence(resting[0], other) for other in resting[1:]
    ]
    tests = [
        [*match.matches, *([match.follow(accepted)] if accepted else [])]
        for match in matches
    ]

    turns = [None, *(match.turn for match in matches)]
    judged, afresh = (
        paired_drops.PairedDrops(
            parts, scene, each % request.SEEDS, asked.workers, should_stop, turns
        )
        for each in (asked.seed + request.SEEDS // 2, asked.seed)
    )
    most = 2 * asked.drops * len(parts)
    verdicts = _judge(
        judged,
        tests,
        bool(accepted),
        plate_error,
        asked.drops,
        lambda done: on_progress(done, most),
    )
    afresh.drop_until(
        judged.drops, lambda done: on_progress(judged.outcome.size + done, most)
    )

    pairs = afresh if afresh.drops else judged
    variants = tuple(
        _compare_variant(
            second,
            match,
            accepted,
            [
                share._replace(chance=one.chance, chance_on_plate=one.chance_on_plate)
                for share, one in zip(shares, judgements, strict=True)
            ],
        )
        for second, match, shares, judgements in zip(
            range(1, len(parts)),
            matches,
            _differences(pairs, tests, plate_error),
            verdicts,
            strict=True,
        )
    )
    own = [accepted, *(match.follow(accepted).second for match in matches)]
    found = tuple(
        _statistics(part, pairs, place, own[place]) for place, part in enumerate(parts)
    )
    return comparison.Comparison(
        tuple(parts),
        found,
        variants,
        pairs.scene,
        asked.seed,
        accepted,
        plate_error,
        time.perf_counter() - begin,
    )


def _compare_variant(
    second: int,
    match: correspondence.Correspondence,
    accepted: tuple[int, ...],
    shares: list[comparison.ShareDifference],
) -> comparison.VariantComparison:
    """What was found of a variant beside the first, pairs of poses and frequent ones first."""
    poses = [
        comparison.PoseComparison(some, share)
        for some, share in zip(match.matches, shares, strict=False)
    ]
    poses.sort(
        key=lambda one: (
            not one.poses.is_pair,
            -max(one.share.first.value, one.share.second.value),
        )
    )
    feeder = (
        comparison.FeederComparison(
            match.follow(accepted),
            shares[-1],
            tuple(one for one in accepted if match.partner[one] < 0),
        )
        if accepted
        else None
    )
    return comparison.VariantComparison(second, match, tuple(poses), feeder)


Tests = Sequence[Sequence[correspondence.MatchedPoses]]
"""Shares that are tested of each variant but the first; that of accepted parts is the last."""

Tested = list[list[comparison.ShareDifference]]


def _judge(
    pairs: paired_drops.PairedDrops,
    tests: Tests,
    has_feeder: bool,
    plate_error: float,
    most: int,
    on_progress: Callable[[int], object],
) -> Tested:
    """Drop until the verdicts stand; the differences with their chances.

    A look has a share of the 5 % in proportion to its drops: all looks together are wrong in no
    more than 5 %, since the sum of the chances bounds that of any of them.
    """
    looks = [most]
    while looks[0] >= 2 * FIRST_LOOK:
        looks.insert(0, looks[0] // 2)
    for size in looks:
        pairs.drop_until(size, on_progress)
        found = _adjusted(
            tests, _differences(pairs, tests, plate_error), size / sum(looks)
        )
        if (
            pairs.drops < size
            or all(
                any(
                    one.on_plate == comparison.SHOWN
                    for one in (some[-1:] if has_feeder else some)
                )
                for some in found
            )
            or all(
                one.difference.high - one.difference.low <= 2.0 * ONE_POINT
                for some in found
                for one in some
            )
        ):
            break
    return found


def _prepared(
    parts: Sequence[Part], scene: DropScene, wanted: Sequence[int], plate_error: float
) -> list[stable.RestingPoses]:
    """The variants at rest; raises RequestError where they cannot be compared as is asked."""
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
    resting = [stable.poses_in(part, scene) for part in parts]
    first = resting[0].body.radius
    for place, radius in enumerate(one.body.radius for one in resting):
        if max(radius, first) > LARGEST_RATIO * min(radius, first):
            raise errors.RequestError(
                f"variants of one scale, radii at most {LARGEST_RATIO:g} times apart",
                f"A with a radius of {1e3 * first:.4g} mm and {describe.letter(place)} with "
                f"{1e3 * radius:.4g} mm",
                "export them in one unit",
            )
    if wanted:
        feeding.check_wanted(wanted, len(resting[0].poses))
    return resting


def _differences(
    pairs: paired_drops.PairedDrops, tests: Tests, plate_error: float
) -> Tested:
    """What is tested, by some drops."""
    found: Tested = []
    for variant, listed in enumerate(tests, start=1):
        found.append([])
        is_round = any(pairs.resting[place].body.runs for place in (0, variant))
        for poses in listed:
            both = (pairs.is_in(0, poses.first), pairs.is_in(variant, poses.second))
            # A variant that has no such pose never comes to rest in it.
            first, second = (
                wanted_shares.counted_share(inside)
                if some
                else feeding.Bounded(0.0, 0.0, 0.0)
                for inside, some in zip(both, poses, strict=True)
            )
            difference = paired_drops.paired_difference(*both)
            size = 0.0 if math.isnan(difference.value) else difference.value
            found[-1].append(
                comparison.ShareDifference(
                    first,
                    second,
                    difference,
                    EXPORTED if is_round else 0.0,
                    min(
                        math.sqrt(2.0) * plate_error,
                        math.hypot(LEFT * plate_error, KEPT * size),
                    ),
                )
            )
    return found


def _adjusted(tests: Tests, found: Tested, look: float) -> Tested:
    """Differences with their chances in the model and on a plate, for all and for the looks.

    `look`: share of the 5 % of this look. What a plate adds is no matter of repeated looks.
    """
    # Where some poses gain, all others together lose as much: that is one test, not two.
    keys: list[list[Hashable]] = []
    for variant, listed in enumerate(tests):
        inside = [
            frozenset(
                (side, index) for side, those in enumerate(poses) for index in those
            )
            for poses in listed
        ]
        every = frozenset().union(*inside)
        keys.append([(variant, frozenset((some, every - some))) for some in inside])
    each = {
        key: share
        for some, shares in zip(keys, found, strict=True)
        for key, share in zip(some, shares, strict=True)
    }
    alone, of_files = (
        paired_drops.adjust_together(some).tolist()
        for some in (
            [share.difference.p_value for share in each.values()],
            [
                _chance_beyond(share.difference, share.file_error)
                for share in each.values()
            ],
        )
    )
    chances = {
        key: {
            "chance": min(1.0, chance / look),
            "chance_on_plate": min(
                1.0,
                max(
                    of_file / look,
                    _chance_beyond(
                        share.difference,
                        math.hypot(share.file_error, share.plate_error),
                    ),
                ),
            ),
        }
        for (key, share), chance, of_file in zip(
            each.items(), alone, of_files, strict=True
        )
    }
    return [
        [
            share._replace(**chances[key])
            for key, share in zip(some, shares, strict=True)
        ]
        for some, shares in zip(keys, found, strict=True)
    ]


def _chance_beyond(known: paired_drops.PairedDifference, error: float) -> float:
    """Chance of a difference this large from the drops and a normal error."""
    spread = math.hypot(known.standard_error, error)
    if known.trials == 0 or spread == 0.0:
        return known.p_value
    return max(known.p_value, math.erfc(abs(known.value) / (spread * math.sqrt(2.0))))


def _statistics(
    part: Part, pairs: paired_drops.PairedDrops, variant: int, accepted: Sequence[int]
) -> PoseStatistics:
    """Statistics of one variant, from the starts that all variants settled from."""
    resting = pairs.resting[variant]
    counts = np.bincount(
        pairs.outcome[variant, pairs.settled], minlength=len(resting.poses)
    )
    found = simulate.counted_statistics(
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
    return replace(
        found, warnings=(*found.warnings, *pose_groups.warn_of_alike(found, accepted))
    )
