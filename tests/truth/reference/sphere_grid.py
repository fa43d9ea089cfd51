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

"""EAE and MEAE by flooding a fine grid on the sphere of poses, written from the paper
alone.

r(u) and R(u) are evaluated at some 100 000 nearly evenly spread directions from the
hull's planes and vertices (section 2.C). The grid is flooded from low to high with a
union-find; where two components meet that both hold a stable face, the reachable set
splits (section 4.D), and the areas of both at that level give the transition
probabilities (Eq. 8). Nothing is known here of edges, faces, saddles, cap formulas or
toppling.

Both functions have creases, where another plane or another vertex comes to rule. A grid
that straddles a crease is wrong by its spacing; therefore each grid edge whose ends
obey different planes or vertices gets a node where the two are equal. What is left is
of second order.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

from tests.truth.reference.toppling import distinct

POINTS = 100_003
SPACING = float(np.sqrt(4.0 * np.pi / POINTS))


@dataclass(frozen=True)
class Split:
    """A level at which a component of the reachable set falls in two."""

    level: float
    parts: tuple[frozenset[int], frozenset[int]]
    areas: tuple[float, float]


@dataclass(frozen=True)
class Flood:
    """Stable directions (S, 3), the splits from the top down, and the probabilities
    (S,).
    """

    stable: np.ndarray
    splits: tuple[Split, ...]
    probability: np.ndarray

    @property
    def smallest_component(self) -> float:
        """Smallest solid angle of a component just before it splits off, steradians."""
        return min(min(split.areas) for split in self.splits)


@lru_cache(maxsize=1)
def sphere_grid(count=POINTS):
    """Fibonacci points (count, 3) and the triangles of their hull (T, 3)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z * z)
    points = np.column_stack((ring * np.cos(turn), ring * np.sin(turn), z))
    return points, ConvexHull(points).simplices.astype(np.int64)


class Shape:
    """A convex hull about its centre of mass, as planes and vertices."""

    def __init__(self, vertices, center_of_mass):
        points = np.asarray(vertices, dtype=float) - center_of_mass
        hull = ConvexHull(points)
        self.vertices = points[hull.vertices]
        first = distinct(hull.equations)
        self.normals = hull.equations[first, :3]
        self.distances = -hull.equations[first, 3]

    def r(self, directions):
        """Distance to the surface: the nearest plane along the ray."""
        return 1.0 / (directions @ (self.normals / self.distances[:, None]).T).max(
            axis=-1
        )

    def R(self, directions):
        """Height of the centre of mass: the deepest vertex."""
        return (directions @ self.vertices.T).max(axis=-1)

    def stable(self):
        """Normals (S, 3) of the faces whose own plane the foot of the centre of mass
        lies on.
        """
        return self.normals[self.r(self.normals) >= self.distances * (1.0 - 1e-9)]

    def clearance(self):
        """Smallest angle between a stable face's foot and a boundary of the face,
        radians.
        """
        rows = self.rows("r")
        angle = np.inf
        for normal in self.stable():
            foot = normal * self.r(normal)
            distance = np.linalg.norm(np.cross(rows, normal), axis=1)
            others = distance > 1e-9 * np.linalg.norm(rows, axis=1)
            gap = (1.0 - rows[others] @ foot) / distance[others]
            angle = min(angle, np.arctan2(gap.min(), self.r(normal)))
        return float(angle)

    def rows(self, function):
        """Vectors w with R(u) = max w·u, or 1/r(u) = max w·u."""
        return (
            self.vertices if function == "R" else self.normals / self.distances[:, None]
        )


def creased_grid(rows):
    """The grid with a node wherever a grid edge crosses a crease of max w·u."""
    points, triangles = sphere_grid()
    ruler = (points @ rows.T).argmax(axis=1)
    across = triangles[(ruler[triangles] != ruler[triangles[:, :1]]).any(axis=1)]
    whole = triangles[(ruler[triangles] == ruler[triangles[:, :1]]).all(axis=1)]
    # First corner: the one that differs from the two others (any one if all differ).
    a, b, c = ruler[across].T
    start = np.where(b == c, 0, np.where(a == c, 1, np.where(a == b, 2, 0)))
    across = np.take_along_axis(across, (start[:, None] + np.arange(3)) % 3, axis=1)
    edges = np.sort(across[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, index = np.unique(edges, axis=0, return_inverse=True)
    crossed = ruler[edges[:, 0]] != ruler[edges[:, 1]]
    p, q = points[edges].transpose(1, 0, 2)
    gap = rows[ruler[edges[:, 0]]] - rows[ruler[edges[:, 1]]]
    gap_at_p = (gap * p).sum(axis=1)
    gap_at_q = (gap * q).sum(axis=1)
    share = np.where(
        crossed, gap_at_p / np.where(crossed, gap_at_p - gap_at_q, 1.0), 0.5
    )[:, None]
    new = (1.0 - share) * p + share * q
    number = len(points) + np.cumsum(crossed) - 1
    grid = np.vstack(
        (points, new[crossed] / np.linalg.norm(new[crossed], axis=1)[:, None])
    )
    ab, bc, ca = number[index.reshape(-1, 3)].T
    a, b, c = across.T
    three = crossed[index.reshape(-1, 3)].all(axis=1)
    two = ~three
    cut = [
        np.column_stack((a, ab, ca)),
        np.column_stack((ab, b, c))[two],
        np.column_stack((ab, c, ca))[two],
        np.column_stack((b, bc, ab))[three],
        np.column_stack((c, ca, bc))[three],
        np.column_stack((ab, bc, ca))[three],
    ]
    return grid, np.vstack((whole, *cut))


def areas_below(shape, function, levels):
    """Solid angles of {function < level} by plane (r) or vertex (R), a row a level."""
    rows = shape.rows(function)
    points, triangles, height = _heights(rows, function)
    ruler = (points[triangles].mean(axis=1) @ rows.T).argmax(axis=1)
    angles = _SolidAngles(points, height, triangles)
    return [np.bincount(ruler, angles.below(level), len(rows)) for level in levels]


def _heights(rows, function):
    points, triangles = creased_grid(rows)
    height = (points @ rows.T).max(axis=1)
    return points, triangles, 1.0 / height if function == "r" else height


def flood(shape, function):
    """Flood the grid from low to high, by 'r' or 'R'."""
    points, triangles, height = _heights(shape.rows(function), function)
    root, minima, passes = _catchments(height, triangles)
    stable = shape.stable()
    nearest = cKDTree(points).query(stable)[1]
    leaf_of = dict(zip(root[nearest].tolist(), range(len(stable)), strict=True))
    assert len(leaf_of) == len(stable), "the grid is too coarse for this body"
    leaf, merges = _joined(minima, passes, leaf_of)
    label = np.full(len(points), -1)
    label[list(leaf)] = list(leaf.values())
    owner = label[
        root[triangles[np.arange(len(triangles)), height[triangles].argmin(axis=1)]]
    ]
    angles = _SolidAngles(points, height, triangles)
    splits = []
    for level, first, second in reversed(merges):
        area = np.bincount(owner, angles.below(level), len(stable))
        splits.append(
            Split(
                level,
                (first, second),
                (area[list(first)].sum(), area[list(second)].sum()),
            )
        )
    return Flood(stable, tuple(splits), _probabilities(len(stable), splits))


def _catchments(height, triangles):
    """Local minimum that each node runs down to, all minima, and the passes between
    them.
    """
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges = edges[np.flatnonzero(np.diff(edges @ [len(height), 1], prepend=-1))]
    order = np.argsort(height, kind="stable")
    rank = np.argsort(order)
    lowest = rank.copy()
    for start, end in (edges.T, edges.T[::-1]):
        np.minimum.at(lowest, start, rank[end])
    root = order[lowest]
    while not np.array_equal(root, root[root]):
        root = root[root]
    ends = np.sort(root[edges], axis=1)
    level = height[edges].max(axis=1)
    crossing = ends[:, 0] != ends[:, 1]
    ends = ends[crossing]
    level = level[crossing]
    first = np.lexsort((level, ends[:, 1], ends[:, 0]))
    ends = ends[first]
    level = level[first]
    new = np.append(True, (np.diff(ends, axis=0) != 0).any(axis=1))
    ends = ends[new]
    level = level[new]
    by_level = np.argsort(level, kind="stable")
    passes = [(float(level[k]), *ends[k].tolist()) for k in by_level]
    return root, np.unique(root).tolist(), passes


def _joined(minima, passes, leaf_of):
    """Union-find over the minima: leaf that each belongs to, and the merges of
    leaves.
    """
    link = {m: m for m in minima}
    members = {m: {m} for m in minima}
    leaves = {
        m: frozenset([leaf_of[m]]) if m in leaf_of else frozenset() for m in minima
    }
    leaf = dict(leaf_of)
    merges = []

    def find(m):
        while link[m] != m:
            m = link[m]
        return m

    for level, a, b in passes:
        first = find(a)
        second = find(b)
        if first == second:
            continue
        if leaves[first] and leaves[second]:
            merges.append((level, leaves[first], leaves[second]))
        for whole, empty, touch in ((first, second, a), (second, first, b)):
            if leaves[whole] and not leaves[empty]:
                leaf.update(dict.fromkeys(members[empty], leaf[touch]))
        link[second] = first
        members[first] |= members.pop(second)
        leaves[first] |= leaves[second]
    return leaf, merges


class _SolidAngles:
    """Solid angle of {height < level} in each triangle, by linear interpolation."""

    def __init__(self, points, height, triangles):
        a, b, c = (points[triangles[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        self.area = area * (4.0 * np.pi / area.sum())
        self.ends = np.sort(height[triangles], axis=1).T.copy()

    def below(self, level):
        low, middle, high = self.ends
        angle = np.where(high <= level, self.area, 0.0)
        cut = np.flatnonzero((low < level) & (level < high))
        low, middle, high = self.ends[:, cut]
        with np.errstate(divide="ignore", invalid="ignore"):
            tip = (level - low) ** 2 / ((middle - low) * (high - low))
            rest = 1.0 - (high - level) ** 2 / ((high - middle) * (high - low))
        angle[cut] = self.area[cut] * np.where(level < middle, tip, rest)
        return angle


def _probabilities(count, splits):
    """Down the tree from the top (Eq. 8)."""
    reach = {frozenset(range(count)): 1.0}
    for split in splits:
        joined = reach[split.parts[0] | split.parts[1]]
        for part, area in zip(split.parts, split.areas, strict=True):
            reach[part] = joined * area / sum(split.areas)
    return np.array([reach[frozenset([k])] for k in range(count)])
