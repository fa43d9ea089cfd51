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

"""Corner loops of the planar faces.

A hull vertex is a corner where at least three faces meet; a vertex between two faces
lies on a straight edge and is dropped, so that subdividing a mesh changes nothing.
"""

import numpy as np

from ..array_types import Flags, Index
from ..compilation import inlined, kernel


@inlined
def next_on_boundary(h: int, boundary: Flags, opposite: Index) -> int:
    """The boundary half-edge of the same region that starts where half-edge h ends."""
    h = next_half_edge(h)
    for _ in range(opposite.shape[0]):
        if boundary[h]:
            return h
        h = next_half_edge(opposite[h])
    return -1


@inlined
def next_half_edge(h: int) -> int:
    """Next half-edge of the same triangle."""
    return h + 1 if h % 3 < 2 else h - 2


@kernel
def corner_loops(
    triangles: Index, region: Index, opposite: Index, points: int
) -> tuple[bool, Index, Index, Index]:
    """Walk each region's boundary once and keep its corners.

    False where a region is no disc or has fewer than three corners; then where the loop
    of each face begins, the first half-edge of each polygon side, and the side of each
    boundary half-edge, -1 of others. `opposite`: twin of each half-edge.
    """
    faces = region.max() + 1
    halves = opposite.shape[0]
    if opposite.min() < 0:
        return (
            False,
            np.zeros(1, np.int64),
            np.zeros(0, np.int64),
            np.zeros(0, np.int64),
        )
    boundary, border, is_corner, entry = _find_boundaries(
        triangles, region, opposite, points
    )
    face_start = np.zeros(faces + 1, np.int64)
    first = np.empty(border.sum(), np.int64)
    side_of = np.full(halves, -1, np.int64)
    size = 0
    for f in range(faces):
        h = entry[f]
        walked = 0
        corners = 0
        while h >= 0 and walked < border[f]:
            if is_corner[h]:
                first[size] = h
                size += 1
                corners += 1
            side_of[h] = size - 1
            walked += 1
            h = next_on_boundary(h, boundary, opposite)
            if h == entry[f]:
                break
        if walked != border[f] or h != entry[f] or corners < 3:
            return False, face_start, first, side_of
        face_start[f + 1] = size
    return _order_loops(triangles, face_start, first[:size], side_of, points)


@kernel
def _find_boundaries(
    triangles: Index, region: Index, opposite: Index, points: int
) -> tuple[Flags, Index, Flags, Index]:
    """Half-edges between regions, how many each has, those from corners, one each."""
    halves = opposite.shape[0]
    faces = region.max() + 1
    degree = np.zeros(points, np.int64)
    border = np.zeros(faces, np.int64)
    origin = np.empty(halves, np.int32)
    boundary = np.empty(halves, np.bool_)
    for t in range(triangles.shape[0]):
        for i in range(3):
            h = 3 * t + i
            origin[h] = triangles[t, i + 1 if i < 2 else 0]
            boundary[h] = region[t] != region[opposite[h] // 3]
            if boundary[h]:
                degree[origin[h]] += 1
                border[region[t]] += 1
    is_corner = np.empty(halves, np.bool_)
    entry = np.full(faces, -1, np.int64)
    for h in range(halves):
        is_corner[h] = boundary[h] and degree[origin[h]] >= 3
        if is_corner[h]:
            entry[region[h // 3]] = h
    return boundary, border, is_corner, entry


@kernel
def _order_loops(
    triangles: Index, face_start: Index, first: Index, side_of: Index, points: int
) -> tuple[bool, Index, Index, Index]:
    """Begin each loop at its smallest corner; order loops by their first two.

    What comes later then depends on the faces alone, not on how the hull was cut into
    triangles.
    """
    faces = face_start.shape[0] - 1
    begin = np.empty(faces, np.int64)
    second = np.empty(faces, np.int64)
    offset = np.zeros(points + 1, np.int64)
    for f in range(faces):
        low = face_start[f]
        for k in range(face_start[f], face_start[f + 1]):
            if _origin(triangles, first[k]) < _origin(triangles, first[low]):
                low = k
        begin[f] = low
        second[f] = _origin(
            triangles, first[low + 1 if low + 1 < face_start[f + 1] else face_start[f]]
        )
        offset[_origin(triangles, first[low]) + 1] += 1
    for v in range(points):
        offset[v + 1] += offset[v]
    order = np.empty(faces, np.int64)
    next_free = offset[:points].copy()
    for f in range(faces):
        v = _origin(triangles, first[begin[f]])
        k = next_free[v]
        next_free[v] += 1
        while k > offset[v] and second[order[k - 1]] > second[f]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = f
    starts = np.zeros(faces + 1, np.int64)
    sides = np.empty(first.shape[0], np.int64)
    renumbered = np.empty(first.shape[0], np.int64)
    size = 0
    for i in range(faces):
        f = order[i]
        k = begin[f]
        for _ in range(face_start[f], face_start[f + 1]):
            sides[size] = first[k]
            renumbered[k] = size
            size += 1
            k = k + 1 if k + 1 < face_start[f + 1] else face_start[f]
        starts[i + 1] = size
    for h in range(side_of.shape[0]):
        if side_of[h] >= 0:
            side_of[h] = renumbered[side_of[h]]
    return True, starts, sides, side_of


@inlined
def _origin(triangles: Index, h: int) -> int:
    """Hull point where half-edge h starts."""
    return int(triangles[h // 3, (h + 1) % 3])
