"""Breaking a stick of length 1 into probabilities, with a strength of belief for each break.

The distribution of Connor and Mosimann (Journal of the American Statistical Association 64,
1969): unit j takes the share V_j of what the units before it have left, V_j ~ Beta(a_j, b_j)
independently. Counts turn it into another one of its kind, so evidence and moments are
closed forms; they remain so where each break is one of a few Beta distributions. With one each,
and b_j = a_(j+1) + b_(j+1) throughout, it is the Dirichlet distribution.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaln

Array = NDArray[np.float64]

SMALLEST: Final = 1e-300
RULED_OUT: Final = 1e-12


class ConnorMosimann(NamedTuple):
    """Breaks of the stick; the last unit takes what is left.

    Each break has K Beta distributions, of which one holds; which one is found out break by
    break. Strengths (M,) hold for all breaks of a stick.
    """

    taken: Array  # (K, M, G - 1) first Beta parameters
    left: Array   # (K, M, G - 1) second ones
    log_share: Array  # (K, M, G - 1) logarithms of how likely each is, or (K, 1, 1) if all alike

    @classmethod
    def around(cls, mean: Array, strength: Array, share: Array) -> ConnorMosimann:
        """With given means, and as sure of each unit as so many drops would make it.

        `mean` (G,): above 0, summing to 1; `strength` (K, M, G): pseudo-drops behind each unit,
        above 0; all alike for a Dirichlet distribution; `share` (K,): how likely each of the K is,
        summing to 1.
        """
        beyond = np.cumsum(mean[:0:-1])[::-1]
        return cls(strength[..., :-1] * mean[:-1], strength[..., :-1] * beyond,
                   np.log(share)[:, None, None])

    def updated(self, counts: Array) -> tuple[ConnorMosimann, Array]:
        """After drops: counts (G,) of the units.

        Returns `log_evidence` (M,): logarithm of the probability of this very sequence of
        outcomes.
        """
        beyond = np.cumsum(counts[:0:-1])[::-1]
        taken, left = self.taken + counts[:-1], self.left + beyond
        likely = self.log_share + betaln(taken, left) - betaln(self.taken, self.left)
        top = likely.max(axis=0)
        together = top + np.log(np.exp(likely - top).sum(axis=0))
        return ConnorMosimann(taken, left, likely - together), together.sum(axis=-1)

    def moments(self) -> tuple[Array, Array]:
        """Means and variances (M, G) of the units."""
        share, mean, square = self._kinds()
        middle = (share * mean).sum(axis=0)
        return middle, np.maximum((share * square).sum(axis=0) - middle * middle, 0.0)

    def kinds(self, weight: Array) -> tuple[Array, Array, Array]:
        """The units by which of the K distributions holds, over all strengths.

        `weight` (M,): of the strengths, summing to 1. Returns (K, G): how likely each of the K is
        for the break of a unit, and the moments where it holds; of one that cannot hold, the
        moments of the likeliest.
        """
        share, mean, square = self._kinds()
        each = weight[:, None] * share
        whole = each.sum(axis=1)
        part = each / np.maximum(whole, SMALLEST)[:, None]
        middle = (part * mean).sum(axis=1)
        spread = np.maximum((part * square).sum(axis=1) - middle * middle, 0.0)
        holds = np.where(whole > RULED_OUT, np.arange(len(whole))[:, None], whole.argmax(axis=0))
        return (whole, np.take_along_axis(middle, holds, axis=0),
                np.take_along_axis(spread, holds, axis=0))

    def _kinds(self) -> tuple[Array, Array, Array]:
        """Shares, means and mean squares (K, M, G) of the units; the last has the last break."""
        share = np.exp(self.log_share)
        total = self.taken + self.left
        first, rest = self.taken / total, self.left / total
        twice = first * (self.taken + 1.0) / (total + 1.0)
        rest_twice = rest * (self.left + 1.0) / (total + 1.0)
        before, before_twice = (_remaining((share * one).sum(axis=0))
                                for one in (rest, rest_twice))
        shares = np.broadcast_to(share, first.shape)
        if not first.shape[-1]:
            whole = np.ones((*first.shape[:-1], 1))
            return whole / len(first), whole, whole
        return (np.concatenate((shares, shares[..., -1:]), axis=-1),
                np.concatenate((first, rest[..., -1:]), axis=-1) * before,
                np.concatenate((twice, rest_twice[..., -1:]), axis=-1) * before_twice)


def _remaining(rest: Array) -> Array:
    """What all breaks before a unit's left (..., G), on average; the last two have one break."""
    one = np.ones((*rest.shape[:-1], 1))
    before = np.concatenate((one, np.cumprod(rest[..., :-1], axis=-1)), axis=-1)
    return np.asarray(np.concatenate((before, before[..., -1:]), axis=-1))
