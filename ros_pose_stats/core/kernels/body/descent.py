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

"""Which faces are stable, and which stable face each of the others descends to.

A part standing on a face topples over a side when the foot of its centre of mass lies
beyond it (inset < 0); the neighbour's plane is then closer to the centre of mass. Every
rule below goes to a lower face only, ties by number, so that no walk can return.
"""

import math

import numpy as np

from ...tolerances import TIP_MARGIN
from ..array_types import Array, Index
from ..compilation import inlined, kernel
from .convex_body import BodyArrays


@inlined
def side_level(body: BodyArrays, k: int) -> float:
    """Smallest distance of a polygon side (a segment) from the origin.

    No smaller than the line's distance seen from either face, though corners may lie
    off their planes.
    """
    twin = body.twin[k]
    level = max(body.reach[k], body.reach[twin])
    if body.start[k] > 0.0 and body.stop[k] > 0.0:
        return float(level)
    return float(
        max(level, min(body.radius[body.corner[k]], body.radius[body.corner[twin]]))
    )


@inlined
def is_lower(distance: Array, g: int, f: int) -> bool:
    """Face g lies below face f in the order of distances."""
    if distance[g] == distance[f]:
        return g < f
    return bool(distance[g] < distance[f])


@kernel
def neighbour_faces(body: BodyArrays) -> Index:
    """Face (N,) on the other side of each polygon side."""
    face = body.face
    twin = body.twin
    neighbour = np.empty(twin.shape[0], np.int64)
    for k in range(twin.shape[0]):
        neighbour[k] = face[twin[k]]
    return neighbour


@kernel
def descend_faces(body: BodyArrays, neighbour: Index) -> Index:
    """Neighbour that each face joins when flooded from below; itself where stable.

    Taken is the side nearest to the foot among those that the foot lies beyond: the
    level {r < E} of the face first touches that side, and {R < E} flows over it as
    well, so the basins found by following these steps serve both functions.
    """
    face_start = body.face_start
    inset = body.inset
    distance = body.distance
    faces = distance.shape[0]
    parent = np.arange(faces)
    for f in range(faces):
        best_level = math.inf
        best_inset = math.inf
        shallowest = math.inf
        lowest = f
        for k in range(face_start[f], face_start[f + 1]):
            shallowest = min(shallowest, inset[k])
            candidate = neighbour[k]
            if not is_lower(distance, candidate, f):
                continue
            if is_lower(distance, candidate, lowest):
                lowest = candidate
            if inset[k] > TIP_MARGIN:
                continue
            level = side_level(body, k)
            if level < best_level or (level == best_level and inset[k] < best_inset):
                best_level = level
                best_inset = inset[k]
                parent[f] = candidate
        # Rounding only: beyond a side, but the neighbour there is no lower.
        if shallowest <= TIP_MARGIN and parent[f] == f:
            parent[f] = lowest
    return parent


@kernel
def basins(parent: Index) -> tuple[Index, Index]:
    """Stable faces, and for each face the position of the one that it descends to."""
    faces = parent.shape[0]
    basin = np.full(faces, -1, np.int64)
    stable = np.empty(faces, np.int64)
    count = 0
    for f in range(faces):
        if parent[f] == f:
            stable[count] = f
            basin[f] = count
            count += 1
    for f in range(faces):
        bottom = f
        while basin[bottom] < 0:
            bottom = parent[bottom]
        position = basin[bottom]
        face = f
        while basin[face] < 0:
            basin[face] = position
            face = parent[face]
    return stable[:count].copy(), basin


@kernel
def sink_unbarred_faces(body: BodyArrays, neighbour: Index, parent: Index) -> bool:
    """Let stable faces without a barrier descend further; tell whether any did.

    Among faces that are coplanar but for rounding, one can be the lowest of its
    neighbours and still have its foot outside. Each such step leaves one stable face
    less.
    """
    stable, basin = basins(parent)
    face_start = body.face_start
    face = body.face
    inset = body.inset
    distance = body.distance
    exit_level = np.full(stable.shape[0], math.inf)
    exit_side = np.full(stable.shape[0], -1, np.int64)
    for k in range(face.shape[0]):
        home = basin[face[k]]
        if home == basin[neighbour[k]]:
            continue
        level = side_level(body, k)
        if level < exit_level[home]:
            exit_level[home] = level
            exit_side[home] = k
    has_moved = False
    for i in range(stable.shape[0]):
        f = stable[i]
        target = -1
        if exit_level[i] <= distance[f]:
            target = neighbour[exit_side[i]]
        for k in range(face_start[f], face_start[f + 1]):
            if inset[k] <= 0.0 and basin[neighbour[k]] != i:
                target = neighbour[k]
        if target >= 0 and stable_face_below(parent, target) != f:
            parent[f] = target
            has_moved = True
    return has_moved


@kernel
def stable_face_below(parent: Index, f: int) -> int:
    """Stable face that a face descends to."""
    while parent[f] != f:
        f = parent[f]
    return f
