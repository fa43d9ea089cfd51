"""What tells the components of a split apart: sizes, depths, edges and inertia.

All of it is continuous in the shape, also where a face becomes marginal, where a face breaks
in two along a shallow ridge and where splits change their order.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..array_types import Fixed2, FixedFlags1, FixedIndex1
from ..body.arcs import Arcs, arc_sums, make_arcs
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, kernel
from ..levels.merge_tree import MergeTree
from ..vectors import inverse_of
from .component_features import (
    FAR,
    FEATURES,
    NEAR,
    holding_faces,
    joined_soon,
    lowest_faces,
    write_row,
)

Array = NDArray[np.float64]
Index = NDArray[np.int64]

@entry_kernel
def split_features(points: Fixed2, body: BodyArrays, stable: FixedIndex1, basin: FixedIndex1,
                   tree: MergeTree, wanted: FixedFlags1, areas_r: Fixed2, areas_R: Fixed2,
                   inertia: Fixed2) -> Array:
    """Features of both components of every split, and of the one that they come from.

    Parameters
    ----------
    points, body, stable, basin, tree
        As from `build_body` and `find_equilibria`.
    wanted : (S - 1,) array of bool
        Joins that are splits between poses.
    areas_r, areas_R : (S - 1, 2) arrays
        As from `split_probabilities`, steradians.
    inertia : (3, 3) array
        Central inertia over the mass and the squared radius.

    Returns
    -------
    (S - 1, 3, FEATURES) array
        At the level of the join, in the order of `tree.child`, the whole last; 0 where not
        wanted.
    """
    joins = tree.level.shape[0]
    found = np.zeros((joins, 3, FEATURES))
    if not wanted.any():
        return found
    inverse = inverse_of(inertia)
    arcs = make_arcs(points, body, inertia, inverse)
    held, turned = holding_faces(body, stable, basin, tree, inertia)
    lowest = lowest_faces(body, stable, tree)
    first, last, after, below = _lists(body, tree, wanted, arcs)
    sums = np.zeros((2, 6))
    for j in range(joins):
        if not wanted[j]:
            continue
        level, whole = tree.level[j], joins + 1 + j
        for c in range(2):
            node = tree.child[j, c]
            begin = tree.face_range[tree.leaf_range[node, 0]]
            end = tree.face_range[tree.leaf_range[node, 1]]
            sums[c, 0], sums[c, 1] = areas_r[j, c], areas_R[j, c]
            sums[c, 2] = held[end] - held[begin]
            sums[c, 3] = turned[end] - turned[begin]
            sums[c, 4:] = 0.0
            before, k = -1, first[node]
            while k >= 0:
                onward = after[k]
                if level >= arcs.top[k]:
                    below[node] += arcs.whole[k]
                    if before < 0:
                        first[node] = onward
                    else:
                        after[before] = onward
                    if onward < 0:
                        last[node] = before
                else:
                    if level > arcs.bottom[k]:
                        cut = max(arcs.near[k], math.acos(min(level / body.reach[k], 1.0)))
                        swept, rolled = arc_sums(k, cut, points, body, arcs, inertia, inverse)
                        sums[c, 4] += swept
                        sums[c, 5] += rolled
                    before = k
                k = onward
            sums[c, 4:] += below[node]
            write_row(found[j, c], sums[c], level, lowest[node])
            below[whole] += below[node]
            if first[whole] < 0:
                first[whole], last[whole] = first[node], last[node]
            elif first[node] >= 0:
                after[last[whole]] = first[node]
                last[whole] = last[node]
        sums[0] += sums[1]
        write_row(found[j, 2], sums[0], level, lowest[whole])
    joined_soon(found, tree, wanted, 0, NEAR, 11)
    joined_soon(found, tree, wanted, 0, FAR, 12)
    joined_soon(found, tree, wanted, 7, NEAR, 13)
    joined_soon(found, tree, wanted, 7, FAR, 14)
    return found


@kernel
def _lists(body: BodyArrays, tree: MergeTree, wanted: NDArray[np.bool_],
           arcs: Arcs) -> tuple[Index, Index, Index, Array]:
    """A linked list of the arcs of each pose, and what lies below the level, nothing yet.

    Components rise as they join: an arc that is all below the level is so in all that follow,
    and leaves its list.
    """
    joins = tree.level.shape[0]
    nodes = 2 * joins + 1
    first, last = np.full(nodes, -1, np.int64), np.full(nodes, -1, np.int64)
    after = np.full(body.twin.shape[0], -1, np.int64)
    for j in range(joins):
        if not wanted[j]:
            continue
        for c in range(2):
            node = tree.child[j, c]
            if node > joins and wanted[node - joins - 1]:
                continue
            begin = tree.face_range[tree.leaf_range[node, 0]]
            end = tree.face_range[tree.leaf_range[node, 1]]
            for i in range(begin, end):
                f = tree.face_order[i]
                for k in range(body.face_start[f], body.face_start[f + 1]):
                    if arcs.far[k] > arcs.near[k]:
                        if first[node] < 0:
                            first[node] = k
                        else:
                            after[last[node]] = k
                        last[node] = k
    return first, last, after, np.zeros((nodes, 2))
