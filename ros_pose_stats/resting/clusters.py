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

from ..kernels.levels.merge_tree import merge_regions
from ..tolerances import SAME_HEIGHT
from .equilibria import Equilibria, ties

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Clusters:
    """The poses of a part as groups of stable faces.

    Attributes
    ----------
    tolerance : float
        Fraction of the radius.
    node : (P,) array
        Node of the merge tree of each pose, by rising height.
    lowest : (P,) array
        Number of the stable face that stands for the pose: its lowest; ties go to the
        larger face, then to the smaller number.
    pose : (S,) array
        Pose of each stable face, in the numbering of `Equilibria.order`.
    barrier : (P,) array
        Rise of the centre of mass over the saddle out of the pose, in radii; infinite for
        a single pose.
    split : (S - 1,) array of bool
        Whether a join of the merge tree separates poses from each other.
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
    node, above, owner, split = merge_regions(
        found.arrays.tree, found.heights[found.rank], tolerance)
    owner = owner[found.order]
    order, lowest = _by_lowest(found, owner, node.shape[0])
    number = np.empty_like(order)
    number[order] = np.arange(order.shape[0])
    level = np.append(found.arrays.tree.level, math.inf)  # above the root
    return Clusters(tolerance, node[order], lowest, number[owner],
                    level[above[order]] - found.heights[lowest], split)


def _by_lowest(found: Equilibria, owner: Index, count: int) -> tuple[Index, Index]:
    """Order (P,) of the groups of stable faces by the face that stands for each, and that face.

    Lower faces go first, larger ones of equal height, then smaller numbers; heights and areas
    are compared with a tolerance.
    """
    areas = found.body.arrays.area[found.faces]
    rank = ties((found.heights, SAME_HEIGHT), (-areas / areas.max(), SAME_HEIGHT))
    preferred = np.argsort(rank, kind="stable")[::-1]
    first = np.empty(count, dtype=np.int64)
    first[owner[preferred]] = preferred
    order = np.argsort(first, kind="stable")
    return order, first[order]
