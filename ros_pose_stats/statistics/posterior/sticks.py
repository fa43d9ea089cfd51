"""Breaking a stick of length 1 into probabilities, with a strength of belief for each break.

The distribution of Connor and Mosimann (Journal of the American Statistical Association 64,
1969): unit j takes the share V_j of what the units before it have left, V_j ~ Beta(a_j, b_j)
independently. Counts turn it into another one of its kind, so evidence and moments are
closed forms. With b_j = a_(j+1) + b_(j+1) throughout it is the Dirichlet distribution.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaln

Array = NDArray[np.float64]


class Sticks(NamedTuple):
    """Beta parameters (..., G - 1) of the breaks; the last unit takes what is left."""

    taken: Array
    left: Array

    @classmethod
    def around(cls, mean: Array, strength: Array) -> Sticks:
        """With given means, and as sure of each unit as so many drops would make it.

        Parameters
        ----------
        mean : (G,) array
            Above 0, summing to 1.
        strength : (..., G) array
            Pseudo-drops behind each unit, above 0; all alike for a Dirichlet distribution.
        """
        beyond = np.cumsum(mean[:0:-1])[::-1]
        return cls(strength[..., :-1] * mean[:-1], strength[..., :-1] * beyond)

    def updated(self, counts: Array) -> Sticks:
        """After drops: counts (G,) of the units."""
        beyond = np.cumsum(counts[:0:-1])[::-1]
        return Sticks(self.taken + counts[:-1], self.left + beyond)

    def log_evidence(self, counts: Array) -> Array:
        """Logarithm (...) of the probability of this very sequence of outcomes."""
        after = self.updated(counts)
        gained = betaln(after.taken, after.left) - betaln(self.taken, self.left)
        return np.asarray(gained.sum(axis=-1))

    def moments(self) -> tuple[Array, Array]:
        """Means and variances (..., G) of the units."""
        total = self.taken + self.left
        first, rest = self.taken / total, self.left / total
        twice = first * (self.taken + 1.0) / (total + 1.0)
        rest_twice = rest * (self.left + 1.0) / (total + 1.0)
        mean = _broken(first, rest)
        return mean, np.maximum(_broken(twice, rest_twice) - mean * mean, 0.0)


def _broken(share: Array, remaining: Array) -> Array:
    """Products (..., G): each break's share of what all breaks before it left."""
    one = np.ones((*share.shape[:-1], 1))
    before = np.concatenate((one, np.cumprod(remaining, axis=-1)), axis=-1)
    return np.asarray(np.concatenate((share, one), axis=-1) * before)
