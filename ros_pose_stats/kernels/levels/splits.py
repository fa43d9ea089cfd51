"""Areas of the reachable set, and the probabilities at its splits.

At a split probabilities follow from the areas of both components (Eq. 8), or from given weights.
Of the two components that a join brings together, the one with fewer faces is measured
face by face. Following the larger ones downwards gives paths along which a component only
grows; short paths are measured face by face as well, long ones by `level_sums`. Each face
is on the smaller side at most log2(F) times, so a body with thousands of stable faces
takes hardly longer a face than a body with a few.
"""

import math

import numpy as np

from ..array_types import Array, Fixed2, FixedFlags1, Flags, Index
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, inlined, kernel
from .level_sums import grown_areas
from .merge_tree import MergeTree, faces_of
from .right_triangles import RightTriangles, bend_R, bend_r, measure_triangles

LONG_PATH = 96
"""Joins on a path from which on `level_sums` is quicker than going face by face."""


@kernel
def faces_below(faces: Index, begin: int, end: int, body: BodyArrays, triangles: RightTriangles,
                level: float, of_R: bool) -> float:
    """Centroid solid angle of the reachable set on the faces `faces[begin:end]`.

    That of {r < level} on the faces, or of {R < level} next to their normals.
    """
    face_start = body.face_start
    enters, fills, full = triangles.enters, triangles.fills, triangles.full
    total = 0.0
    for j in range(begin, end):
        f = faces[j]
        if level <= enters[f]:
            continue
        if level >= fills[f]:
            total += full[f]
            continue
        for k in range(face_start[f], face_start[f + 1]):
            total = _add_side(total, triangles, k, level, of_R)
    return total


@inlined
def _add_side(total: float, triangles: RightTriangles, k: int, level: float,
              of_R: bool) -> float:
    """Add the shares of both triangles of a polygon side, stage by stage."""
    turn, leg, foot = triangles.turn, triangles.leg, triangles.foot
    bends = 0.0
    for i in range(2 * k, 2 * k + 2):
        sense = math.copysign(1.0, turn[i])
        if level >= triangles.done[i]:
            total += triangles.after[i]
        elif of_R:
            v = triangles.far[i]
            total += triangles.whole[i] - turn[i] * ((v - level) / v)
            if level < foot[i]:
                total -= sense * bend_R(leg[i], v, foot[i], level)
        else:
            total += turn[i] * ((level - triangles.near[i]) / level)
            bends += sense
    # Both triangles of a side bend alike for r, each in its own sense.
    if bends != 0.0 and level > foot[2 * k]:
        total += bends * bend_r(leg[2 * k], triangles.near[2 * k], foot[2 * k], level)
    return total


@entry_kernel
def areas_below(body: BodyArrays, level: float, of_R: bool) -> Array:
    """Centroid solid angle of the reachable set on each face, steradians.

    Returns (F,): of {r < level} on the face, or of {R < level} next to its normal.
    """
    triangles = measure_triangles(body, np.array([level]), of_R)
    faces = np.arange(body.distance.shape[0])
    angles = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        angles[f] = faces_below(faces, f, f + 1, body, triangles, level, of_R)
    return angles


@entry_kernel
def split_probabilities(body: BodyArrays, tree: MergeTree, wanted: FixedFlags1,
                        of_R: bool) -> tuple[Array, Array]:
    """Solid angles of the components at each split, and the probabilities that follow.

    `wanted` (S - 1,) bool: joins to measure. A join may only be left out together with all joins
    below it: its node is then a leaf; `of_R`: whether the reachable set is that of R (Eq. 7) or of
    r. Returns `areas` (S - 1, 2): steradians just before each join, in the order of `tree.child`;
    0 where not wanted; `probability` (2 S - 1,): of reaching each node of the tree (Eq. 8); 0
    below unwanted joins.
    """
    joins = tree.level.shape[0]
    areas = np.zeros((joins, 2))
    probability = np.zeros(2 * joins + 1)
    probability[2 * joins] = 1.0
    if not wanted.any():
        return areas, probability
    triangles = measure_triangles(body, tree.level[wanted], of_R)
    larger = _larger_child(tree)
    path = np.empty(joins, np.int64)
    on_path = np.zeros(joins, np.bool_)
    for top in range(joins - 1, -1, -1):
        if not wanted[top] or on_path[top]:
            continue
        length = _follow(tree, wanted, larger, top, path)
        on_path[path[:length]] = True
        _measure(body, triangles, tree, larger, path[:length], of_R, areas)
    for j in range(joins - 1, -1, -1):
        both = areas[j, 0] + areas[j, 1]
        for c in range(2):
            if wanted[j]:
                share = areas[j, c] / both if both > 0.0 else 0.5
                probability[tree.child[j, c]] = share * probability[joins + 1 + j]
    return areas, probability


@kernel
def _larger_child(tree: MergeTree) -> Index:
    joins = tree.level.shape[0]
    larger = np.empty(joins, np.int64)
    for j in range(joins):
        begin, end = faces_of(tree, tree.child[j, 0])
        start, stop = faces_of(tree, tree.child[j, 1])
        larger[j] = 0 if end - begin >= stop - start else 1
    return larger


@kernel
def _follow(tree: MergeTree, wanted: Flags, larger: Index, top: int,
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
def _measure(body: BodyArrays, triangles: RightTriangles, tree: MergeTree, larger: Index,
             path: Index, of_R: bool, areas: Array) -> None:
    """Areas of both children of every join on a path."""
    order = tree.face_order
    for j in path:
        c = 1 - larger[j]
        begin, end = faces_of(tree, tree.child[j, c])
        areas[j, c] = max(faces_below(order, begin, end, body, triangles, tree.level[j], of_R),
                          0.0)
    if path.shape[0] >= LONG_PATH:
        grown = grown_areas(body, triangles, tree, larger, path, of_R)
        for k in range(path.shape[0]):
            areas[path[k], larger[path[k]]] = max(grown[k], 0.0)
        return
    for j in path:
        c = larger[j]
        begin, end = faces_of(tree, tree.child[j, c])
        areas[j, c] = max(faces_below(order, begin, end, body, triangles, tree.level[j], of_R),
                          0.0)


@entry_kernel
def descend_splits(weight: Fixed2, kept: Fixed2, tree: MergeTree, wanted: FixedFlags1) -> Array:
    """Probability (2 S - 1,) of reaching each node from the weights of the components.

    A component's weight grows with the level: `weight` is its logarithm where the component
    splits off. Where two join, their weights add, and go on growing as the logarithm does from
    there on. So poses whose splits tie come out the same in any order of the splits.

    `weight` (S - 1, 3): for both children and the whole at each join; `kept` (S - 1, 2): how much
    of the difference between the sum of weights and the whole's own one a child keeps that was put
    together below, 0 to 1.
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
