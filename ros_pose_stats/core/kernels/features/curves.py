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

"""Curves that lead to the poses of a body, and how far they lie across.

Rocking is a turn about the generators of a curve. It lasts, since narrow facets take
little of its energy and nothing turns it about another axis: a part does not lie down
where they stand on end. Curves of a full turn do not count there; no blow makes a part
turn about their axis.
"""

import math
from typing import NamedTuple

import numpy as np

from ..array_types import Array, Fixed2, FixedFlags1, FixedIndex1
from ..body.convex_body import BodyArrays
from ..compilation import entry_kernel, kernel
from ..vectors import (
    Vec3,
    add,
    cross,
    divide,
    dot,
    length,
    point_at,
    subtract,
    transform,
)

LARGEST_BEND = 0.4
"""Radians to a neighbour, from which on both are no facets of one curve."""

TINY = 1e-12  # a share, angle or weight that is as good as none


class Sides(NamedTuple):
    """What the sides (N,) of a body's faces have of curves."""

    curve: Array  # how much the two faces are facets of a curve that keeps energy
    smooth_length: Array  # length, less where the faces turn much
    lever: Array  # share of the lever in the inertia about the side


@entry_kernel
def curves(
    points: Fixed2,
    body: BodyArrays,
    inertia: Fixed2,
    on_full_turn: FixedFlags1,
    pose_of_face: FixedIndex1,
    lowest: FixedIndex1,
    downs: Fixed2,
) -> tuple[Array, Array]:
    """Share (P,) of curves in what leads to poses, and how far (P,) they lie across.

    `inertia` (3, 3): over mass and squared radius; `on_full_turn` (F,): faces of curves
    of a full turn; `lowest` (P,): faces that poses rest on; `downs` (P, 3).
    """
    sides = _measure_sides(points, body, inertia)
    poses = lowest.shape[0]
    largest = np.zeros(on_full_turn.shape[0])  # of faces on no full turn
    share = np.zeros(poses)
    angle = np.zeros(poses)
    for face in range(largest.shape[0]):
        curve = sides.curve[body.face_start[face] : body.face_start[face + 1]]
        pose = pose_of_face[face]
        angle[pose] += body.angle[face]
        if on_full_turn[face]:
            share[pose] += body.angle[face] * curve.min()
        else:
            largest[face] = curve.max()
            share[pose] += body.angle[face] * largest[face]
    tensors = np.zeros((poses, 3, 3))  # of the faces of each pose
    total = np.zeros((3, 3))
    for face in range(largest.shape[0]):
        pose = pose_of_face[face]
        if largest[face] > 0.0 and largest[lowest[pose]] > 0.0:
            factor = largest[lowest[pose]] * body.angle[face]
            _add_generators(tensors[pose], points, body, sides, face, factor)
    for pose in range(poses):
        total += tensors[pose]
    across = np.empty(poses)
    for pose in range(poses):
        crosswise = _crosswise(total - tensors[pose], point_at(downs, pose))
        across[pose] = crosswise / max(4.0 * math.pi - angle[pose], TINY)
        share[pose] /= angle[pose]
    return share, across


@kernel
def _measure_sides(points: Array, body: BodyArrays, inertia: Array) -> Sides:
    count = body.face.shape[0]
    sides = Sides(np.zeros(count), np.zeros(count), np.zeros(count))
    for face in range(body.area.shape[0]):
        middle = _middle(points, body, face)
        normal = point_at(body.normal, face)
        moment = cross(middle, normal)
        for side in range(body.face_start[face], body.face_start[face + 1]):
            neighbour = point_at(body.normal, body.face[body.twin[side]])
            turn = length(subtract(normal, neighbour))
            if turn >= LARGEST_BEND:
                continue
            smoothness = 1.0 - (turn / LARGEST_BEND) * (turn / LARGEST_BEND)
            edge = _edge(points, body, side)
            size = length(edge)
            edge = divide(edge, size)
            lever = dot(moment, edge) * dot(moment, edge)
            edge_inertia = dot(transform(inertia, edge), edge)
            contact = edge_inertia + body.distance[face] * body.distance[face] + lever
            half_width = 0.5 * body.area[face] / size
            kept = _kept_energy(contact, half_width, turn)
            sides.curve[side] = smoothness * kept
            sides.smooth_length[side] = smoothness * size
            sides.lever[side] = lever / (edge_inertia + lever)
    return sides


@kernel
def _middle(points: Array, body: BodyArrays, face: int) -> Vec3:
    """Mean of the corners of a face."""
    begin = body.face_start[face]
    end = body.face_start[face + 1]
    middle = Vec3(0.0, 0.0, 0.0)
    for side in range(begin, end):
        middle = add(middle, point_at(points, body.corner[side]))
    return divide(middle, float(end - begin))


@kernel
def _edge(points: Array, body: BodyArrays, side: int) -> Vec3:
    """From the first corner of a side to its last."""
    begin = point_at(points, body.corner[side])
    return subtract(point_at(points, body.corner[body.twin[side]]), begin)


@kernel
def _kept_energy(contact: float, half_width: float, turn: float) -> float:
    """Share of the energy that is left of a radian over facets like this one.

    Each facet takes what a slam on a flat of its width takes.
    """
    square = half_width * half_width
    kept = max((contact - square) / (contact + square), TINY)
    return float(kept ** (2.0 / max(turn, TINY)))


@kernel
def _add_generators(
    tensor: Array,
    points: Array,
    body: BodyArrays,
    sides: Sides,
    face: int,
    factor: float,
) -> None:
    """Add the directions of a face's generators, by how much a part rocks on them."""
    begin = body.face_start[face]
    end = body.face_start[face + 1]
    factor /= max(sides.smooth_length[begin:end].sum(), TINY)
    for side in range(begin, end):
        edge = _edge(points, body, side)
        edge = divide(edge, length(edge))
        weight = factor * sides.smooth_length[side] * sides.curve[side]
        weight *= math.sqrt(sides.lever[side])
        for row in range(3):
            for column in range(3):
                tensor[row, column] += weight * edge[row] * edge[column]


@kernel
def _crosswise(tensor: Array, down: Vec3) -> float:
    """How far generators lie across a direction, where they are parallel."""
    trace = max(tensor[0, 0] + tensor[1, 1] + tensor[2, 2], TINY)
    image = transform(tensor, transform(tensor, transform(tensor, down)))
    return dot(down, image) / (trace * trace)
