"""Stable faces gathered into poses.

A tessellated curve has many stable faces where the part has one pose (section 2.B). Going
up the merge tree, two regions are one pose where the saddle between them lies less than
the tolerance above the lowest stable face of both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tolerances import SAME_HEIGHT
from .equilibria import Equilibria, ties

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Clusters:
    """Poses as groups of stable faces.

    Attributes
    ----------
    tolerance : float
        Fraction of the radius.
    node : (P,) array
        Node of the merge tree that each pose is, poses by rising height.
    lowest : (P,) array
        Number of the stable face that stands for the pose: its lowest; ties go to the
        larger face, then to the smaller number.
    pose : (S,) array
        Pose of each stable face, in the numbering of `Equilibria.order`.
    barrier : (P,) array
        Rise of the centre of mass over the saddle out of the pose, in radii; infinite for
        a single pose.
    split : (S - 1,) array of bool
        Joins of the merge tree that part poses from each other.
    """

    tolerance: float
    node: Index
    lowest: Index
    pose: Index
    barrier: Array
    split: NDArray[np.bool_]


def clusters(found: Equilibria, tolerance: float) -> Clusters:
    """Gather stable faces into poses.

    Parameters
    ----------
    found : Equilibria
    tolerance : float
        Barrier below which regions merge, as a fraction of the radius; 0 merges nothing.
    """
    tree = found.arrays.tree
    leaves = found.order.shape[0]
    bottom = np.empty(2 * leaves - 1)
    bottom[:leaves] = found.heights[found.rank]
    merged = np.zeros(2 * leaves - 1, dtype=np.bool_)
    merged[:leaves] = True
    parent = np.full(2 * leaves - 1, -1, dtype=np.int64)
    for j, (a, b) in enumerate(tree.child.tolist()):
        parent[a] = parent[b] = leaves + j
        bottom[leaves + j] = min(bottom[a], bottom[b])
        shallow = tree.level[j] - bottom[leaves + j] < tolerance
        merged[leaves + j] = tolerance > 0.0 and shallow and merged[a] and merged[b]
    nodes = np.flatnonzero(merged & ((parent < 0) | ~merged[parent]))
    return _number(found, tolerance, nodes, parent, ~merged[leaves:])


def _number(found: Equilibria, tolerance: float, nodes: Index, parent: Index,
            split: NDArray[np.bool_]) -> Clusters:
    """Pick each node's lowest stable face and number the poses by it."""
    tree = found.arrays.tree
    leaves = found.order.shape[0]
    owner = np.empty(leaves, dtype=np.int64)
    for i, (begin, end) in enumerate(tree.leaf_range[nodes].tolist()):
        owner[found.rank[tree.leaf_order[begin:end]]] = i
    # By rising height, then falling area, then number; heights and areas with a tolerance.
    areas = found.body.arrays.area[found.faces]
    rank = ties((found.heights, SAME_HEIGHT), (-areas / areas.max(), SAME_HEIGHT))
    preferred = np.argsort(rank, kind="stable")
    first = np.full(nodes.shape[0], -1, dtype=np.int64)
    first[owner[preferred[::-1]]] = preferred[::-1]
    order = np.argsort(first, kind="stable")
    number = np.empty_like(order)
    number[order] = np.arange(order.shape[0])
    above = parent[nodes[order]]
    saddle = np.array([tree.level[k - leaves] if k >= 0 else math.inf for k in above.tolist()])
    lowest = first[order]
    return Clusters(tolerance, nodes[order], lowest, number[owner],
                    saddle - found.heights[lowest], split)
