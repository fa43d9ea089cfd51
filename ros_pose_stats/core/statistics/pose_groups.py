"""Poses that symmetry makes alike, told together: what a feeder or a camera sees as one pose.

Probabilities that were not counted are taken to be as uncertain as if counted in as many drops as
would leave their errors.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...base import errors, methods, text
from .. import tolerances
from ..records import Array, Index, PoseStatistics, StablePose
from ..records.poses import PoseGroup, single_poses
from .errors import jeffreys_interval

MOST_ROUNDS = 40  # each round halves the error of the logarithm


def pose_groups(found: PoseStatistics) -> tuple[PoseGroup, ...]:
    """Take poses that are alike together, the most probable first.

    The interval of several counted poses is that of the sum of their counts. Estimates and
    `hybrid` share one error evenly among the poses: their bounds add up to those of the sum.
    """
    groups: dict[int, list[StablePose]] = {}
    for pose in found.by_index.values():
        groups.setdefault(pose.group, []).append(pose)
    settled = sum(pose.count for pose in found.poses)
    joined = [
        _joined(
            poses, settled if found.method == methods.SIMULATION else None, len(groups)
        )
        for poses in groups.values()
    ]
    rank = tolerances.number_equal(
        [
            0.0 if math.isnan(group.probability) else -group.probability
            for group in joined
        ],
        tolerances.SAME_SHARE,
    )
    return tuple(
        joined[k]
        for k in sorted(
            range(len(joined)), key=lambda k: (rank[k], joined[k].first.index)
        )
    )


def listed_poses(found: PoseStatistics, each: bool) -> tuple[PoseGroup, ...]:
    """Each pose by itself, or those that are alike together."""
    return single_poses(found.poses) if each else pose_groups(found)


def _joined(poses: list[StablePose], settled: int | None, groups: int) -> PoseGroup:
    """Join poses, by rising index; `settled`: counted drops, None without; one group is sure."""
    count = sum(pose.count for pose in poses)
    low = sum(pose.probability_low for pose in poses)
    high = sum(pose.probability_high for pose in poses)
    high = 1.0 if high > 1.0 else high  # NaN stays
    if settled is not None and len(poses) > 1:
        low, high = (
            map(float, jeffreys_interval(count, settled)) if groups > 1 else (1.0, 1.0)
        )
    return PoseGroup(
        tuple(poses), sum(pose.probability for pose in poses), low, high, count
    )


def warn_of_alike(found: PoseStatistics, wanted: Sequence[int]) -> tuple[str, ...]:
    """Warn where only some of the poses that look the same are wanted."""
    kept = set(map(int, wanted))
    groups = [
        group.indices
        for group in sorted(pose_groups(found), key=lambda one: one.indices)
    ]
    split = [
        (
            [one for one in group if one in kept],
            [one for one in group if one not in kept],
        )
        for group in groups
        if 0 < len(kept.intersection(group)) < len(group)
    ]
    if not split:
        return ()
    missing = [index for _, outside in split for index in outside]
    alike = text.listed(
        [
            f"{text.name_poses(outside)} look{'s' if len(outside) == 1 else ''} "
            f"the same as {text.name_poses(inside)}"
            for inside, outside in split
        ]
    )
    are = "is" if len(missing) == 1 else "are"
    return (
        f"WANTED_ALIKE: {alike} (symmetry) and {are} not among the wanted ones"
        f"{_shares(found, kept, kept.union(missing))}.",
    )


def _shares(found: PoseStatistics, kept: set[int], every: set[int]) -> str:
    """What is accepted without and with the others; nothing where no share is known."""
    now, then = (
        min(1.0, sum(pose.probability for pose in found.poses if pose.index in some))
        for some in (kept, every)
    )
    if math.isnan(now):
        return ""
    return f": {100.0 * now:.1f} % are accepted, with them {100.0 * then:.1f} %"


class PoseShares(NamedTuple):
    """In which poses a part comes to rest that is dropped, and how surely that is known."""

    probability: Array  # (K,); of the poses by their index
    # whose counts would be as uncertain; infinite where nothing is uncertain, NaN where nothing is
    # known about it
    drops: float
    # (K,) int; poses of one number, from 0 on, are equally probable by symmetry and share one
    # error
    unit: Index

    @property
    def shares(self) -> Array:
        """Probability of each unit."""
        return np.bincount(self.unit, self.probability).astype(np.float64)

    def by_unit(self, values: Array) -> Array:
        """Mean of a value of the poses (K,) over those of each unit."""
        return np.asarray(np.bincount(self.unit, values) / np.bincount(self.unit))

    def scatter(self, values: Array) -> float:
        """Variance of a value of the poses (K,) over drops that end in the units, not within."""
        each = self.by_unit(values)
        mean = float(self.shares @ each)
        return max(0.0, float(self.shares @ (each - mean) ** 2))


def pose_shares(found: PoseStatistics) -> PoseShares:
    """Probabilities of a result as feeding needs them.

    Of counted poses each has an error of its own, else those that are alike share one evenly.
    """
    poses = found.by_index.values()
    probability = np.array([pose.probability for pose in poses])
    if not np.isfinite(probability).all():
        raise errors.RequestError(
            "probabilities of the poses", "none", "simulate more drops"
        )
    if found.method == methods.SIMULATION:
        return PoseShares(
            probability, float(sum(pose.count for pose in poses)), np.arange(len(poses))
        )
    unit = np.unique([pose.group for pose in poses], return_inverse=True)[1].reshape(-1)
    off = np.bincount(unit, [pose.standard_error for pose in poses]).astype(np.float64)
    certain = PoseShares(probability, math.inf, unit)
    return certain._replace(drops=equivalent_drops(certain.shares, off))


def equivalent_drops(shares: Array, errors: Array) -> float:
    """Drops n whose counts would have these errors; NaN where no errors are known.

    The sum of the squares of `standard_errors` is that of q (1 - q) / n, with q between the share
    and 1 / K, so that n stands on both sides; the mean of both converges.
    """
    scatter = float((errors * errors).sum())
    if (
        scatter == 0.0 or shares.size == 1
    ):  # poses that symmetry makes alike are all there are
        return math.inf
    drops = 1.0 / scatter
    for _ in range(MOST_ROUNDS):
        q = (drops * shares + 0.5) / (drops + 0.5 * shares.size)
        spread = max(
            0.0, float((q * (1.0 - q)).sum())
        )  # of shares that round to above 1, too
        drops = math.sqrt(drops * spread / scatter)
    return drops
