"""How much surer a lattice of starts is than random ones, measured on its own blocks.

Each block of the lattice is rotated at random by itself, so blocks are independent draws and
the scatter of their counts tells the variance of the whole, whatever the outcomes depend on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import RequestError

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


BLOCK: Final = 64
"""Consecutive drops that share one random rotation."""

FEWEST_BLOCKS: Final = 8
"""Full blocks below which their scatter is not trusted and the binomial variance stands."""

SMALLEST_FACTOR: Final = 1.0 / BLOCK
"""As if one drop of every block were random: blocks that happen to agree are not certain."""

PRIOR_BLOCKS: Final = 10.0
"""Weight of the binomial variance, in blocks, where one pose is judged by itself."""


class BlockSums:
    """Counts of a lattice run and their scatter between its blocks.

    Grows with the contiguous prefix of the run and holds a few numbers a pose, not the drops.

    Parameters
    ----------
    poses : int
        K, the number of poses.
    """

    def __init__(self, poses: int) -> None:
        self._poses = poses
        self._full_blocks = 0
        self._closed = block_moments(np.empty((0, BLOCK), np.int64), poses)
        self._open: Outcomes = np.empty(0, np.int64)

    def add(self, outcomes: ArrayLike) -> None:
        """Lengthen the prefix.

        Parameters
        ----------
        outcomes : (n,) array of int
            Index of the pose of each next drop; -1 where it did not settle.

        Raises
        ------
        RequestError
            If an index is not a pose's.
        """
        fresh = np.asarray(outcomes, dtype=np.int64)
        if fresh.size and not (fresh.min() >= -1 and fresh.max() < self._poses):
            raise RequestError(f"pose indices from -1 to {self._poses - 1}",
                               f"{fresh.min()} to {fresh.max()}",
                               "number the outcomes by the same part and cluster tolerance")
        joined = np.concatenate((self._open, fresh))
        full = len(joined) // BLOCK
        self._closed += block_moments(joined[:full * BLOCK].reshape(full, BLOCK), self._poses)
        self._open = joined[full * BLOCK:].copy()
        self._full_blocks += full

    @property
    def drops(self) -> int:
        """Length of the prefix, settled or not."""
        return self._full_blocks * BLOCK + len(self._open)

    @property
    def settled(self) -> int:
        """Drops that came to rest."""
        return self._all().settled

    @property
    def counts(self) -> NDArray[np.int64]:
        """Drops that came to rest in each pose, (K,)."""
        return self._all().counts

    def factor(self) -> float:
        """Variance over that of as many random drops, one number for all poses.

        The sum over poses of `block_variances` over that of `binomial_variances`, at least
        1/64; 1 for fewer than eight full blocks and where no count can scatter. Multiply the
        standard errors by its root: their mean square is right, hence the expected error.
        """
        if not self._enough_blocks():
            return 1.0
        binomial = float(self.binomial_variances().sum())
        ratio = float(self.block_variances().sum()) / binomial if binomial > 0.0 else 1.0
        return max(ratio, SMALLEST_FACTOR)

    def factors(self) -> Array:
        """Variance over that of as many random drops for each pose by itself, (K,).

        A lattice helps frequent poses with simple basins; a rare one gains next to nothing
        (counts below one a block scatter like random ones), and `factor` would promise it
        too narrow an interval. Ten blocks' worth of the binomial variance is mixed in, so
        that few blocks do not make a pose look surer than it is. For intervals: count / factor
        of n / factor effective drops. 1 for fewer than eight full blocks and where the count
        cannot scatter.
        """
        found = np.ones(self._poses)
        if not self._enough_blocks():
            return found
        binomial = self.binomial_variances()
        free = effective_blocks(self._all()) - 1.0
        seen = binomial > 0.0
        ratio = self.block_variances()[seen] / binomial[seen]
        found[seen] = (free * ratio + PRIOR_BLOCKS) / (free + PRIOR_BLOCKS)
        return found

    def cautious_factor(self) -> float:
        """As `factor`, by `factors`: few blocks do not make counts look surer than they are."""
        binomial = self.binomial_variances()
        total = float(binomial.sum())
        return float((self.factors() * binomial).sum()) / total if total > 0.0 else 1.0

    def binomial_variances(self) -> Array:
        """What independent drops would have: p (1 - p) / n of each pose (K,); NaN for n = 0."""
        return binomial_variances(self._all())

    def block_variances(self) -> Array:
        """Variance of each pose's count / settled (K,) from the scatter between blocks.

        NaN for fewer than two blocks; see the function `block_variances`.
        """
        return block_variances(self._all())

    def _enough_blocks(self) -> bool:
        # Where most drops do not settle, a few blocks may hold nearly all that do.
        return (self._full_blocks >= FEWEST_BLOCKS
                and effective_blocks(self._all()) >= 0.5 * FEWEST_BLOCKS)

    def _all(self) -> BlockMoments:
        return self._closed + block_moments(self._open.reshape(1, -1), self._poses)
