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

"""Stable faces of a hull and poses by persistence, read word for word from the
contract.

From each stable face the lowest ways are flooded until a face that comes before it is
met: the highest saddle on the way is where the face ends. If that is no share of its
height above it, it is poured into the pose across that saddle. There is neither a tree
nor a union-find.

Rounding orders nothing here: values closer than `tie` are equal, all others must be
farther apart than `distinct`, and levels and heights are compared by their ranks.
"""

import heapq
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree


def ranks(values, tie, gap):
    """Number (N,) of each value by rising size; equal ones share it."""
    order = np.argsort(values, kind="stable")
    gaps = np.diff(np.asarray(values)[order])
    doubtful = gaps[(gaps > tie) & (gaps < gap)]
    assert not len(doubtful), (
        f"values {doubtful.min():g} apart are neither equal (up to {tie:g}) nor "
        f"different (from {gap:g} on): give another body, or tolerances that fit its "
        "rounding"
    )
    numbers = np.empty(len(order), dtype=int)
    numbers[order] = np.concatenate(([0], np.cumsum(gaps > tie)))
    return numbers


@dataclass(frozen=True)
class StableFaces:
    """Stable faces in a given numbering; lengths in radii of the part."""

    heights: np.ndarray  # (S,)
    order: (
        np.ndarray
    )  # (S,) which stands for a pose: lower, then larger, then smaller number
    ways: dict  # face -> list of (rank of the level, level, face on the other side)


def stable_faces(vertices, center_of_mass, downs, tie=1e-10, distinct=1e-8, flat=1e-9):
    """Stable faces of a convex hull, numbered as `downs` (S, 3), their normals, are.

    One too many or too few is an error. Triangles as close as `flat` to one plane are
    one face.
    """
    points = np.asarray(vertices, dtype=float) - center_of_mass
    points /= np.sqrt((points * points).sum(axis=1)).max()
    normals, distances, areas, edges = _faces(points, flat)
    inset, levels = _sides(points, normals, distances, edges)
    levels_rank = ranks(levels, tie, distinct)
    lowest = np.full(len(normals), np.inf)
    np.minimum.at(lowest, edges[:, 2], np.where(inset[:, 0] > 0.0, np.inf, levels))
    np.minimum.at(lowest, edges[:, 3], np.where(inset[:, 1] > 0.0, np.inf, levels))
    stable = np.flatnonzero(np.isinf(lowest))
    assert len(stable) == len(downs), (
        f"{len(stable)} stable faces here, {len(downs)} given"
    )
    gap, number = cKDTree(downs).query(normals[stable])
    assert gap.max() < 1e-6 and len(set(number.tolist())) == len(stable)
    number_of = np.full(len(normals), -1)
    number_of[stable] = number
    beyond = _descents(edges, levels_rank, inset, distances, number_of)
    ways = defaultdict(list)
    for (_, _, feature, neighbour), rank, level in zip(
        edges.tolist(), levels_rank.tolist(), levels.tolist(), strict=True
    ):
        foot = beyond[feature]
        neighbour_foot = beyond[neighbour]
        if foot != neighbour_foot:
            ways[foot].append((rank, level, neighbour_foot))
            ways[neighbour_foot].append((rank, level, foot))
    heights = np.empty(len(stable))
    sizes = np.empty(len(stable))
    heights[number] = distances[stable]
    sizes[number] = areas[stable]
    order = np.lexsort(
        (
            np.arange(len(stable)),
            -ranks(sizes, tie, distinct),
            ranks(heights, tie, distinct),
        )
    )
    return StableFaces(heights, np.argsort(order), ways)


def _faces(points, flat):
    """Normals, distances and areas of faces; pieces of edges: two ends, left and right
    face.
    """
    hull = ConvexHull(points)
    triangles = hull.simplices.copy()
    corners = points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = (across * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[inward, 1:] = triangles[inward, :0:-1]
    across[inward] *= -1.0
    owner_face = np.repeat(np.arange(len(triangles)), 3)
    neighbour = hull.neighbors.ravel()
    planes = hull.equations
    distance = np.abs(
        np.einsum("nkx,nx->nk", points[triangles[neighbour]], planes[owner_face, :3])
        + planes[owner_face, 3:]
    ).max(axis=1)
    joined = distance < flat
    _, face = connected_components(
        coo_array(
            (np.ones(joined.sum()), (owner_face[joined], neighbour[joined])),
            shape=2 * (len(triangles),),
        )
    )
    vector = np.zeros((face.max() + 1, 3))
    np.add.at(vector, face, 0.5 * across)
    areas = np.sqrt((vector * vector).sum(axis=1))
    normals = vector / areas[:, None]
    weight = np.sqrt((across * across).sum(axis=1))
    heights = (points[triangles].mean(axis=1) * normals[face]).sum(axis=1)
    distances = np.bincount(face, weight * heights) / np.bincount(face, weight)
    owner = {
        (int(a), int(b)): int(face[t])
        for t, (p, q, r) in enumerate(triangles)
        for a, b in ((p, q), (q, r), (r, p))
    }
    edges = [
        (a, b, face_beside, owner[b, a])
        for (a, b), face_beside in owner.items()
        if a < b and face_beside != owner[b, a]
    ]
    return normals, distances, areas, np.array(edges)


def _sides(points, normals, distances, edges):
    """How far the feet on both faces lie inside of each edge, and its distance from the
    centre.
    """
    first = points[edges[:, 0]]
    along = points[edges[:, 1]] - points[edges[:, 0]]
    length = np.sqrt((along * along).sum(axis=1))
    inset = np.empty((len(edges), 2))
    for side, sign in ((0, 1.0), (1, -1.0)):
        face = edges[:, 2 + side]
        inward = np.cross(normals[face], sign * along) / length[:, None]
        inset[:, side] = ((distances[face, None] * normals[face] - first) * inward).sum(
            axis=1
        )
    share = np.clip(-(first * along).sum(axis=1) / length**2, 0.0, 1.0)
    nearest = first + share[:, None] * along
    levels = np.sqrt((nearest * nearest).sum(axis=1))
    return inset, np.maximum(levels, distances[edges[:, 2:]].max(axis=1))


def _descents(edges, rank, inset, distances, number_of):
    """Stable face that the way down from each face leads to: over its lowest edge, and
    so on.
    """
    down = {}
    for (_, _, first, neighbour), level, (foot, neighbour_foot) in zip(
        edges.tolist(), rank.tolist(), inset.tolist(), strict=True
    ):
        for face, beyond, depth in (
            (first, neighbour, foot),
            (neighbour, first, neighbour_foot),
        ):
            if number_of[face] < 0 and depth <= 0.0:
                down.setdefault(face, []).append((level, depth, beyond))
    ends = []
    for face in range(len(number_of)):
        end = face
        while number_of[end] < 0:
            onward = min(down[end])[2]
            assert distances[onward] < distances[end], "no way down from a face"
            end = onward
        ends.append(int(number_of[end]))
    return ends


def persistent_poses(faces, tolerance):
    """Poses as sets of stable faces -> level (radii) of the lowest saddle out of
    each.
    """
    onward = {}
    for face, height in enumerate(faces.heights):
        level, across = _end(faces, face)
        assert abs(level - (1.0 + tolerance) * height) > 1e-9, (
            "a rise is just the tolerance"
        )
        if level < (1.0 + tolerance) * height:
            onward[face] = across
    poses = defaultdict(set)
    for face in range(len(faces.heights)):
        path = [face]
        while path[-1] in onward:
            path.append(onward[path[-1]])
            assert len(path) <= len(faces.heights), (
                f"faces are poured in a ring: {path}"
            )
        poses[path[-1]].add(face)
    return {
        frozenset(members): min(
            (
                level
                for face in members
                for _, level, neighbour in faces.ways[face]
                if neighbour not in members
            ),
            default=np.inf,
        )
        for members in poses.values()
    }


def _end(faces, start):
    """Level at which a flood from a face meets one before it, and the face across that
    saddle.
    """
    flooded = set()
    highest = -1
    level = -np.inf
    waiting = [(-1, -np.inf, start)]
    while waiting:
        rank, height, face = heapq.heappop(waiting)
        if face in flooded:
            continue
        if rank > highest:
            highest = rank
            level = height
        if faces.order[face] < faces.order[start]:
            return level, _across(faces, start, highest)
        flooded.add(face)
        for passage in faces.ways[face]:
            heapq.heappush(waiting, passage)
    return np.inf, None


def _across(faces, start, rank):
    """The first of all faces across the saddles of this rank that end the region of a
    face.

    Regions beyond them that begin no lower are its own: they end here as well.
    """
    region = _below(faces, start, rank)
    while True:
        beyond = {
            neighbour
            for face in region
            for height, _, neighbour in faces.ways[face]
            if height == rank and neighbour not in region
        }
        younger = {face: _below(faces, face, rank) for face in beyond}
        elder = [
            face
            for face, reached in younger.items()
            if min(faces.order[list(reached)]) < faces.order[start]
        ]
        if elder:
            return min(elder, key=lambda face: faces.order[face])
        region = region.union(*younger.values())


def _below(faces, start, rank):
    """Faces that a flood from one reaches below a level."""
    reached = {start}
    waiting = [start]
    while waiting:
        for height, _, neighbour in faces.ways[waiting.pop()]:
            if height < rank and neighbour not in reached:
                reached.add(neighbour)
                waiting.append(neighbour)
    return reached
