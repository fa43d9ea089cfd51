"""Sums over blocks of drops, and the variances that follow from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Outcomes = NDArray[np.int64]


@dataclass(frozen=True)
class BlockMoments:
    """Sums over blocks, of whole numbers: exact, so that the order of adding is no matter.

    With c the count of a pose in a block and m the settled drops of the block: `counts`
    sum c, `squares` sum c², `products` sum c m, each (K,); `settled` sum m,
    `settled_squares` sum m².
    """

    counts: NDArray[np.int64]
    squares: NDArray[np.int64]
    products: NDArray[np.int64]
    settled: int
    settled_squares: int

    def __add__(self, other: BlockMoments) -> BlockMoments:
        return BlockMoments(self.counts + other.counts, self.squares + other.squares,
                            self.products + other.products, self.settled + other.settled,
                            self.settled_squares + other.settled_squares)


def block_moments(outcomes: Outcomes, poses: int) -> BlockMoments:
    """Sums over blocks of outcomes.

    Parameters
    ----------
    outcomes : (B, size) array
        One block a row: indices of poses, -1 where a drop did not settle.
    poses : int
        K.
    """
    settled = (outcomes >= 0).sum(axis=1)
    block, _ = np.nonzero(outcomes >= 0)
    # Only the pairs that occur: blocks times poses may be far more than drops.
    pairs, counts = np.unique(block * poses + outcomes[outcomes >= 0], return_counts=True)
    block, pose = np.divmod(pairs, poses)
    columns = (counts, counts * counts, counts * settled[block])
    # Weighted bincounts are float64, exact for whole numbers below 2^53.
    sums = [np.bincount(pose, column, minlength=poses).astype(np.int64) for column in columns]
    return BlockMoments(sums[0], sums[1], sums[2], int(settled.sum()), int(settled @ settled))


def binomial_variances(moments: BlockMoments) -> Array:
    """Variance p (1 - p) / n of each pose (K,) for independent drops; NaN for n = 0."""
    if moments.settled == 0:
        return np.full(len(moments.counts), np.nan)
    p = moments.counts / moments.settled
    return np.asarray(p * (1.0 - p) / moments.settled)


def effective_blocks(moments: BlockMoments) -> float:
    """n² / sum m²: the number of blocks where all are equal, less where they are not."""
    return moments.settled ** 2 / max(moments.settled_squares, 1)


def block_variances(moments: BlockMoments) -> Array:
    """Variance of each pose's count / settled (K,) from the scatter between blocks.

    That of a ratio estimator (Cochran, "Sampling Techniques", 1977, section 6.3), for blocks
    of unequal numbers of settled drops m (an open last block, drops that did not settle): the
    sum over blocks of (c - p m)² over n², divided by 1 - sum m² / n². For equal blocks the
    divisor is 1 - 1 / blocks; for unequal ones it makes the mean right where a block's
    variance is proportional to m. NaN for fewer than two blocks.
    """
    if effective_blocks(moments) <= 1.0:
        return np.full(len(moments.counts), np.nan)
    p = moments.counts / moments.settled
    scatter = moments.squares - 2.0 * p * moments.products + p * p * moments.settled_squares
    free = 1.0 - 1.0 / effective_blocks(moments)
    # Where all blocks agree, rounding may leave a little less than nothing.
    return np.asarray(np.maximum(scatter, 0.0) / (moments.settled ** 2 * free))
