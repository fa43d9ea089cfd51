"""What tells the components of a split apart: sizes, depths, edges and inertia.

All of it is continuous in the shape, also where a face becomes marginal, where a face breaks
in two along a shallow ridge and where splits change their order.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .arcs import Arcs, arc_sums, make_arcs
from .body import BodyArrays
from .compilation import entry_kernel, kernel
from .merge_tree import MergeTree

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FEATURES = 10
"""Of a component at a level; see `_row`."""

OUTSIDE = 0.3
"""Tilt, in radians, from which on a face whose foot lies outside of it holds nothing back."""

ALIKE = 0.15
"""Angle, in radians, to the stable face below from which on a face is another one."""

SMALLEST = 1e-12
"""Share of the sphere that logarithms start from."""

FAINTEST = -12.0
RAREST = -8.0
SHORTEST = 1e-9


@entry_kernel
def split_features(points: Array, body: BodyArrays, stable: Index, basin: Index,
                   tree: MergeTree, wanted: NDArray[np.bool_], areas_r: Array, areas_R: Array,
                   inertia: Array) -> Array:
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
    inverse: Array = np.linalg.inv(inertia).astype(np.float64)
    arcs = make_arcs(points, body, inertia, inverse)
    held, turned = _held(body, stable, basin, tree, inertia)
    lowest = _lowest(body, stable, tree)
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
            _row(found[j, c], sums[c], level, lowest[node])
            below[whole] += below[node]
            if first[whole] < 0:
                first[whole], last[whole] = first[node], last[node]
            elif first[node] >= 0:
                after[last[whole]] = first[node]
                last[whole] = last[node]
        sums[0] += sums[1]
        _row(found[j, 2], sums[0], level, lowest[whole])
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


@kernel
def _row(row: Array, sums: Array, level: float, lowest: float) -> None:
    """Turn additive measures of a component into features.

    0  log of the share of the sphere with r < level; 1, 2 that of R over it, and its log;
    3  depth over level; 4 level; 5 lowest height; 6 mean log of the inertia about `down` over
    the mean one; 7 log of the solid angle of the faces that hold; 8 log of the turns over the
    lengths of the edges' arcs, over the root of the area; 9 as 8, over their angles.
    """
    area = max(sums[0], 0.0) / (4.0 * math.pi)
    around = max(sums[1], 0.0) / (4.0 * math.pi)
    root = math.sqrt(area + SMALLEST)
    row[0] = math.log(area + SMALLEST)
    row[1] = min(around / (area + SMALLEST), 1.0)
    row[2] = max(math.log(around + SMALLEST) - row[0], RAREST)
    row[3] = (level - lowest) / level
    row[4] = level
    row[5] = lowest
    row[6] = sums[3] / max(sums[2], SMALLEST)
    row[7] = max(math.log(sums[2] / (4.0 * math.pi) + SMALLEST), FAINTEST)
    row[8] = math.log(max(sums[5], SHORTEST) / root)
    row[9] = math.log(max(sums[4], SHORTEST) / root)


@kernel
def _held(body: BodyArrays, stable: Index, basin: Index, tree: MergeTree,
          inertia: Array) -> tuple[Array, Array]:
    """Running sums (F + 1,) over `face_order` of the solid angle of the faces that hold.

    A face holds what lands on it if the foot of the centre of mass lies inside, less the
    farther it lies outside, or if it is nearly the stable face below. The second sum is
    weighted by the log of the inertia about the face's normal over the mean one.
    """
    faces = body.distance.shape[0]
    tilt = np.zeros(faces)
    for k in range(body.twin.shape[0]):
        f = body.face[k]
        tilt[f] = max(tilt[f], math.atan2(-body.inset[k], body.distance[f]))
    mean = (inertia[0, 0] + inertia[1, 1] + inertia[2, 2]) / 3.0
    held, turned = np.zeros(faces + 1), np.zeros(faces + 1)
    for i in range(faces):
        f = tree.face_order[i]
        n, b = body.normal[f], body.normal[stable[basin[f]]]
        about = together = 0.0
        for x in range(3):
            together += n[x] * b[x]
            for y in range(3):
                about += n[x] * inertia[x, y] * n[y]
        apart = math.acos(min(max(together, -1.0), 1.0))
        share = max(max(0.0, 1.0 - tilt[f] / OUTSIDE) ** 2, max(0.0, 1.0 - apart / ALIKE) ** 2)
        held[i + 1] = held[i] + share * body.angle[f]
        turned[i + 1] = turned[i] + share * body.angle[f] * math.log(about / mean)
    return held, turned


@kernel
def _lowest(body: BodyArrays, stable: Index, tree: MergeTree) -> Array:
    """Smallest height (2 S - 1,) of a stable face below each node."""
    leaves = stable.shape[0]
    lowest = np.empty(2 * leaves - 1)
    lowest[:leaves] = body.distance[stable]
    for j in range(leaves - 1):
        lowest[leaves + j] = min(lowest[tree.child[j, 0]], lowest[tree.child[j, 1]])
    return lowest


@entry_kernel
def descend_splits(weight: Array, kept: Array, tree: MergeTree,
                   wanted: NDArray[np.bool_]) -> Array:
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
