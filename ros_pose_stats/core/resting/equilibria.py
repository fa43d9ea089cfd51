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

"""Equilibria of a part on a horizontal plate (sections 2.B, 2.C), gathered into poses.

Stable faces are numbered by rising height, ties by the components of `down`; nothing
here depends on a method, a scene or a seed.

A pose is what a nudge leaves: a stable face is one of its own only if the centre of
mass has to rise by a share of its height to leave it; a shallower one belongs to the
pose that the part slips into (`gather_poses`).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..kernels.levels.equilibria import EquilibriumArrays, find_equilibria
from ..kernels.levels.merge_tree import gather_poses, part_poses
from ..kernels.sorting import number_ties
from ..records import Array, Index, Mask, Part
from ..tolerances import SAME_DOWN, SAME_HEIGHT, TIP_MARGIN
from .convex_body import ConvexBody, body_of, foot_directions


@dataclass(frozen=True, eq=False)
class Equilibria:
    """Stable, saddle and unstable equilibria of a convex body."""

    body: ConvexBody
    # From the kernel; `arrays.stable` is in the order of face numbers
    arrays: EquilibriumArrays
    # (S,); positions in `arrays.stable` by rising height: the numbering of the stable
    # faces
    order: Index

    @cached_property
    def faces(self) -> Index:
        """Face (S,) of each stable face, by rising height."""
        return self.arrays.stable[self.order]

    @cached_property
    def heights(self) -> Array:
        """Height (S,) of the centre of mass on each stable face, in radii."""
        return self.body.arrays.distance[self.faces]

    @cached_property
    def downs(self) -> Array:
        """Direction (S, 3) that points down on each stable face."""
        return self.body.arrays.normal[self.faces]

    @cached_property
    def rank(self) -> Index:
        """Number (S,) of each entry of `arrays.stable`: the inverse of `order`."""
        return np.argsort(self.order)

    @property
    def peaks(self) -> Array:
        """Corners (U, 3) at a maximum of r and R."""
        nearest_side = np.full(len(self.body.points), np.inf)
        np.minimum.at(nearest_side, self.body.arrays.corner, self.body.arrays.start)
        return np.asarray(
            self.body.points[np.isfinite(nearest_side) & (nearest_side > TIP_MARGIN)]
        )


def equilibria_of(part: Part, round_sides: int) -> Equilibria:
    """Equilibria of a part, found once and kept as long as the part lives."""
    return part.prepare(_find, round_sides)


def _find(part: Part, round_sides: int) -> Equilibria:
    body = body_of(part, round_sides)
    arrays = find_equilibria(body.points, body.arrays)
    group = group_ties(
        (body.arrays.distance[arrays.stable], SAME_HEIGHT),
        *((component, SAME_DOWN) for component in body.arrays.normal[arrays.stable].T),
    )
    return Equilibria(body, arrays, np.argsort(group, kind="stable"))


def group_ties(*keys: tuple[Array, float], groups: Index | None = None) -> Index:
    """Number ties (S,) by `groups`, then by rising values of keys with their tolerance.

    A tie holds all within the tolerance of its smallest value: a dense sequence is not
    one tie.
    """
    size = keys[0][0].shape[0]
    group = np.zeros(size, dtype=np.int64) if groups is None else groups
    count = 1 if groups is None else int(groups.max()) + 1
    for values, tolerance in keys:
        if count == size:  # no two values are tied any more
            break
        contiguous = np.ascontiguousarray(values)
        group, count = number_ties(
            contiguous, tolerance, group, np.lexsort((contiguous, group))
        )
    return group


RUN_TOLERANCE = 0.025
"""Least rise over the height that parts neighbouring facets of one round or toothed
surface."""


@dataclass(frozen=True, eq=False)
class Clusters:
    """The poses of a part as groups of stable faces."""

    # least rise of the centre of mass out of a pose, as a share of its height there
    tolerance: float
    # (P,); number of the stable face that stands for the pose, by rising height: its
    # lowest; ties go to the larger face, then to the smaller number
    lowest_face: Index
    # (S,); pose of each stable face, in the numbering of `Equilibria.order`
    pose: Index
    # (S,) bool; faces that the part rests on in its pose: no higher above the lowest
    # one than the tolerance. The others are shelves on the way there
    is_support: Mask
    # (P,); level of the lowest saddle from any member to any other pose, in radii;
    # infinite for a single pose
    exit_level: Array
    barrier: Array  # (P,); the same above the lowest member
    # (N,); largest nodes of the merge tree that hold a single pose. A pose may have
    # several, since a shelf may open only where its pose has others beside it already
    node: Index
    node_pose: Index  # (N,); that pose
    split: Mask  # (S - 1,) bool; whether a join of the merge tree holds several poses

    @property
    def run_tolerance(self) -> float:
        """The same between neighbouring facets of one run; 0 gathers nothing."""
        return run_tolerance_of(self.tolerance)

    def gather(self, probability: Array) -> Array:
        """Sum what the nodes of the merge tree (2 S - 1,) have over the poses (P,)."""
        sums = np.bincount(
            self.node_pose, probability[self.node], self.lowest_face.shape[0]
        )
        return sums.astype(np.float64)


def run_tolerance_of(tolerance: float) -> float:
    """Least rise over the height that parts neighbouring facets of one run."""
    return max(tolerance, RUN_TOLERANCE) if tolerance > 0.0 else 0.0


def gather_clusters(equilibria: Equilibria, tolerance: float) -> Clusters:
    """Gather stable faces into poses; tolerance 0 gathers nothing."""
    tree = equilibria.arrays.tree
    # Of several faces the lowest stands for all, then the largest, but for rounding.
    areas = equilibria.body.arrays.area[equilibria.faces]
    order = group_ties(
        (equilibria.heights, SAME_HEIGHT), (-areas / areas.max(), SAME_HEIGHT)
    )
    eldest, exit_level = gather_poses(
        equilibria.body.arrays,
        equilibria.rank[equilibria.arrays.basin],
        equilibria.heights,
        np.argsort(np.argsort(order, kind="stable")),
        equilibria.body.run_of_face[equilibria.faces],
        tolerance,
        run_tolerance_of(tolerance),
    )
    lowest_face, pose = np.unique(eldest, return_inverse=True)
    pose_of_node, split = part_poses(tree, np.ascontiguousarray(pose[equilibria.rank]))
    node = np.unique(np.append(tree.child[split], pose_of_node.shape[0] - 1))
    node = node[pose_of_node[node] >= 0]
    heights = equilibria.heights[lowest_face]
    is_support = equilibria.heights < (1.0 + tolerance) * heights[pose]
    is_support[lowest_face] = True
    return Clusters(
        tolerance,
        lowest_face,
        pose,
        is_support,
        exit_level[lowest_face],
        exit_level[lowest_face] - heights,
        node,
        pose_of_node[node],
        split,
    )


def tilt_margins(equilibria: Equilibria, clusters: Clusters) -> Array:
    """Smallest tilt (P,) that takes the part out of each pose, radians.

    A pose of several faces, within which the part rolls or slips first, ends with its
    basin.
    """
    arrays = equilibria.body.arrays
    pose_of_face = np.full(equilibria.body.faces, -1, dtype=np.int64)
    pose_of_face[equilibria.faces] = clusters.pose
    margins = np.full(clusters.lowest_face.shape[0], np.pi / 2.0)
    has_several_faces = np.bincount(clusters.pose) > 1
    face = arrays.face
    neighbour = arrays.face[arrays.twin]
    basin = equilibria.arrays.basin
    # A foot may be outside of a side by rounding, with a higher face beyond it that
    # comes back.
    sides = np.flatnonzero(
        (pose_of_face[face] >= 0)
        & (pose_of_face[neighbour] != pose_of_face[face])
        & ((arrays.inset > 0.0) | (basin[neighbour] != basin[face]))
    )
    faces = arrays.face[sides]
    is_single = ~has_several_faces[pose_of_face[faces]]
    tilts = np.arctan2(arrays.inset[sides], arrays.distance[faces])
    np.minimum.at(margins, pose_of_face[faces[is_single]], tilts[is_single])
    for pose in np.flatnonzero(has_several_faces).tolist():
        margins[pose] = min(np.pi / 2.0, _tilt_to_border(equilibria, clusters, pose))
    return margins


def _tilt_to_border(equilibria: Equilibria, clusters: Clusters, pose: int) -> float:
    """Smallest angle between a face the part rests on and a side of the basin's end."""
    arrays = equilibria.body.arrays
    in_basin = clusters.pose[equilibria.rank[equilibria.arrays.basin]] == pose
    sides = np.flatnonzero(in_basin[arrays.face] & ~in_basin[arrays.face[arrays.twin]])
    if not len(sides):
        return math.inf
    feet = foot_directions(equilibria.body, sides)
    support_downs = equilibria.downs[clusters.is_support & (clusters.pose == pose)]
    chord = float(cKDTree(support_downs).query(feet)[0].min())
    return 2.0 * math.asin(min(1.0, 0.5 * chord))


def spread(equilibria: Equilibria, clusters: Clusters, members: list[int]) -> float:
    """Largest angle between two faces that the part rests on in a pose, radians."""
    downs = equilibria.downs[
        [member for member in members if clusters.is_support[member]]
    ]
    if len(downs) == 1:
        return 0.0
    # The direction farthest from another one is the nearest to its opposite.
    gap, partner = cKDTree(downs).query(-downs)
    first = int(np.argmin(gap))
    chord = float(np.linalg.norm(downs[first] - downs[partner[first]]))
    return 2.0 * math.asin(min(1.0, 0.5 * chord))
