"""Stable faces gathered into poses by persistence.

Walking up the saddles as Kruskal's rule does, two components meet at each; the one whose lowest
face is the higher of the two ends there (the elder rule of persistence). How far its saddle lies
above that face is how far a nudge has to lift the centre of mass: a component that ends too soon
is no pose of its own and is poured into the pose across the saddle. Whatever was shallower within
it was poured before, so all of it is one region by then.
"""

from __future__ import annotations

import math

import numpy as np

from ...tolerances import SAME_HEIGHT
from ..array_types import Array, Fixed1, FixedIndex1, Flags, Index
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, kernel
from ..mesh.components import root
from ..sorting import stable_order
from .merge_tree import MergeTree, borders


@entry_kernel
def gather_poses(body: BodyArrays, basin: FixedIndex1, height: Fixed1, rank: FixedIndex1,
                 run: FixedIndex1, tolerance: float, of_run: float) -> tuple[Index, Array]:
    """Gather stable faces into poses.

    `basin` (F,) int: stable face that each face descends to; `height` (S,): of the centre of mass
    on the stable faces; `rank` (S,) int: a permutation: which face stands for a pose that holds
    several, the smallest first; `run` (S,) int: round or toothed surface that the stable faces
    belong to, -1 for none; `tolerance`: least rise out of a pose over its height; 0 gathers
    nothing; `of_run`: the same between neighbours on one round or toothed surface. Returns
    `eldest` (S,) int: stable face that stands for the pose of each; `way_out` (S,): level of the
    lowest saddle out of the pose that each stands for; infinite for others, and for a single pose.
    """
    faces = height.shape[0]
    sides, levels = borders(body, basin)
    order = stable_order(levels)
    component, region = np.arange(faces), np.arange(faces)
    tie = 0
    for i in range(order.shape[0]):
        if i == tie:
            tie = _lower_across_first(body, basin, rank, component, sides, levels, order, i)
        k, level = sides[order[i]], levels[order[i]]
        s, t = basin[body.face[k]], basin[body.face[body.twin[k]]]
        if run[s] >= 0 and run[s] == run[t]:
            _pour(region, height, rank, s, t, level, of_run)
        a, b = root(component, s), root(component, t)
        if a == b:
            continue
        elder, younger = (a, b) if rank[a] < rank[b] else (b, a)
        component[younger] = elder
        if level - height[younger] < tolerance * height[younger]:
            _join(region, rank, s, t)
    eldest = np.array([root(region, s) for s in range(faces)])
    way_out = np.full(faces, math.inf)
    for i in range(sides.shape[0]):
        a = eldest[basin[body.face[sides[i]]]]
        b = eldest[basin[body.face[body.twin[sides[i]]]]]
        if a != b:
            way_out[a] = min(way_out[a], levels[i])
            way_out[b] = min(way_out[b], levels[i])
    return eldest, way_out


@kernel
def _pour(region: Index, height: Array, rank: Index, s: int, t: int, level: float,
          tolerance: float) -> None:
    """Join the poses of two neighbours if the shallower is no deeper than the tolerance."""
    a, b = root(region, s), root(region, t)
    younger = b if rank[a] < rank[b] else a
    if level - height[younger] < tolerance * height[younger]:
        _join(region, rank, s, t)


@kernel
def _join(region: Index, rank: Index, s: int, t: int) -> None:
    a, b = root(region, s), root(region, t)
    if rank[a] < rank[b]:
        region[b] = a
    else:
        region[a] = b


@kernel
def _lower_across_first(body: BodyArrays, basin: Index, rank: Index, component: Index,
                        sides: Index, levels: Array, order: Index, begin: int) -> int:
    """Order borders that tie with the one at `begin` by the face across; where the tie ends."""
    end = begin + 1
    while end < order.shape[0] and levels[order[end]] - levels[order[begin]] <= SAME_HEIGHT:
        end += 1
    if end - begin > 1:
        across = np.empty(end - begin)
        for j in range(begin, end):
            k = sides[order[j]]
            s, t = basin[body.face[k]], basin[body.face[body.twin[k]]]
            elder = s if rank[root(component, s)] < rank[root(component, t)] else t
            across[j - begin] = rank[elder]
        order[begin:end] = order[begin:end][stable_order(across)]
    return end


@entry_kernel
def part_poses(tree: MergeTree, pose: FixedIndex1) -> tuple[Index, Flags]:
    """Find where the merge tree parts poses from each other.

    `pose` (S,) int: pose of each leaf. Returns `held` (2 S - 1,) int: the pose that a node belongs
    to, if all its leaves do; else -1; `split` (S - 1,) bool: joins that hold several poses.
    """
    leaves = pose.shape[0]
    held = np.full(2 * leaves - 1, -1)
    held[:leaves] = pose
    for j in range(leaves - 1):
        a, b = held[tree.child[j, 0]], held[tree.child[j, 1]]
        if a == b:
            held[leaves + j] = a
    return held, held[leaves:] < 0
