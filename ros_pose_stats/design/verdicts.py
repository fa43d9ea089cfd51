"""From the drops of variants to the verdicts on their differences.

All differences of a comparison are tested together, so that variants that do not differ are called
different in at most 5 % of comparisons: Holm's method over the poses, and a share of the 5 % for
each look at the drops. What the plate adds is no matter of repeated looks: of a difference that
stands, each pose by itself must exceed it.

A share that drops tell is off by `plate_error` on a real plate, whatever the number of drops. Two
variants that are alike are off alike, so most of that is gone from their difference. A part of it
stays however small the difference, more with the difference, up to that of two parts that have
nothing to do with each other.
"""

import math
from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np

from ..methods import SIMULATION
from ..records import Part, PoseStatistics, statistics
from ..resting.trust import pose_remarks
from ..simulation.simulate import touching_warnings
from ..statistics import errors, feeding, paired_counts, pose_groups, pose_shares, prefix
from . import comparison, correspondence, paired_drops

LEFT = 0.1
"""Error of a difference that is nearly 0, over the plate's error of a single share."""

KEPT = 0.35
"""Error of a larger difference over the difference. Both cover what rolled dice and simulated
plates have shown, with single shares off by up to 9 points (tests/truth/design)."""

EXPORTED = 0.005
"""Standard deviation by which shares of two exports of one round part differ: the drops see the
facets of the file, not the part (docs/measured/exports.md)."""


def plate_part(difference: float, plate_error: float) -> float:
    """Standard deviation of what a plate adds to a difference of two shares.

    `difference`: of the shares in the model, -1 to 1; `plate_error`: of a single share on the
    plate, a fraction.
    """
    return min(math.sqrt(2.0) * plate_error, math.hypot(LEFT * plate_error, KEPT * difference))


def compare_pairs(parts: Sequence[Part], pairs: paired_drops.PairedDrops,
                  matches: Sequence[correspondence.Correspondence], wanted: tuple[int, ...],
                  look: float,
                  plate_error: float) -> comparison.Comparison:
    """Compare the first variant with the others by the drops so far.

    `matches`: of the first variant and each of the others; `wanted`: poses of the first variant
    that a feeder accepts; none for no feeder; `look`: share of the 5 % that this look at the drops
    has, above 0 to 1; `plate_error`: of a single share, a fraction.
    """
    found = tuple(_statistics(part, pairs, place) for place, part in enumerate(parts))
    single = [_compare(pairs, found, place, match, wanted, plate_error)
              for place, match in enumerate(matches, start=1)]
    accepted = [wanted, *(match.partners(wanted) for match in matches)]
    found = tuple(replace(one, warnings=(*one.warnings, *pose_groups.warn_of_alike(one, some)))
                  for one, some in zip(found, accepted, strict=True))
    return comparison.Comparison(tuple(parts), found, _tested_together(single, look), pairs.scene,
                                 pairs.seed, wanted, plate_error)


def _statistics(part: Part, pairs: paired_drops.PairedDrops, variant: int) -> PoseStatistics:
    """Statistics of one variant, from the starts that all variants settled from."""
    resting, scene = pairs.resting[variant], pairs.scene
    counted = prefix.Prefix(len(resting.poses), max(pairs.drops, 1), 0.0)
    counted.add(np.where(pairs.settled, pairs.outcome[variant], paired_drops.UNSETTLED))
    unsettled = pairs.drops - counted.settled
    remarks = pose_remarks(resting)
    told = (touching_warnings(scene, pairs.touched[variant], pairs.drops) if pairs.touched else [])
    told += [] if not unsettled else [
        f"UNSETTLED: {unsettled} of {pairs.drops} drops were given up before the pose of every "
        f"variant was certain; they are left out of the probabilities."]
    return statistics.pose_statistics(
        part, resting.body.radius, resting.poses, counted.shares(), SIMULATION, scene,
        drops=pairs.drops, unsettled=unsettled, seed=pairs.seed,
        warnings=(*remarks.warnings, *told), notes=remarks.notes)


def _compare(pairs: paired_drops.PairedDrops, found: Sequence[PoseStatistics], second: int,
             match: correspondence.Correspondence, wanted: tuple[int, ...], plate_error: float
             ) -> comparison.VariantComparison:
    is_round = any(pairs.resting[place].body.runs for place in (0, second))

    def share_of(poses: correspondence.MatchedPoses) -> comparison.ShareDifference:
        difference = pairs.difference(0, poses.first, second, poses.second)
        value = 0.0 if math.isnan(difference.value) else difference.value
        return comparison.ShareDifference(
            _share(pairs, 0, poses.first), _share(pairs, second, poses.second), difference,
            EXPORTED if is_round else 0.0, plate_part(value, plate_error))

    poses = [comparison.PoseComparison(one, share_of(one)) for one in match.matches]
    poses.sort(key=lambda one: (not one.poses.is_pair, -max(one.share.first.value,
                                                            one.share.second.value)))
    feeder = None
    if wanted and pairs.settled.any():
        kept = correspondence.MatchedPoses(tuple(sorted(wanted)), match.partners(wanted))
        lost = tuple(one for one in kept.first if match.partner[one] < 0)
        feeder = comparison.FeederComparison(kept, lost, share_of(kept), (
            feeding.drop_afresh(pose_shares.pose_shares(found[0]), kept.first),
            _feeding(found[second], kept.second)))
    return comparison.VariantComparison(second, match, tuple(poses), feeder)


def _feeding(found: PoseStatistics, wanted: tuple[int, ...]) -> feeding.Feeding:
    """What a feeder gets; nothing where none of the wanted poses is left."""
    if wanted:
        return feeding.drop_afresh(pose_shares.pose_shares(found), wanted)
    nothing, never = feeding.Bounded(0.0, 0.0, 0.0), feeding.Bounded(math.inf, math.inf, math.inf)
    return feeding.Feeding(nothing, never, nothing, nothing)


def _share(pairs: paired_drops.PairedDrops, variant: int,
           poses: tuple[int, ...]) -> feeding.Bounded:
    """Share of some poses of a variant with its 90 % interval."""
    inside = pairs.is_in(variant, poses)
    if not poses or not inside.size:
        return feeding.Bounded(0.0, 0.0, 0.0 if not poses else 1.0)
    low, high = errors.jeffreys_interval(int(inside.sum()), inside.size)
    return feeding.Bounded(float(inside.mean()), float(low), float(high))


def _tested_together(single: Sequence[comparison.VariantComparison], look: float
                     ) -> tuple[comparison.VariantComparison, ...]:
    """Tell each difference its chances, adjusted for all of them and for the looks."""
    tests = {key: share for one in single for key, share in _tests(one)}
    alone = paired_counts.adjust_together([share.difference.p_value for share in tests.values()])
    of_files = paired_counts.adjust_together([_chance_beyond(share, share.file_error)
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


def _tests(one: comparison.VariantComparison) -> list[tuple[Hashable, comparison.ShareDifference]]:
    """What is tested, each with a key that is equal where the same drops decide.

    Where some poses gain, all others together lose as much: that is one test, not two.
    """
    every = frozenset((variant, index) for pose in one.poses
                      for variant, found in enumerate(pose.poses) for index in found)
    listed = [(pose.poses, pose.share) for pose in one.poses]
    if one.feeder is not None:
        listed.append((one.feeder.poses, one.feeder.share))
    found: list[tuple[Hashable, comparison.ShareDifference]] = []
    for poses, share in listed:
        inside = frozenset((variant, index) for variant, those in enumerate(poses)
                           for index in those)
        found.append(((one.second, frozenset((inside, every - inside))), share))
    return found


def _chance_beyond(share: comparison.ShareDifference, error: float) -> float:
    """Chance of a difference this large from the drops and a normal error."""
    known = share.difference
    spread = math.hypot(known.standard_error, error)
    if known.trials == 0 or spread == 0.0:
        return known.p_value
    return max(known.p_value, math.erfc(abs(known.value) / (spread * math.sqrt(2.0))))
