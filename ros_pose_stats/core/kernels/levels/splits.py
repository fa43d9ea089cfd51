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

"""Areas of the reachable set, and the probabilities at its splits.

At a split probabilities follow from the areas of both components (Eq. 8), or from given
weights. Both are measured face by face: a component that swallows n neighbours one by
one costs n² faces, which even a part with a few hundred equilibria takes in
milliseconds.
"""

import math

import numpy as np

from ..array_types import Array, Fixed2, FixedFlags1, Index
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, inlined, kernel
from .merge_tree import MergeTree, faces_of
from .right_triangles import RightTriangles, bend_R, bend_r, measure_triangles


@kernel
def faces_below(
    faces: Index,
    begin: int,
    end: int,
    body: BodyArrays,
    triangles: RightTriangles,
    level: float,
    of_R: bool,
) -> float:
    """Solid angle of {r < level} on faces, or of {R < level} by their normals."""
    face_start = body.face_start
    enters = triangles.entry_level
    fills = triangles.full_level
    full = triangles.full_area
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
def _add_side(
    total: float, triangles: RightTriangles, k: int, level: float, of_R: bool
) -> float:
    """Add the shares of both triangles of a polygon side, stage by stage."""
    turn = triangles.turn
    leg = triangles.leg
    foot = triangles.reach
    bends = 0.0
    for i in range(2 * k, 2 * k + 2):
        sense = math.copysign(1.0, turn[i])
        if level >= triangles.final_level[i]:
            total += triangles.final_area[i]
        elif of_R:
            v = triangles.radius[i]
            total += triangles.area[i] - turn[i] * ((v - level) / v)
            if level < foot[i]:
                total -= sense * bend_R(leg[i], v, foot[i], level)
        else:
            total += turn[i] * ((level - triangles.distance[i]) / level)
            bends += sense
    # Both triangles of a side bend alike for r, each in its own sense.
    if bends != 0.0 and level > foot[2 * k]:
        total += bends * bend_r(
            leg[2 * k], triangles.distance[2 * k], foot[2 * k], level
        )
    return total


@entry_kernel
def split_probabilities(
    body: BodyArrays, tree: MergeTree, is_split: FixedFlags1, of_R: bool
) -> tuple[Array, Array]:
    """Solid angles of the components at each join, and their probabilities.

    `is_split`: joins to measure; one may only be left out with all below it. Returns
    `areas` (S - 1, 2), and `probability` (2 S - 1,) of reaching each node (Eq. 8).
    """
    joins = tree.level.shape[0]
    areas = np.zeros((joins, 2))
    probability = np.zeros(2 * joins + 1)
    probability[2 * joins] = 1.0
    if not is_split.any():
        return areas, probability
    triangles = measure_triangles(body, tree.level[is_split], of_R)
    for j in range(joins):
        for c in range(2):
            if is_split[j]:
                begin, end = faces_of(tree, tree.child[j, c])
                area = faces_below(
                    tree.face_order, begin, end, body, triangles, tree.level[j], of_R
                )
                areas[j, c] = max(area, 0.0)
    for j in range(joins - 1, -1, -1):
        total = areas[j, 0] + areas[j, 1]
        for c in range(2):
            if is_split[j]:
                share = areas[j, c] / total if total > 0.0 else 0.5
                probability[tree.child[j, c]] = share * probability[joins + 1 + j]
    return areas, probability


@entry_kernel
def descend_splits(
    weight: Fixed2, carried_share: Fixed2, tree: MergeTree, is_split: FixedFlags1
) -> Array:
    """Probability (2 S - 1,) of reaching each node from the weights of the components.

    A component's weight grows with the level: `weight` is its logarithm where the
    component splits off. Where two join, their weights add, and go on growing as the
    logarithm does from there on. So poses whose splits tie come out the same in any
    order of the splits. `carried_share`: how much of the difference between the sum of
    weights and the whole's own one a child keeps.
    """
    joins = tree.level.shape[0]
    whole_weight = np.zeros(2 * joins + 1)
    probability = np.zeros(2 * joins + 1)
    share = np.zeros((joins, 2))
    probability[2 * joins] = 1.0
    for j in range(joins):
        if not is_split[j]:
            continue
        log_weight = np.empty(2)
        for c in range(2):
            node = tree.child[j, c]
            log_weight[c] = weight[j, c]
            lower_join = node - joins - 1
            if lower_join >= 0 and is_split[lower_join]:
                log_weight[c] += carried_share[j, c] * (
                    whole_weight[node] - weight[lower_join, 2]
                )
        largest = max(log_weight[0], log_weight[1])
        share[j] = np.exp(log_weight - largest)
        total = share[j, 0] + share[j, 1]
        share[j] /= total
        whole_weight[joins + 1 + j] = largest + math.log(total)
    for j in range(joins - 1, -1, -1):
        if is_split[j]:
            for c in range(2):
                probability[tree.child[j, c]] = share[j, c] * probability[joins + 1 + j]
    return probability
