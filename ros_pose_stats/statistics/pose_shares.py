"""Probabilities of the poses with errors that go together as those of counts do.

Probabilities that were not counted are taken to be as uncertain as if counted in as many drops as
would leave their errors.
"""

import math
from typing import NamedTuple

import numpy as np

from ..errors import RequestError
from ..methods import SIMULATION
from ..records import Array, Index, PoseStatistics

MOST_ROUNDS = 40  # each round halves the error of the logarithm


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

    def scatter(self, values: Array) -> float:
        """Variance of a value of the poses (K,) over drops that end in the units, not within."""
        each = np.bincount(self.unit, values) / np.bincount(self.unit)
        mean = float(self.shares @ each)
        return max(0.0, float(self.shares @ (each - mean) ** 2))


def pose_shares(found: PoseStatistics) -> PoseShares:
    """Probabilities of a result as feeding needs them.

    Of counted poses each has an error of its own. Estimates, and whatever else knows of the
    symmetry, share one error evenly among the poses that are alike.
    """
    poses = sorted(found.poses, key=lambda pose: pose.index)
    probability = np.array([pose.probability for pose in poses])
    if not np.isfinite(probability).all():
        raise RequestError("probabilities of the poses", "none", "simulate more drops")
    if found.method == SIMULATION:
        return PoseShares(probability, float(sum(pose.count for pose in poses)),
                          np.arange(len(poses)))
    unit = np.unique([pose.group for pose in poses], return_inverse=True)[1].reshape(-1)
    errors = np.bincount(unit, [pose.standard_error for pose in poses]).astype(np.float64)
    certain = PoseShares(probability, math.inf, unit)
    return certain._replace(drops=equivalent_drops(certain.shares, errors))


def equivalent_drops(shares: Array, errors: Array) -> float:
    """Drops n whose counts would have these errors; NaN where no errors are known.

    The sum of the squares of `standard_errors` is that of q (1 - q) / n, with q between the share
    and 1 / K, so that n stands on both sides; the mean of both converges.
    """
    scatter = float((errors * errors).sum())
    if scatter == 0.0 or shares.size == 1:  # poses that symmetry makes alike are all there are
        return math.inf
    drops = 1.0 / scatter
    for _ in range(MOST_ROUNDS):
        q = (drops * shares + 0.5) / (drops + 0.5 * shares.size)
        spread = max(0.0, float((q * (1.0 - q)).sum()))  # of shares that round to above 1, too
        drops = math.sqrt(drops * spread / scatter)
    return drops
