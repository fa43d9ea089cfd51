# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""The splitting graph's skeleton: where basins join, and gather to poses.

Sides between two basins are sorted by their distance from the centre of mass and joined
by Kruskal's rule. The saddles of r and of R are the same points with the same values,
so one tree serves both (section 4.D); read downwards it is the paper's splitting graph.

Where two components meet at a saddle, the one whose lowest face is the higher of the
two ends (the elder rule of persistence). How far its saddle lies above that face is how
far a nudge has to lift the centre of mass: a component that ends too soon is no pose of
its own and is poured into the pose across the saddle. Whatever was shallower within it
was poured before, so all of it is one region by then.
"""

import math
from typing import NamedTuple

import numpy as np

from ...tolerances import SAME_HEIGHT, SAME_LEVEL
from ..array_types import (
    Array,
    Array1,
    Fixed1,
    FixedIndex1,
    Flags,
    Index,
    Index1,
    Index2,
)
from ..body.convex_body import BodyArrays
from ..body.descent import side_level
from ..compilation import entry_kernel, inlined, kernel
from ..mesh.connections import find_representative
from ..sorting import stable_order


class MergeTree(NamedTuple):
    """Binary tree over S stable faces: nodes 0 … S-1 are leaves, S … 2S-2 joins."""

    child: Index2  # (S - 1, 2) nodes joined
    level: Array1  # (S - 1,) distance from the centre of mass where they join, rising
    side: Index1  # (S - 1,) polygon side where they join
    leaf_range: Index2  # (2S - 1, 2) which leaves a node has, from left to right
    face_order: Index1  # (F,) faces, gathered by leaf in that order
    face_range: Index1  # (S + 1,) start of each position's faces


@inlined
def faces_of(tree: MergeTree, node: int) -> tuple[int, int]:
    """Range of `face_order` that a node covers."""
    return (
        tree.face_range[tree.leaf_range[node, 0]],
        tree.face_range[tree.leaf_range[node, 1]],
    )


@kernel
def merge_tree(body: BodyArrays, stable: Index, basin: Index) -> MergeTree:
    """Join basins bottom-up; the result does not depend on how ties are ordered."""
    leaves = stable.shape[0]
    sides, levels = basin_borders(body, basin)
    child = np.full((max(leaves - 1, 0), 2), -1, np.int64)
    level = np.zeros(max(leaves - 1, 0))
    join_side = np.full(max(leaves - 1, 0), -1, np.int64)
    link = np.arange(leaves)
    node = np.arange(leaves)
    bottom = body.distance[stable]
    order = stable_order(levels)
    tie_end = 0
    joins = 0
    for position in range(order.shape[0]):
        if joins == leaves - 1:
            break
        if position == tie_end:
            tie_end = _put_shallow_first(
                body, basin, sides, levels, link, bottom, order, position
            )
        i = order[position]
        k = sides[i]
        a = find_representative(link, basin[body.face[k]])
        b = find_representative(link, basin[body.face[body.twin[k]]])
        if a == b:
            continue
        child[joins, 0] = node[a]
        child[joins, 1] = node[b]
        # Among ties a later one may lie lower by rounding; what follows searches rising
        # levels.
        level[joins] = max(levels[i], level[joins - 1]) if joins > 0 else levels[i]
        join_side[joins] = k
        link[b] = a
        bottom[a] = min(bottom[a], bottom[b])
        node[a] = leaves + joins
        joins += 1
    leaf_range = _order_leaves(child, leaves)
    face_order, face_range = _gather_faces(basin, leaf_range[:leaves, 0])
    return MergeTree(child, level, join_side, leaf_range, face_order, face_range)


@kernel
def _put_shallow_first(
    body: BodyArrays,
    basin: Index,
    sides: Index,
    levels: Array,
    link: Index,
    bottom: Array,
    order: Index,
    begin: int,
) -> int:
    """Order the borders that tie with the one at `begin`; return the tie's end.

    Shallow regions join each other first: rounding must not decide which of them is one
    pose.
    """
    end = _end_of_tie(levels, order, begin, SAME_LEVEL)
    if end - begin > 1:
        depth = np.empty(end - begin)
        for j in range(begin, end):
            k = sides[order[j]]
            depth[j - begin] = -min(
                bottom[find_representative(link, basin[body.face[k]])],
                bottom[find_representative(link, basin[body.face[body.twin[k]]])],
            )
        order[begin:end] = order[begin:end][stable_order(depth)]
    return end


@inlined
def _end_of_tie(levels: Array, order: Index, begin: int, tolerance: float) -> int:
    """Where the borders end that tie with the one at `begin`."""
    end = begin + 1
    while end < order.shape[0]:
        if levels[order[end]] - levels[order[begin]] > tolerance:
            break
        end += 1
    return end


@kernel
def basin_borders(body: BodyArrays, basin: Index) -> tuple[Index, Array]:
    """Polygon sides between two basins, each edge once, and their levels."""
    face = body.face
    twin = body.twin
    count = 0
    for k in range(twin.shape[0]):
        if k < twin[k] and basin[face[k]] != basin[face[twin[k]]]:
            count += 1
    sides = np.empty(count, np.int64)
    levels = np.empty(count)
    count = 0
    for k in range(twin.shape[0]):
        if k < twin[k] and basin[face[k]] != basin[face[twin[k]]]:
            sides[count] = k
            levels[count] = side_level(body, k)
            count += 1
    return sides, levels


@kernel
def _order_leaves(child: Index, leaves: int) -> Index:
    size = np.ones(2 * leaves - 1, np.int64)
    for j in range(leaves - 1):
        size[leaves + j] = size[child[j, 0]] + size[child[j, 1]]
    spans = np.zeros((2 * leaves - 1, 2), np.int64)
    spans[2 * leaves - 2, 1] = leaves
    for j in range(leaves - 2, -1, -1):
        begin = spans[leaves + j, 0]
        for c in range(2):
            n = child[j, c]
            spans[n, 0] = begin
            spans[n, 1] = begin + size[n]
            begin += size[n]
    return spans


@kernel
def _gather_faces(basin: Index, position: Index) -> tuple[Index, Index]:
    leaves = position.shape[0]
    begin = np.zeros(leaves + 1, np.int64)
    for f in range(basin.shape[0]):
        begin[position[basin[f]] + 1] += 1
    for i in range(leaves):
        begin[i + 1] += begin[i]
    next_free = begin.copy()
    order = np.empty(basin.shape[0], np.int64)
    for f in range(basin.shape[0]):
        i = position[basin[f]]
        order[next_free[i]] = f
        next_free[i] += 1
    return order, begin


@entry_kernel
def gather_poses(
    body: BodyArrays,
    basin: FixedIndex1,
    height: Fixed1,
    rank: FixedIndex1,
    run: FixedIndex1,
    tolerance: float,
    run_tolerance: float,
) -> tuple[Index, Array]:
    """Stable face that stands for the pose of each (S,), and their exit levels (S,).

    `rank`: which face stands for several, the smallest first; `run`: round or toothed
    surface of each face, -1 for none; `tolerance`: least rise out of a pose over its
    height; `run_tolerance`: the same between neighbours on one such surface.
    """
    faces = height.shape[0]
    sides, levels = basin_borders(body, basin)
    order = stable_order(levels)
    component = np.arange(faces)
    region = np.arange(faces)
    tie_end = 0
    for i in range(order.shape[0]):
        if i == tie_end:
            tie_end = _put_lower_first(
                body, basin, rank, component, sides, levels, order, i
            )
        k = sides[order[i]]
        level = levels[order[i]]
        s = basin[body.face[k]]
        t = basin[body.face[body.twin[k]]]
        if run[s] >= 0 and run[s] == run[t]:
            a = find_representative(region, s)
            b = find_representative(region, t)
            shallower = height[b if rank[a] < rank[b] else a]
            if level - shallower < run_tolerance * shallower:
                _join_regions(region, rank, s, t)
        a = find_representative(component, s)
        b = find_representative(component, t)
        if a == b:
            continue
        elder, younger = (a, b) if rank[a] < rank[b] else (b, a)
        component[younger] = elder
        if level - height[younger] < tolerance * height[younger]:
            _join_regions(region, rank, s, t)
    eldest = np.array([find_representative(region, s) for s in range(faces)])
    exit_level = np.full(faces, math.inf)
    for i in range(sides.shape[0]):
        a = eldest[basin[body.face[sides[i]]]]
        b = eldest[basin[body.face[body.twin[sides[i]]]]]
        if a != b:
            exit_level[a] = min(exit_level[a], levels[i])
            exit_level[b] = min(exit_level[b], levels[i])
    return eldest, exit_level


@kernel
def _join_regions(region: Index, rank: Index, s: int, t: int) -> None:
    a = find_representative(region, s)
    b = find_representative(region, t)
    if rank[a] < rank[b]:
        region[b] = a
    else:
        region[a] = b


@kernel
def _put_lower_first(
    body: BodyArrays,
    basin: Index,
    rank: Index,
    component: Index,
    sides: Index,
    levels: Array,
    order: Index,
    begin: int,
) -> int:
    """Order borders that tie with the one at `begin`; return the tie's end."""
    end = _end_of_tie(levels, order, begin, SAME_HEIGHT)
    if end - begin > 1:
        elder_rank = np.empty(end - begin)
        for j in range(begin, end):
            k = sides[order[j]]
            s = basin[body.face[k]]
            t = basin[body.face[body.twin[k]]]
            elder = (
                s
                if rank[find_representative(component, s)]
                < rank[find_representative(component, t)]
                else t
            )
            elder_rank[j - begin] = rank[elder]
        order[begin:end] = order[begin:end][stable_order(elder_rank)]
    return end


@entry_kernel
def part_poses(tree: MergeTree, pose: FixedIndex1) -> tuple[Index, Flags]:
    """Pose of each node of the merge tree, -1 for several, and joins of several."""
    leaves = pose.shape[0]
    node_pose = np.full(2 * leaves - 1, -1)
    node_pose[:leaves] = pose
    for j in range(leaves - 1):
        a = node_pose[tree.child[j, 0]]
        b = node_pose[tree.child[j, 1]]
        if a == b:
            node_pose[leaves + j] = a
    return node_pose, node_pose[leaves:] < 0
