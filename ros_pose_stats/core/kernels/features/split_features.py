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

"""What tells the components of a split apart: sizes, depths, edges and inertia.

All of it is continuous in the shape, also where a face becomes marginal, where a face
breaks in two along a shallow ridge and where splits change their order.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Fixed2, FixedFlags1, FixedIndex1, Flags, Index
from ..body.arcs import OVER_ANGLE, OVER_LENGTH, SUMS, Arcs, add_arc, make_arcs
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, inlined, kernel
from ..levels.merge_tree import MergeTree, faces_of
from ..vectors import dot, point_at

# columns of a component's additive measures (6,)
AREA = 0  # solid angle with r < level
AREA_R = 1  # with R < level
HOLDING_AREA = 2  # of the faces that hold
LEVER = 3  # that times the log of the inertia about `down` over the mean one
# and by `add_arc` the turns of the edges' arcs
SWEPT = 4  # over their angles
ROLLED = 5  # over their lengths
MEASURES = 6

# features of a component at a level
LOG_AREA = 0  # log of the share of the sphere with r < level
SHARE_R = 1  # that of R over it
LOG_SHARE_R = 2  # and its log
DEPTH = 3  # depth over level
LEVEL = 4
LOWEST = 5  # lowest height
INERTIA = 6  # mean log of the inertia about `down` over the mean one
LOG_HELD = 7  # log of the solid angle of the faces that hold
LOG_ROLLED = 8  # log of the turns over the arcs' lengths, over the root of the area
LOG_SWEPT = 9  # the same over their angles
LOG_DEPTH = 10
AREA_NEAR = 11  # by `write_joined_measure`: of the area
AREA_FAR = 12
HELD_NEAR = 13  # and of the faces that hold
HELD_FAR = 14
FEATURES = 15

OUTSIDE_TILT = 0.3
"""Tilt, in radians, from which on a face whose foot lies outside of it holds nothing
back.
"""

SAME_FACE_ANGLE = 0.15
"""Angle, in radians, to the stable face below from which on a face is another one."""

SMALLEST_SHARE = 1e-12
"""Share of the sphere that logarithms start from."""

SHALLOWEST_DEPTH = 1e-4
"""Depth over level that logarithms start from."""

SHORT_RISE = 0.01
LONG_RISE = 0.1
"""Rises of the level, in radii, over which a later join is forgotten."""

LEAST_LOG_HELD = -12.0
LEAST_LOG_SHARE = -8.0
SHORTEST_ARCS = 1e-9


@kernel
def write_features(row: Array, measures: Array, level: float, lowest: float) -> None:
    """Turn measures of a component into features; those by later joins follow."""
    area = max(measures[AREA], 0.0) / (4.0 * math.pi)
    height_area = max(measures[AREA_R], 0.0) / (4.0 * math.pi)
    root_of_area = math.sqrt(area + SMALLEST_SHARE)
    row[LOG_AREA] = math.log(area + SMALLEST_SHARE)
    row[SHARE_R] = min(height_area / (area + SMALLEST_SHARE), 1.0)
    row[LOG_SHARE_R] = max(
        math.log(height_area + SMALLEST_SHARE) - row[LOG_AREA], LEAST_LOG_SHARE
    )
    row[DEPTH] = (level - lowest) / level
    row[LEVEL] = level
    row[LOWEST] = lowest
    row[INERTIA] = measures[LEVER] / max(measures[HOLDING_AREA], SMALLEST_SHARE)
    row[LOG_HELD] = max(
        math.log(measures[HOLDING_AREA] / (4.0 * math.pi) + SMALLEST_SHARE),
        LEAST_LOG_HELD,
    )
    row[LOG_ROLLED] = math.log(max(measures[ROLLED], SHORTEST_ARCS) / root_of_area)
    row[LOG_SWEPT] = math.log(max(measures[SWEPT], SHORTEST_ARCS) / root_of_area)
    row[LOG_DEPTH] = math.log(row[DEPTH] + SHALLOWEST_DEPTH)


@kernel
def write_joined_measure(
    features: Array,
    tree: MergeTree,
    is_split: Flags,
    log_measure: int,
    rise: float,
    column: int,
) -> None:
    """Log of a measure with that of all that soon joins, over the component's own.

    What joins higher up counts the less the higher, over the `rise`. Where joins tie,
    it is the same in any order. `log_measure`: feature that is the logarithm of the
    measure.
    """
    joins = tree.level.shape[0]
    joined_measure = np.zeros(joins)
    for j in range(joins - 1, -1, -1):
        if not is_split[j]:
            continue
        features[j, 2, column] = math.log1p(
            joined_measure[j] / math.exp(features[j, 2, log_measure])
        )
        for c in range(2):
            joined_total = math.exp(features[j, 1 - c, log_measure]) + joined_measure[j]
            features[j, c, column] = math.log1p(
                joined_total / math.exp(features[j, c, log_measure])
            )
            lower_join = tree.child[j, c] - joins - 1
            if lower_join >= 0:
                joined_measure[lower_join] = (
                    math.exp((tree.level[lower_join] - tree.level[j]) / rise)
                    * joined_total
                )


@kernel
def holding_faces(
    arcs: Arcs, stable: Index, basin: Index, tree: MergeTree
) -> tuple[Array, Array]:
    """Running sums (F + 1,) over `face_order` of the holding solid angle.

    A face holds what lands on it if the foot of the centre of mass lies inside, less
    the farther it lies outside, or if it is nearly the stable face below. The second
    sum is weighted by the log of the inertia about the face's normal over the mean one.
    """
    body = arcs.body
    inertia = arcs.inertia
    faces = body.distance.shape[0]
    tilt = np.zeros(faces)
    for k in range(body.twin.shape[0]):
        f = body.face[k]
        tilt[f] = max(tilt[f], -arcs.lean[k])
    mean = (inertia[0, 0] + inertia[1, 1] + inertia[2, 2]) / 3.0
    holding = np.zeros(faces + 1)
    lever = np.zeros(faces + 1)
    for i in range(faces):
        f = tree.face_order[i]
        moment = 0.0
        for x in range(3):
            for y in range(3):
                moment += body.normal[f, x] * inertia[x, y] * body.normal[f, y]
        cosine = dot(point_at(body.normal, f), point_at(body.normal, stable[basin[f]]))
        angle = math.acos(min(max(cosine, -1.0), 1.0))
        share = max(
            max(0.0, 1.0 - tilt[f] / OUTSIDE_TILT) ** 2,
            max(0.0, 1.0 - angle / SAME_FACE_ANGLE) ** 2,
        )
        holding[i + 1] = holding[i] + share * body.angle[f]
        lever[i + 1] = lever[i] + share * body.angle[f] * math.log(moment / mean)
    return holding, lever


@kernel
def lowest_faces(body: BodyArrays, stable: Index, tree: MergeTree) -> Array:
    """Smallest height (2 S - 1,) of a stable face below each node."""
    leaves = stable.shape[0]
    lowest = np.empty(2 * leaves - 1)
    lowest[:leaves] = body.distance[stable]
    for j in range(leaves - 1):
        lowest[leaves + j] = min(lowest[tree.child[j, 0]], lowest[tree.child[j, 1]])
    return lowest


class ArcLists(NamedTuple):
    """Linked lists of the arcs of each node that are not all below the level yet.

    Components rise as they join: an arc all below the level is so in all that follow.
    """

    head: Index  # (2 S - 1,) -1 for an empty list
    tail: Index  # (2 S - 1,)
    next_arc: Index  # (N,) the next in the list of an arc, -1 at its end
    finished: Array  # (2 S - 1, SUMS) of those that have left


@entry_kernel
def split_features(
    points: Fixed2,
    body: BodyArrays,
    stable: FixedIndex1,
    basin: FixedIndex1,
    tree: MergeTree,
    is_split: FixedFlags1,
    areas_r: Fixed2,
    areas_R: Fixed2,
    inertia: Fixed2,
) -> Array:
    """Features (S - 1, 3, FEATURES) of the components of every split, the whole last.

    `is_split`: joins that are splits between poses, the others have 0; `areas_r,
    areas_R`: as from `split_probabilities`; `inertia`: over the mass and the squared
    radius.
    """
    joins = tree.level.shape[0]
    features = np.zeros((joins, 3, FEATURES))
    if not is_split.any():
        return features
    arcs = make_arcs(points, body, inertia, tree.level[is_split].max())
    holding, lever = holding_faces(arcs, stable, basin, tree)
    lowest = lowest_faces(body, stable, tree)
    lists = _list_arcs(body, tree, is_split, arcs)
    sums = np.zeros((2, MEASURES))
    arc = np.zeros(SUMS)
    for j in range(joins):
        if not is_split[j]:
            continue
        level = tree.level[j]
        whole = joins + 1 + j
        for c in range(2):
            node = tree.child[j, c]
            begin, end = faces_of(tree, node)
            sums[c, AREA] = areas_r[j, c]
            sums[c, AREA_R] = areas_R[j, c]
            sums[c, HOLDING_AREA] = holding[end] - holding[begin]
            sums[c, LEVER] = lever[end] - lever[begin]
            arc[:] = 0.0
            _add_unfinished_arcs(arc, lists, node, level, arcs)
            arc += lists.finished[node]
            sums[c, SWEPT] = arc[OVER_ANGLE]
            sums[c, ROLLED] = arc[OVER_LENGTH]
            write_features(features[j, c], sums[c], level, lowest[node])
            _append_list(lists, node, whole)
        sums[0] += sums[1]
        write_features(features[j, 2], sums[0], level, lowest[whole])
    write_joined_measure(features, tree, is_split, LOG_AREA, SHORT_RISE, AREA_NEAR)
    write_joined_measure(features, tree, is_split, LOG_AREA, LONG_RISE, AREA_FAR)
    write_joined_measure(features, tree, is_split, LOG_HELD, SHORT_RISE, HELD_NEAR)
    write_joined_measure(features, tree, is_split, LOG_HELD, LONG_RISE, HELD_FAR)
    return features


@kernel
def _list_arcs(
    body: BodyArrays, tree: MergeTree, is_split: Flags, arcs: Arcs
) -> ArcLists:
    """The arcs of each pose."""
    joins = tree.level.shape[0]
    nodes = 2 * joins + 1
    lists = ArcLists(
        np.full(nodes, -1, np.int64),
        np.full(nodes, -1, np.int64),
        np.full(body.twin.shape[0], -1, np.int64),
        np.zeros((nodes, SUMS)),
    )
    for j in range(joins):
        for c in range(2):
            node = tree.child[j, c]
            if not is_split[j] or (node > joins and is_split[node - joins - 1]):
                continue
            begin, end = faces_of(tree, node)
            for i in range(begin, end):
                f = tree.face_order[i]
                for k in range(body.face_start[f], body.face_start[f + 1]):
                    if arcs.end[k] <= arcs.begin[k]:
                        continue
                    if lists.head[node] < 0:
                        lists.head[node] = k
                    else:
                        lists.next_arc[lists.tail[node]] = k
                    lists.tail[node] = k
    return lists


@inlined
def _add_unfinished_arcs(
    arc: Array, lists: ArcLists, node: int, level: float, arcs: Arcs
) -> None:
    """Add sums (SUMS,) of what the level has reached of the arcs, passed ones out."""
    previous = -1
    k = lists.head[node]
    while k >= 0:
        following = lists.next_arc[k]
        if level >= arcs.top[k]:
            add_arc(lists.finished[node], arcs, k, arcs.begin[k])
            if previous < 0:
                lists.head[node] = following
            else:
                lists.next_arc[previous] = following
            if following < 0:
                lists.tail[node] = previous
        else:
            if level > arcs.bottom[k]:
                begin = max(
                    arcs.begin[k], math.acos(min(level / arcs.body.reach[k], 1.0))
                )
                add_arc(arc, arcs, k, begin)
            previous = k
        k = following


@inlined
def _append_list(lists: ArcLists, node: int, whole: int) -> None:
    """Append the list of a node to that of the one that it becomes part of."""
    first = lists.head
    last = lists.tail
    for i in range(SUMS):
        lists.finished[whole, i] += lists.finished[node, i]
    if first[whole] < 0:
        first[whole] = first[node]
        last[whole] = last[node]
    elif first[node] >= 0:
        lists.next_arc[last[whole]] = first[node]
        last[whole] = last[node]
