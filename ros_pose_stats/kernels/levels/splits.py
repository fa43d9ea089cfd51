"""Transition probabilities at the splits of the reachable set (Eq. 8).

Of the two components that a join brings together, the one with fewer faces is measured
face by face. Following the larger ones downwards gives paths along which a component only
grows; short paths are measured face by face as well, long ones by `level_sums`. Each face
is on the smaller side at most log2(F) times, so a body with thousands of stable faces
takes hardly longer a face than a body with a few.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..array_types import FixedFlags1
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, kernel
from .cap_areas import faces_below
from .level_sums import ORDER, add_bend, chebyshev, collect, tree_nodes
from .merge_tree import MergeTree
from .right_triangles import Flags, make_flags

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LONG_PATH = 96
"""Joins on a path from which on `level_sums` is quicker than going face by face."""


@entry_kernel
def split_probabilities(body: BodyArrays, tree: MergeTree, wanted: FixedFlags1,
                        of_R: bool) -> tuple[Array, Array]:
    """Solid angles of the components at each split, and the probabilities that follow.

    Parameters
    ----------
    body, tree
    wanted : (S - 1,) array of bool
        Joins to measure. A join may only be left out together with all joins below it: its
        node is then a leaf.
    of_R : bool
        Whether the reachable set is that of R (Eq. 7) or of r.

    Returns
    -------
    areas : (S - 1, 2) array
        Steradians just before each join, in the order of `tree.child`; 0 where not wanted.
    probability : (2 S - 1,) array
        Of reaching each node of the tree (Eq. 8); 0 below unwanted joins.
    """
    joins = tree.level.shape[0]
    areas = np.zeros((joins, 2))
    probability = np.zeros(2 * joins + 1)
    probability[2 * joins] = 1.0
    if not wanted.any():
        return areas, probability
    flags = make_flags(body, tree.level[wanted], of_R)
    larger = _larger_child(tree)
    path = np.empty(joins, np.int64)
    on_path = np.zeros(joins, np.bool_)
    for top in range(joins - 1, -1, -1):
        if not wanted[top] or on_path[top]:
            continue
        length = _follow(tree, wanted, larger, top, path)
        on_path[path[:length]] = True
        _measure(body, flags, tree, larger, path[:length], of_R, areas)
    for j in range(joins - 1, -1, -1):
        both = areas[j, 0] + areas[j, 1]
        for c in range(2):
            if wanted[j]:
                share = areas[j, c] / both if both > 0.0 else 0.5
                probability[tree.child[j, c]] = share * probability[joins + 1 + j]
    return areas, probability


@kernel
def _faces_of(tree: MergeTree, node: int) -> tuple[int, int]:
    """Range of `face_order` that a node covers."""
    return (tree.face_range[tree.leaf_range[node, 0]], tree.face_range[tree.leaf_range[node, 1]])


@kernel
def _larger_child(tree: MergeTree) -> Index:
    joins = tree.level.shape[0]
    larger = np.empty(joins, np.int64)
    for j in range(joins):
        begin, end = _faces_of(tree, tree.child[j, 0])
        start, stop = _faces_of(tree, tree.child[j, 1])
        larger[j] = 0 if end - begin >= stop - start else 1
    return larger


@kernel
def _follow(tree: MergeTree, wanted: NDArray[np.bool_], larger: Index, top: int,
            path: Index) -> int:
    """Joins from `top` down along the larger children, returned by rising level."""
    joins = tree.level.shape[0]
    length, j = 0, top
    while j >= 0 and wanted[j]:
        path[length] = j
        length += 1
        j = tree.child[j, larger[j]] - joins - 1
    path[:length] = path[:length][::-1].copy()
    return length


@kernel
def _measure(body: BodyArrays, flags: Flags, tree: MergeTree, larger: Index, path: Index,
             of_R: bool, areas: Array) -> None:
    """Areas of both children of every join on a path."""
    for j in path:
        c = 1 - larger[j]
        begin, end = _faces_of(tree, tree.child[j, c])
        areas[j, c] = max(faces_below(tree.face_order, begin, end, body, flags, tree.level[j],
                                      of_R), 0.0)
    if path.shape[0] >= LONG_PATH:
        sums = _grown(body, flags, tree, larger, path, of_R)
        for k in range(path.shape[0]):
            areas[path[k], larger[path[k]]] = max(sums[k], 0.0)
        return
    for j in path:
        c = larger[j]
        begin, end = _faces_of(tree, tree.child[j, c])
        areas[j, c] = max(faces_below(tree.face_order, begin, end, body, flags, tree.level[j],
                                      of_R), 0.0)


@kernel
def _grown(body: BodyArrays, flags: Flags, tree: MergeTree, larger: Index, path: Index,
           of_R: bool) -> Array:
    """Area of the growing component at every join of a path."""
    count = path.shape[0]
    levels = tree.level[path]
    # The area is constant + slope * (1/M - 1/E for r, E - M for R) + bends; the first two
    # change only where a triangle changes stage, so their steps are kept and summed up at the
    # end. A level M amid the path keeps both small.
    middle = levels[count // 2]
    constant, slope = np.zeros(count + 1), np.zeros(count + 1)
    sums = np.zeros(count)
    points, weights = chebyshev()
    samples = np.zeros((tree_nodes(count), ORDER))
    stack = np.empty((128, 3), np.int64)
    for k in range(count):
        # At join k the component holds what came before: its start, and what joins 0 … k-1
        # brought in.
        begin, end = _faces_of(tree, tree.child[path[0], larger[path[0]]])
        if k > 0:
            begin, end = _faces_of(tree, tree.child[path[k - 1], 1 - larger[path[k - 1]]])
        for i in range(begin, end):
            f = tree.face_order[i]
            if not flags.partial[f]:
                constant[max(k, np.searchsorted(levels, flags.fills[f]))] += flags.full[f]
                continue
            for flag in range(2 * body.face_start[f], 2 * body.face_start[f + 1]):
                _add_flag(flags, flag, levels, middle, k, of_R, constant, slope, points, samples,
                          sums, stack)
    collect(levels, points, weights, samples, sums, stack)
    total = rate = 0.0
    for k in range(count):
        total += constant[k]
        rate += slope[k]
        step = levels[k] - middle
        sums[k] += total + rate * (step if of_R else step / (levels[k] * middle))
    return sums


@kernel
def _add_flag(flags: Flags, i: int, levels: Array, middle: float, first: int, of_R: bool,
              constant: Array, slope: Array, points: Array, samples: Array, sums: Array,
              stack: Index) -> None:
    """Add one triangle to the sums from join `first` on, stage by stage (see `cap_areas`)."""
    whole, turn, leg = flags.whole[i], flags.turn[i], flags.leg[i]
    d, q, v = flags.near[i], flags.foot[i], flags.far[i]
    enters = max(first, np.searchsorted(levels, d, side="right"))
    done = max(enters, np.searchsorted(levels, flags.done[i], side="left"))
    sense = math.copysign(1.0, turn)
    constant[done] += flags.after[i]
    if of_R:
        meets = max(enters, min(done, np.searchsorted(levels, q, side="left")))
        start, rate = whole - turn * ((v - middle) / v), turn / v
        add_bend(levels, enters, meets, -sense, leg, v, q, True, points, samples, sums, stack)
    else:
        meets = max(enters, min(done, np.searchsorted(levels, q, side="right")))
        start, rate = turn * ((middle - d) / middle), turn * d
        add_bend(levels, meets, done, sense, leg, d, q, False, points, samples, sums, stack)
    constant[enters] += start
    constant[done] -= start
    slope[enters] += rate
    slope[done] -= rate
