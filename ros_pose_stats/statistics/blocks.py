"""How much surer a lattice of starts is than random ones, measured on its own blocks.

Each block of the lattice is rotated at random by itself, so blocks are independent draws and
the scatter of their counts tells the variance of the whole, whatever the outcomes depend on.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import RequestError
from .block_moments import (
    BlockMoments,
    binomial_variances,
    block_moments,
    block_variances,
    effective_blocks,
)

Array = NDArray[np.float64]
Outcomes = NDArray[np.int64]

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

    def binomial_variances(self) -> Array:
        """What independent drops would have: p (1 - p) / n of each pose (K,); NaN for n = 0."""
        return binomial_variances(self._all())

    def block_variances(self) -> Array:
        """Variance of each pose's count / settled (K,) from the scatter between blocks.

        NaN for fewer than two blocks; see `block_moments.block_variances`.
        """
        return block_variances(self._all())

    def _enough_blocks(self) -> bool:
        # Where most drops do not settle, a few blocks may hold nearly all that do.
        return (self._full_blocks >= FEWEST_BLOCKS
                and effective_blocks(self._all()) >= 0.5 * FEWEST_BLOCKS)

    def _all(self) -> BlockMoments:
        return self._closed + block_moments(self._open.reshape(1, -1), self._poses)
