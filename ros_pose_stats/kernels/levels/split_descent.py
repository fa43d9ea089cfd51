"""Probabilities down the splitting graph, from the weights of the components."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed2, FixedFlags1
from ..compilation import entry_kernel
from .merge_tree import MergeTree

Array = NDArray[np.float64]


@entry_kernel
def descend_splits(weight: Fixed2, kept: Fixed2, tree: MergeTree, wanted: FixedFlags1) -> Array:
    """Probability (2 S - 1,) of reaching each node from the weights of the components.

    A component's weight grows with the level: `weight` is its logarithm where the component
    splits off. Where two join, their weights add, and go on growing as the logarithm does from
    there on. So poses whose splits tie come out the same in any order of the splits.

    Parameters
    ----------
    weight : (S - 1, 3) array
        For both children and the whole at each join.
    kept : (S - 1, 2) array
        How much of the difference between the sum of weights and the whole's own one a child
        keeps that was put together below, 0 to 1.
    tree, wanted
        As for `split_features`.
    """
    joins = tree.level.shape[0]
    grown = np.zeros(2 * joins + 1)
    probability = np.zeros(2 * joins + 1)
    share = np.zeros((joins, 2))
    probability[2 * joins] = 1.0
    for j in range(joins):
        if not wanted[j]:
            continue
        side = np.empty(2)
        for c in range(2):
            node = tree.child[j, c]
            side[c] = weight[j, c]
            below = node - joins - 1
            if below >= 0 and wanted[below]:
                side[c] += kept[j, c] * (grown[node] - weight[below, 2])
        most = max(side[0], side[1])
        share[j] = np.exp(side - most)
        total = share[j, 0] + share[j, 1]
        share[j] /= total
        grown[joins + 1 + j] = most + math.log(total)
    for j in range(joins - 1, -1, -1):
        if wanted[j]:
            for c in range(2):
                probability[tree.child[j, c]] = share[j, c] * probability[joins + 1 + j]
    return probability
