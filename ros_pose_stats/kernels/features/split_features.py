"""What tells the components of a split apart: sizes, depths, edges and inertia.

All of it is continuous in the shape, also where a face becomes marginal, where a face breaks
in two along a shallow ridge and where splits change their order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Fixed2, FixedFlags1, FixedIndex1, Flags, Index
from ..body.arcs import OVER_ANGLE, OVER_LENGTH, Arcs, arc_sums, make_arcs
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, inlined, kernel
from ..levels.merge_tree import MergeTree, faces_of
from ..vectors import inverse_of
from .component_features import (
    AREA,
    AREA_FAR,
    AREA_NEAR,
    AROUND,
    FAR,
    FEATURES,
    HELD,
    HELD_FAR,
    HELD_NEAR,
    LEVER,
    LOG_AREA,
    LOG_HELD,
    MEASURES,
    NEAR,
    ROLLED,
    SWEPT,
    holding_faces,
    joined_soon,
    lowest_faces,
    write_features,
)


class ArcLists(NamedTuple):
    """A linked list of the arcs of each node of the tree that are not all below the level yet.

    Components rise as they join: an arc that is all below the level is so in all that follow,
    and leaves its list.
    """

    first: Index  # (2 S - 1,) -1 for an empty list
    last: Index   # (2 S - 1,)
    after: Index  # (N,) the next in the list of an arc, -1 at its end
    below: Array  # (2 S - 1, 2) turns of those that have left


@entry_kernel
def split_features(points: Fixed2, body: BodyArrays, stable: FixedIndex1, basin: FixedIndex1,
                   tree: MergeTree, wanted: FixedFlags1, areas_r: Fixed2, areas_R: Fixed2,
                   inertia: Fixed2) -> Array:
    """Features of both components of every split, and of the one that they come from.

    `points, body, stable, basin, tree`: as from `build_body` and `find_equilibria`; `wanted` (S -
    1,) bool: joins that are splits between poses; `areas_r, areas_R` (S - 1, 2): as from
    `split_probabilities`, steradians; `inertia` (3, 3): central inertia over the mass and the
    squared radius. Returns (S - 1, 3, FEATURES): at the level of the join, in the order of
    `tree.child`, the whole last; 0 where not wanted.
    """
    joins = tree.level.shape[0]
    found = np.zeros((joins, 3, FEATURES))
    if not wanted.any():
        return found
    inverse = inverse_of(inertia)
    arcs = make_arcs(points, body, inertia, inverse)
    held, lever = holding_faces(body, stable, basin, tree, inertia)
    lowest = lowest_faces(body, stable, tree)
    lists = _lists(body, tree, wanted, arcs)
    sums = np.zeros((2, MEASURES))
    for j in range(joins):
        if not wanted[j]:
            continue
        level, whole = tree.level[j], joins + 1 + j
        for c in range(2):
            node = tree.child[j, c]
            begin, end = faces_of(tree, node)
            sums[c, AREA], sums[c, AROUND] = areas_r[j, c], areas_R[j, c]
            sums[c, HELD] = held[end] - held[begin]
            sums[c, LEVER] = lever[end] - lever[begin]
            swept, rolled = _turns_above(lists, node, level, points, body, arcs, inertia, inverse)
            sums[c, SWEPT] = swept + lists.below[node, OVER_ANGLE]
            sums[c, ROLLED] = rolled + lists.below[node, OVER_LENGTH]
            write_features(found[j, c], sums[c], level, lowest[node])
            _hand_on(lists, node, whole)
        sums[0] += sums[1]
        write_features(found[j, 2], sums[0], level, lowest[whole])
    joined_soon(found, tree, wanted, LOG_AREA, NEAR, AREA_NEAR)
    joined_soon(found, tree, wanted, LOG_AREA, FAR, AREA_FAR)
    joined_soon(found, tree, wanted, LOG_HELD, NEAR, HELD_NEAR)
    joined_soon(found, tree, wanted, LOG_HELD, FAR, HELD_FAR)
    return found


@kernel
def _lists(body: BodyArrays, tree: MergeTree, wanted: Flags, arcs: Arcs) -> ArcLists:
    """The arcs of each pose."""
    joins = tree.level.shape[0]
    nodes = 2 * joins + 1
    lists = ArcLists(np.full(nodes, -1, np.int64), np.full(nodes, -1, np.int64),
                     np.full(body.twin.shape[0], -1, np.int64), np.zeros((nodes, 2)))
    for j in range(joins):
        for c in range(2):
            node = tree.child[j, c]
            if wanted[j] and not (node > joins and wanted[node - joins - 1]):
                _list_arcs(lists, node, body, tree, arcs)
    return lists


@inlined
def _list_arcs(lists: ArcLists, node: int, body: BodyArrays, tree: MergeTree,
               arcs: Arcs) -> None:
    """Put the arcs of all faces of a node into its list."""
    begin, end = faces_of(tree, node)
    for i in range(begin, end):
        f = tree.face_order[i]
        for k in range(body.face_start[f], body.face_start[f + 1]):
            if arcs.far[k] <= arcs.near[k]:
                continue
            if lists.first[node] < 0:
                lists.first[node] = k
            else:
                lists.after[lists.last[node]] = k
            lists.last[node] = k


@inlined
def _turns_above(lists: ArcLists, node: int, level: float, points: Array, body: BodyArrays,
                 arcs: Arcs, inertia: Array, inverse: Array) -> tuple[float, float]:
    """Turns over the angles and the lengths of what the level has reached of the listed arcs.

    Those that it has passed leave the list.
    """
    swept = rolled = 0.0
    before, k = -1, lists.first[node]
    while k >= 0:
        onward = lists.after[k]
        if level >= arcs.top[k]:
            lists.below[node, OVER_ANGLE] += arcs.whole[k, OVER_ANGLE]
            lists.below[node, OVER_LENGTH] += arcs.whole[k, OVER_LENGTH]
            _take_out(lists, node, before, onward)
        else:
            if level > arcs.bottom[k]:
                cut = max(arcs.near[k], math.acos(min(level / body.reach[k], 1.0)))
                angle, length = arc_sums(k, cut, points, body, arcs, inertia, inverse)
                swept += angle
                rolled += length
            before = k
        k = onward
    return swept, rolled


@inlined
def _take_out(lists: ArcLists, node: int, before: int, onward: int) -> None:
    """Take the arc between two others, -1 for none, out of the list of a node."""
    if before < 0:
        lists.first[node] = onward
    else:
        lists.after[before] = onward
    if onward < 0:
        lists.last[node] = before


@inlined
def _hand_on(lists: ArcLists, node: int, whole: int) -> None:
    """Append the list of a node to that of the one that it becomes part of."""
    first, last = lists.first, lists.last
    lists.below[whole, OVER_ANGLE] += lists.below[node, OVER_ANGLE]
    lists.below[whole, OVER_LENGTH] += lists.below[node, OVER_LENGTH]
    if first[whole] < 0:
        first[whole], last[whole] = first[node], last[node]
    elif first[node] >= 0:
        lists.after[last[whole]] = first[node]
        last[whole] = last[node]
