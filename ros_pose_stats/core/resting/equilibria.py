"""Equilibria of a part on a horizontal plate (sections 2.B, 2.C), gathered into poses.

Stable faces are numbered by rising height, ties by the components of `down`; nothing here
depends on a method, a scene or a seed.

A pose is what a nudge leaves: a stable face is one of its own only if the centre of mass has to
rise by a share of its height to leave it; a shallower one belongs to the pose that the part slips
into (`gather_poses`).
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
from .convex_body import ConvexBody, convex_body, foot_directions


@dataclass(frozen=True, eq=False)
class Equilibria:
    """Stable, saddle and unstable equilibria of a convex body."""

    body: ConvexBody
    arrays: EquilibriumArrays  # from the kernel; `arrays.stable` is in the order of face numbers
    # (S,); positions in `arrays.stable` by rising height: the numbering of the stable faces
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
        least = np.full(len(self.body.points), np.inf)
        np.minimum.at(least, self.body.arrays.corner, self.body.arrays.start)
        return np.asarray(self.body.points[np.isfinite(least) & (least > TIP_MARGIN)])


def equilibria(part: Part, round_sides: int) -> Equilibria:
    """Equilibria of a part, found once and kept as long as the part lives."""
    return part.prepare(_find, round_sides)


def _find(part: Part, round_sides: int) -> Equilibria:
    body = convex_body(part, round_sides)
    arrays = find_equilibria(body.points, body.arrays)
    group = ties(
        (body.arrays.distance[arrays.stable], SAME_HEIGHT),
        *((down, SAME_DOWN) for down in body.arrays.normal[arrays.stable].T),
    )
    return Equilibria(body, arrays, np.argsort(group, kind="stable"))


def ties(*keys: tuple[Array, float], within: Index | None = None) -> Index:
    """Number ties (S,) by groups `within`, then by rising values of keys with their tolerance.

    A tie holds all within the tolerance of its smallest value: a dense sequence is not one tie.
    """
    size = keys[0][0].shape[0]
    group = np.zeros(size, dtype=np.int64) if within is None else within
    count = 1 if within is None else int(within.max()) + 1
    for values, tolerance in keys:
        if count == size:  # no two values are tied any more
            break
        plain = np.ascontiguousarray(values)
        group, count = number_ties(plain, tolerance, group, np.lexsort((plain, group)))
    return group


RUN_TOLERANCE = 0.025
"""Least rise over the height that parts neighbouring facets of one round or toothed surface."""


@dataclass(frozen=True, eq=False)
class Clusters:
    """The poses of a part as groups of stable faces."""

    # least rise of the centre of mass out of a pose, as a share of its height there
    tolerance: float
    # (P,); number of the stable face that stands for the pose, by rising height: its lowest; ties
    # go to the larger face, then to the smaller number
    lowest: Index
    pose: (
        Index  # (S,); pose of each stable face, in the numbering of `Equilibria.order`
    )
    # (S,) bool; faces that the part rests on in its pose: no higher above the lowest one than the
    # tolerance. The others are shelves on the way there
    near: Mask
    # (P,); level of the lowest saddle from any member to any other pose, in radii; infinite for a
    # single pose
    way_out: Array
    barrier: Array  # (P,); the same above the lowest member
    # (N,); largest nodes of the merge tree that hold a single pose. A pose may have several, since
    # a shelf may open only where its pose has others beside it already
    node: Index
    node_pose: Index  # (N,); that pose
    split: Mask  # (S - 1,) bool; whether a join of the merge tree holds several poses

    def gather(self, probability: Array) -> Array:
        """Sum what the nodes of the merge tree (2 S - 1,) have over the poses (P,)."""
        sums = np.bincount(self.node_pose, probability[self.node], self.lowest.shape[0])
        return sums.astype(np.float64)


def clusters(found: Equilibria, tolerance: float) -> Clusters:
    """Gather stable faces into poses; tolerance 0 gathers nothing."""
    tree = found.arrays.tree
    of_run = max(tolerance, RUN_TOLERANCE) if tolerance > 0.0 else 0.0
    # Of several faces the lowest stands for all, then the largest, but for rounding.
    areas = found.body.arrays.area[found.faces]
    order = ties((found.heights, SAME_HEIGHT), (-areas / areas.max(), SAME_HEIGHT))
    eldest, way_out = gather_poses(
        found.body.arrays,
        found.rank[found.arrays.basin],
        found.heights,
        np.argsort(np.argsort(order, kind="stable")),
        found.body.run_of_face[found.faces],
        tolerance,
        of_run,
    )
    lowest, pose = np.unique(eldest, return_inverse=True)
    held, split = part_poses(tree, np.ascontiguousarray(pose[found.rank]))
    node = np.unique(np.append(tree.child[split], held.shape[0] - 1))
    node = node[held[node] >= 0]
    heights = found.heights[lowest]
    near = found.heights < (1.0 + tolerance) * heights[pose]
    near[lowest] = True
    return Clusters(
        tolerance,
        lowest,
        pose,
        near,
        way_out[lowest],
        way_out[lowest] - heights,
        node,
        held[node],
        split,
    )


def tilt_margins(found: Equilibria, grouped: Clusters) -> Array:
    """Smallest tilt (P,) that takes the part out of each pose, radians.

    A pose of several faces, within which the part rolls or slips first, ends with its basin.
    """
    arrays = found.body.arrays
    pose_of_face = np.full(found.body.faces, -1, dtype=np.int64)
    pose_of_face[found.faces] = grouped.pose
    margins = np.full(grouped.lowest.shape[0], np.pi / 2.0)
    several = np.bincount(grouped.pose) > 1
    here = arrays.face
    beyond = arrays.face[arrays.twin]
    basin = found.arrays.basin
    # A foot may be outside of a side by rounding, with a higher face beyond it that comes back.
    sides = np.flatnonzero(
        (pose_of_face[here] >= 0)
        & (pose_of_face[beyond] != pose_of_face[here])
        & ((arrays.inset > 0.0) | (basin[beyond] != basin[here]))
    )
    faces = arrays.face[sides]
    alone = ~several[pose_of_face[faces]]
    tilts = np.arctan2(arrays.inset[sides], arrays.distance[faces])
    np.minimum.at(margins, pose_of_face[faces[alone]], tilts[alone])
    for pose in np.flatnonzero(several).tolist():
        margins[pose] = min(np.pi / 2.0, _tilt_to_border(found, grouped, pose))
    return margins


def _tilt_to_border(found: Equilibria, grouped: Clusters, pose: int) -> float:
    """Smallest angle between a face that the part rests on and a side where the basin ends."""
    arrays = found.body.arrays
    here = grouped.pose[found.rank[found.arrays.basin]] == pose
    sides = np.flatnonzero(here[arrays.face] & ~here[arrays.face[arrays.twin]])
    if not len(sides):
        return math.inf
    feet = foot_directions(found.body, sides)
    rests = found.downs[grouped.near & (grouped.pose == pose)]
    chord = float(cKDTree(rests).query(feet)[0].min())
    return 2.0 * math.asin(min(1.0, 0.5 * chord))


def spread(found: Equilibria, grouped: Clusters, members: list[int]) -> float:
    """Largest angle between two faces that the part rests on in a pose, radians."""
    downs = found.downs[[member for member in members if grouped.near[member]]]
    if len(downs) == 1:
        return 0.0
    # The direction farthest from another one is the nearest to its opposite.
    gap, partner = cKDTree(downs).query(-downs)
    first = int(np.argmin(gap))
    chord = float(np.linalg.norm(downs[first] - downs[partner[first]]))
    return 2.0 * math.asin(min(1.0, 0.5 * chord))
