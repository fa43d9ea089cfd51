"""From the drops of variants to the verdicts on their differences.

All differences of a comparison are tested together, so that variants that do not differ are called
different in at most 5 % of comparisons: Holm's method over the poses, and a share of the 5 % for
each look at the drops. What the plate adds is no matter of repeated looks: of a difference that
stands, each pose by itself must exceed it.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np

from ..methods import SIMULATION
from ..records import Part, PoseStatistics
from ..records.statistics import pose_statistics
from ..resting.trust import pose_warnings
from ..simulation.simulate import height_warnings, touching_warnings
from ..statistics.errors import jeffreys_interval
from ..statistics.feeding import Bounded, Feeding, drop_afresh
from ..statistics.paired_counts import adjust_together
from ..statistics.pose_groups import warn_of_alike
from ..statistics.pose_shares import pose_shares
from ..statistics.prefix import Prefix
from .comparison import (
    Comparison,
    FeederComparison,
    PoseComparison,
    ShareDifference,
    VariantComparison,
)
from .correspondence import Correspondence, MatchedPoses
from .model_error import EXPORTED, plate_part
from .paired_drops import UNSETTLED, PairedDrops
from .unit_ratios import warn_of_units


def compare_pairs(parts: Sequence[Part], pairs: PairedDrops,
                  matches: Sequence[Correspondence], wanted: tuple[int, ...], look: float,
                  plate_error: float) -> Comparison:
    """Compare the first variant with the others by the drops so far.

    `matches`: of the first variant and each of the others; `wanted`: poses of the first variant
    that a feeder accepts; none for no feeder; `look`: share of the 5 % that this look at the drops
    has, above 0 to 1; `plate_error`: of a single share, a fraction.
    """
    found = tuple(_statistics(part, pairs, place) for place, part in enumerate(parts))
    single = [_compare(pairs, found, place, match, wanted, plate_error)
              for place, match in enumerate(matches, start=1)]
    accepted = [wanted, *(match.partners(wanted) for match in matches)]
    found = tuple(replace(one, warnings=(*one.warnings, *warn_of_alike(one, some)))
                  for one, some in zip(found, accepted, strict=True))
    return Comparison(tuple(parts), found, _tested_together(single, look), pairs.scene,
                      pairs.seed, wanted, plate_error)


def _statistics(part: Part, pairs: PairedDrops, variant: int) -> PoseStatistics:
    """Statistics of one variant, from the starts that all variants settled from."""
    resting, scene = pairs.resting[variant], pairs.scene
    counted = Prefix(len(resting.poses), max(pairs.drops, 1), 0.0)
    counted.add(np.where(pairs.settled, pairs.outcome[variant], UNSETTLED))
    unsettled = pairs.drops - counted.settled
    told = height_warnings(scene, resting.body.radius)
    if pairs.touched:
        told += touching_warnings(scene, pairs.touched[variant], pairs.drops)
    told += [] if not unsettled else [
        f"UNSETTLED: {unsettled} of {pairs.drops} drops were given up before the pose of every "
        f"variant was certain; they are left out of the probabilities."]
    return pose_statistics(
        part, resting.body.radius, resting.poses, counted.shares(), SIMULATION, scene,
        drops=pairs.drops, unsettled=unsettled, seed=pairs.seed,
        warnings=(*pose_warnings(resting), *told))


def _compare(pairs: PairedDrops, found: Sequence[PoseStatistics], second: int,
             match: Correspondence, wanted: tuple[int, ...], plate_error: float
             ) -> VariantComparison:
    is_round = any(pairs.resting[place].body.runs for place in (0, second))

    def share_of(poses: MatchedPoses) -> ShareDifference:
        difference = pairs.difference(0, poses.first, second, poses.second)
        value = 0.0 if math.isnan(difference.value) else difference.value
        return ShareDifference(
            _share(pairs, 0, poses.first), _share(pairs, second, poses.second), difference,
            EXPORTED if is_round else 0.0, plate_part(value, plate_error))

    poses = [PoseComparison(one, share_of(one)) for one in match.matches]
    poses.sort(key=lambda one: (not one.poses.is_pair, -max(one.share.first.value,
                                                            one.share.second.value)))
    feeder = None
    if wanted and pairs.settled.any():
        kept = MatchedPoses(tuple(sorted(wanted)), match.partners(wanted))
        lost = tuple(one for one in kept.first if match.partner[one] < 0)
        feeder = FeederComparison(kept, lost, share_of(kept), (
            drop_afresh(pose_shares(found[0]), kept.first),
            _feeding(found[second], kept.second)))
    return VariantComparison(second, match, tuple(poses), feeder, warn_of_units(
        found[0].radius, found[second].radius, second))


def _feeding(found: PoseStatistics, wanted: tuple[int, ...]) -> Feeding:
    """What a feeder gets; nothing where none of the wanted poses is left."""
    if wanted:
        return drop_afresh(pose_shares(found), wanted)
    nothing, never = Bounded(0.0, 0.0, 0.0), Bounded(math.inf, math.inf, math.inf)
    return Feeding(nothing, never, nothing, nothing)


def _share(pairs: PairedDrops, variant: int, poses: tuple[int, ...]) -> Bounded:
    """Share of some poses of a variant with its 90 % interval."""
    inside = pairs.is_in(variant, poses)
    if not poses or not inside.size:
        return Bounded(0.0, 0.0, 0.0 if not poses else 1.0)
    low, high = jeffreys_interval(int(inside.sum()), inside.size)
    return Bounded(float(inside.mean()), float(low), float(high))


def _tested_together(single: Sequence[VariantComparison], look: float
                     ) -> tuple[VariantComparison, ...]:
    """Tell each difference its chances, adjusted for all of them and for the looks."""
    tests = {key: share for one in single for key, share in _tests(one)}
    alone = adjust_together([share.difference.p_value for share in tests.values()])
    of_files = adjust_together([_chance_beyond(share, share.file_error)
                                for share in tests.values()])
    chances = {
        key: (min(1.0, chance / look),
              min(1.0, max(of_file / look, _chance_beyond(share, share.model_error))))
        for (key, share), chance, of_file in zip(tests.items(), alone.tolist(), of_files.tolist(),
                                                 strict=True)}
    told = []
    for one in single:
        judged = [share._replace(chance=chances[key][0], chance_on_plate=chances[key][1])
                  for key, share in _tests(one)]
        poses = tuple(pose._replace(share=share)
                      for pose, share in zip(one.poses, judged, strict=False))
        feeder = None if one.feeder is None else one.feeder._replace(share=judged[-1])
        told.append(replace(one, poses=poses, feeder=feeder))
    return tuple(told)


def _tests(one: VariantComparison) -> list[tuple[Hashable, ShareDifference]]:
    """What is tested, each with a key that is equal where the same drops decide.

    Where some poses gain, all others together lose as much: that is one test, not two.
    """
    every = frozenset((variant, index) for pose in one.poses
                      for variant, found in enumerate(pose.poses) for index in found)
    listed = [(pose.poses, pose.share) for pose in one.poses]
    if one.feeder is not None:
        listed.append((one.feeder.poses, one.feeder.share))
    found: list[tuple[Hashable, ShareDifference]] = []
    for poses, share in listed:
        inside = frozenset((variant, index) for variant, those in enumerate(poses)
                           for index in those)
        found.append(((one.second, frozenset((inside, every - inside))), share))
    return found


def _chance_beyond(share: ShareDifference, error: float) -> float:
    """Chance of a difference this large from the drops and a normal error."""
    known = share.difference
    spread = math.hypot(known.standard_error, error)
    if known.trials == 0 or spread == 0.0:
        return known.p_value
    return max(known.p_value, math.erfc(abs(known.value) / (spread * math.sqrt(2.0))))
