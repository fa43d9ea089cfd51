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

"""Equilibria of a convex body: stable faces, basins, merge tree, toppling graph.

In the toppling graph of the quasi-static estimators (section 4.B) a part standing on an
unstable face rolls over one of its sides onto a neighbour whose plane is closer to the
centre of mass, so that the graph has no cycle.
"""

import math
from typing import NamedTuple

import numpy as np

from ...tolerances import SAME_EDGE, TIP_MARGIN
from ..array_types import Array, Fixed1, Fixed2, FixedIndex1, FixedIndex2, Index
from ..body.convex_body import BodyArrays
from ..body.descent import (
    basins,
    descend_faces,
    is_lower,
    neighbour_faces,
    sink_unbarred_faces,
    stable_face_below,
)
from ..compilation import entry_kernel, inlined, kernel
from ..elementary import arctangent
from ..vectors import Vec3, add, cross, divide, dot, length, point_at, scale, subtract
from .merge_tree import MergeTree, merge_tree


class EquilibriumArrays(NamedTuple):
    """What the geometry of a body at rest says, before any estimate."""

    stable: Index  # (S,) faces
    basin: Index  # (F,) position in `stable` that a face descends to
    target: Index  # (F, 2) toppling graph
    share: Array  # (F, 2)
    toppled: Array  # (F,) centroid solid angles carried down it, fractions of 4 pi
    tree: MergeTree


@entry_kernel
def find_equilibria(points: Fixed2, body: BodyArrays) -> EquilibriumArrays:
    """Find the equilibria of a convex body of radius 1 (sections 2.C, 4.B and 4.D)."""
    neighbour = neighbour_faces(body)
    parent = descend_faces(body, neighbour)
    while sink_unbarred_faces(body, neighbour, parent):
        pass
    stable, basin = basins(parent)
    target, share = toppling_graph(points, body, neighbour, parent)
    toppled = settle_probabilities(body.angle / body.angle.sum(), target, share)
    return EquilibriumArrays(
        stable, basin, target, share, toppled, merge_tree(body, stable, basin)
    )


@entry_kernel
def settle_on_stable(initial: Fixed1, target: FixedIndex2, share: Fixed2) -> Array:
    """`settle_probabilities` for callers outside the kernels."""
    return settle_probabilities(initial, target, share)


@entry_kernel
def perturbed_shares(
    body: BodyArrays, surface: FixedIndex1, moved_share: float
) -> Array:
    """Solid angles (F,) over their sum, after strips along all sides changed hands.

    A side moves towards the face of the smaller surface; see `published.pqse`.
    `surface` (F,): a number from 0 to F - 1 for each face, equal for those of one
    surface.
    """
    faces = surface.shape[0]
    area = np.zeros(faces)  # of surfaces
    for face in range(faces):
        area[surface[face]] += body.area[face]
    mean_area = area.sum() / np.count_nonzero(area)
    angle_share = body.angle / body.angle.sum()
    flow = np.zeros(body.face.shape[0])  # to the face of a side, over it
    outflow = np.zeros(faces)
    for side in range(flow.shape[0]):
        giving_face = body.face[body.twin[side]]
        excess = area[surface[body.face[side]]] - area[surface[giving_face]]
        if excess > 0.0:
            reach = body.reach[side]
            arc = arctangent(body.start[side], reach) + arctangent(
                body.stop[side], reach
            )
            flow[side] = moved_share * arc / (4.0 * math.pi) * (excess / mean_area)
            outflow[giving_face] += flow[side]
    net_share = angle_share.copy()
    for side in range(flow.shape[0]):
        giving_face = body.face[body.twin[side]]
        if outflow[giving_face] > angle_share[giving_face]:
            flow[side] *= angle_share[giving_face] / outflow[giving_face]
        net_share[body.face[side]] += flow[side]
        net_share[giving_face] -= flow[side]
    return np.maximum(net_share, 0.0)


@kernel
def toppling_graph(
    points: Array, body: BodyArrays, neighbour: Index, parent: Index
) -> tuple[Index, Array]:
    """Targets and shares of the quasi-static toppling graph (section 4.B).

    An unstable face topples over the side pierced by the segment from its centroid to
    the foot of the centre of mass; where the segment leaves through a corner, both
    sides there take an even share.
    """
    faces = parent.shape[0]
    target = np.full((faces, 2), -1, np.int64)
    share = np.zeros((faces, 2))
    for f in range(faces):
        if parent[f] == f:
            continue
        _write_pierced_sides(points, body, neighbour, f, target)
        if target[f, 0] < 0:
            target[f, 0] = stable_face_below(parent, f)
        if target[f, 1] < 0:
            share[f, 0] = 1.0
        else:
            share[f, 0] = share[f, 1] = 0.5
    return target, share


@inlined
def _write_pierced_sides(
    points: Array, body: BodyArrays, neighbour: Index, f: int, target: Index
) -> None:
    """Find the side that the segment from centroid to foot leaves through."""
    corner = body.corner
    distance = body.distance
    inset = body.inset
    begin = body.face_start[f]
    end = body.face_start[f + 1]
    normal = point_at(body.normal, f)
    centroid = polygon_centroid(points, corner, begin, end, normal)
    first_crossing = math.inf
    exit_side = -1
    for k in range(begin, end):
        if inset[k] > TIP_MARGIN:
            continue
        w = corner[k + 1 if k + 1 < end else begin]
        centroid_inset = _inset_of(
            centroid, normal, point_at(points, corner[k]), point_at(points, w)
        )
        if centroid_inset <= inset[k]:
            continue
        crossing = centroid_inset / (centroid_inset - inset[k])
        if crossing < first_crossing and is_lower(distance, neighbour[k], f):
            first_crossing = crossing
            exit_side = k
    if exit_side < 0:
        return
    target[f, 0] = neighbour[exit_side]
    next_side = exit_side + 1 if exit_side + 1 < end else begin
    previous_side = exit_side - 1 if exit_side > begin else end - 1
    to_foot = subtract(scale(normal, distance[f]), centroid)
    at_end = subtract(point_at(points, corner[next_side]), centroid)
    at_start = subtract(point_at(points, corner[exit_side]), centroid)
    if _line_distance(at_end, to_foot, normal) < SAME_EDGE:
        shared_side = next_side
    elif _line_distance(at_start, to_foot, normal) < SAME_EDGE:
        shared_side = previous_side
    else:
        return
    second_face = neighbour[shared_side]
    if is_lower(distance, second_face, f):
        target[f, 1] = second_face


@inlined
def _line_distance(point: Vec3, line: Vec3, normal: Vec3) -> float:
    """Distance of a place in a plane from the line through the origin there."""
    return abs(dot(normal, cross(line, point))) / length(line)


@inlined
def polygon_centroid(
    points: Array, corner: Index, begin: int, end: int, normal: Vec3
) -> Vec3:
    """Centroid of the area of the face with the corners `corner[begin:end]`."""
    p = point_at(points, corner[begin])
    total = 0.0
    moment = Vec3(0.0, 0.0, 0.0)
    for k in range(begin + 1, end - 1):
        a = subtract(point_at(points, corner[k]), p)
        b = subtract(point_at(points, corner[k + 1]), p)
        weight = dot(normal, cross(a, b))
        total += weight
        moment = add(moment, scale(add(a, b), weight))
    return add(p, divide(moment, 3.0 * total))


@inlined
def _inset_of(point: Vec3, normal: Vec3, v: Vec3, w: Vec3) -> float:
    """Distance of a place on a face from its side from v to w, inside positive."""
    side = subtract(w, v)
    return dot(subtract(point, v), cross(normal, side)) / length(side)


@kernel
def settle_probabilities(initial: Array, target: Index, share: Array) -> Array:
    """Carry initial probabilities (F,) of all faces down the toppling graph."""
    faces = initial.shape[0]
    mass = initial.copy()
    giver_count = np.zeros(faces, np.int64)
    for f in range(faces):
        for j in range(2):
            if target[f, j] >= 0:
                giver_count[target[f, j]] += 1
    ready = np.empty(faces, np.int64)
    size = 0
    for f in range(faces):
        if giver_count[f] == 0:
            ready[size] = f
            size += 1
    while size > 0:
        size -= 1
        f = ready[size]
        if target[f, 0] < 0:
            continue
        for j in range(2):
            g = target[f, j]
            if g >= 0:
                mass[g] += share[f, j] * mass[f]
                giver_count[g] -= 1
                if giver_count[g] == 0:
                    ready[size] = g
                    size += 1
        mass[f] = 0.0
    return mass
