"""Regions of the merge tree that are one pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed1
from ..compilation import entry_kernel
from .merge_tree import MergeTree

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]


@entry_kernel
def merge_regions(tree: MergeTree, height: Fixed1,
                  tolerance: float) -> tuple[Index, Index, Index, Flags]:
    """Gather leaves wherever the join lies less than the tolerance above the lowest of both.

    Parameters
    ----------
    tree : MergeTree
    height : (S,) array
        Of the leaves.
    tolerance : float
        In the unit of heights and levels; 0 gathers nothing.

    Returns
    -------
    node : (P,) array of int
        Largest nodes of the tree whose leaves are gathered.
    above : (P,) array of int
        Join over each of them; -1 over the root.
    owner : (S,) array of int
        Position in `node` of the one that holds each leaf.
    split : (S - 1,) array of bool
        Joins that gather nothing.
    """
    leaves = height.shape[0]
    bottom = np.empty(2 * leaves - 1)
    bottom[:leaves] = height
    merged = np.ones(2 * leaves - 1, np.bool_)
    parent = np.full(2 * leaves - 1, -1)
    for j in range(leaves - 1):
        a, b, both = tree.child[j, 0], tree.child[j, 1], leaves + j
        parent[a] = parent[b] = j
        bottom[both] = min(bottom[a], bottom[b])
        shallow = tree.level[j] - bottom[both] < tolerance
        merged[both] = tolerance > 0.0 and shallow and merged[a] and merged[b]
    owner = np.empty(leaves, np.int64)
    node, above = np.empty(leaves, np.int64), np.empty(leaves, np.int64)
    count = 0
    for k in range(2 * leaves - 1):
        if not merged[k] or (parent[k] >= 0 and merged[leaves + parent[k]]):
            continue
        owner[tree.leaf_order[tree.leaf_range[k, 0]:tree.leaf_range[k, 1]]] = count
        node[count], above[count] = k, parent[k]
        count += 1
    return node[:count], above[:count], owner, ~merged[leaves:]
