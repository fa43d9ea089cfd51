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

"""A part prepared for the drop kernels: corners in principal axes, and balls."""

import math
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ..kernels.body.convex_body import build_body
from ..kernels.body.own_frame import own_frame
from ..kernels.drops import evolve, layout
from ..kernels.levels.merge_tree import part_poses
from ..kernels.principal_axes import principal_axes
from ..mesh import vectors
from ..mesh.hull import hull_of
from ..records import Array, DropScene, Index, Part
from ..resting import poses
from . import rolling_rims

LOW_CORNERS = 8
"""Corners that may come to lie lowest during a step, if they are spread evenly.

This number is the quickest for 100 to 5 000 corners; to check one of them costs a tenth
of a step or less.
"""

FLAT = 1e-12
"""Distance, in radii, within which corners lie on a plane but for rounding; touching is
1e-9."""

THINNEST = 1e-12
"""Smallest principal moment of inertia, relative to the largest: a rod of points has
0."""


POINT_BITS = 33
TENSOR_BITS = 36
DIRECTION_BITS = 46
"""Binary digits to which corners, inertia and directions are rounded in the part's own
frame.

Turned copies of a part agree there to some 1e-15, and a drop makes a point of a share
out of less: rounded, next to all of them agree to the last bit. A corner moves by 6e-11
radii at most, well within `TOUCHING`.
"""


class PreparedBody(NamedTuple):
    """A convex body ready to be dropped."""

    resting: poses.RestingPoses  # the poses whose `index` numbers the outcomes
    arrays: layout.DropBody  # in principal axes
    # (3, 3); axes of the part's own as columns, in part axes: left-handed for one of
    # two mirror images, so that both have the same drops
    frame: Array
    turn: Array  # (3, 3); principal axes as columns, in the axes of `frame`
    corner: Index  # (C,); hull point of each corner of `arrays`
    is_rounded: bool  # whether values in the axes of `frame` are rounded

    @property
    def radius(self) -> float:
        """Largest distance from the centre of mass to a vertex, metres."""
        return self.resting.body.radius

    @property
    def axes(self) -> Array:
        """Principal axes as columns (3, 3): from part axes by `vector @ axes`."""
        return vectors.turn_vectors(self.frame, self.turn)

    @property
    def spin_axes(self) -> Array:
        """The same for angular velocities, which a mirror turns the other way."""
        return -self.axes if is_left_handed(self.frame) else self.axes

    def frame_points(self, hull_points: Index) -> Array:
        """Hull points (k, 3) in the axes of `frame`, in radii."""
        return _in_frame(
            self.resting.body.points[hull_points],
            self.frame,
            POINT_BITS if self.is_rounded else None,
        )

    def frame_directions(self, directions: Array) -> Array:
        """Unit vectors (n, 3) in part axes in the axes of `frame`."""
        return _in_frame(
            directions, self.frame, DIRECTION_BITS if self.is_rounded else None
        )


def drop_body(part: Part, scene: DropScene) -> PreparedBody:
    """Prepare a part for drops, once for the poses of a scene; raises as `poses_in`."""
    resting = poses.poses_in(part, scene)  # refuses what is no part
    return part.prepare(_prepare, resting)


def body_in_part_axes(part: Part, scene: DropScene) -> PreparedBody:
    """Prepare a part as it is filed, with its own axes and order, and not rounded."""
    return _prepare(part, poses.poses_in(part, scene), np.eye(3))


def is_left_handed(axes: Array) -> bool:
    """Whether axes (3, 3), as columns, are those of a mirror image."""
    x, y, z = axes.T
    return float((vectors.cross(x, y) * z).sum()) < 0.0


def _in_frame(values: Array, frame: Array, bits: int | None) -> Array:
    """Vectors (n, 3) by their components along the axes of a frame."""
    components = vectors.turn_vectors(values, frame)
    return components if bits is None else round_to(components, 2.0**-bits)


def round_to(values: Array, step: Array | float) -> Array:
    """Multiples of a power of two, exactly."""
    return np.asarray(np.rint(values / step) * step)


def _own_frame(resting: poses.RestingPoses) -> Array:
    arrays = resting.body.arrays
    return own_frame(
        arrays.normal,
        arrays.distance,
        arrays.area,
        resting.equilibria.faces,
        resting.inertia,
    )


def _prepare(
    part: Part, resting: poses.RestingPoses, part_axes: Array | None = None
) -> PreparedBody:
    body = resting.body
    is_rounded = part_axes is None
    frame = _own_frame(resting) if part_axes is None else part_axes
    inertia = vectors.turn_vectors(
        vectors.turn_vectors(frame.T, resting.inertia), frame
    )
    if is_rounded:
        size = np.sqrt(np.diag(inertia))
        # The power of two above the geometric mean of two moments.
        steps = np.ldexp(1.0, np.frexp(size[:, None] * size)[1] - TENSOR_BITS)
        inertia = round_to(inertia, steps)
    moment, turn = principal_axes(inertia)
    moment = np.maximum(moment, THINNEST * moment[2])
    axes = vectors.turn_vectors(frame, turn)
    used = np.unique(body.arrays.corner)
    places = _in_frame(body.points[used], frame, POINT_BITS if is_rounded else None)
    if is_rounded:
        # In an order that does not hang on that of the mesh, since it decides ties.
        order = np.lexsort(places.T)
        places = places[order]
        used = used[order]
    points = vectors.turn_vectors(places, turn)
    order, ball, ball_range = ball_tree(points)
    points = points[order]
    corner = used[order]
    corner_number = np.full(body.points.shape[0], -1, dtype=np.int64)
    corner_number[corner] = np.arange(corner.shape[0])
    x, y, z = np.ascontiguousarray(points.T)
    # Rounded, faces are no longer flat.
    neighbours = _find_neighbours(vectors.turn_vectors(body.points[corner], axes))
    sides = _find_sides(resting, corner_number, is_left_handed(frame))
    rims = rolling_rims.find_rolling_rims(resting, moment, axes, corner)
    arrays = layout.DropBody(
        x=x,
        y=y,
        z=z,
        moment=moment,
        ball=ball,
        ball_range=ball_range,
        neighbour_start=neighbours.start,
        neighbour=neighbours.corner,
        neighbour_distance=neighbours.distance,
        side_start=sides.start,
        side_end=sides.end,
        side_left=sides.left_pose,
        side_right=sides.right_pose,
        pose_level=resting.heights,
        way_out=resting.clusters.exit_level,
        unit_way_out=_unit_exits(resting),
        rim=rims.rim,
        rim_pose=rims.pose,
        rim_poses=rims.poses,
        corner_rim=rims.corner_rim,
        turn_limit=min(evolve.TURN, 2.0 * math.sqrt(LOW_CORNERS / corner.shape[0])),
    )
    return PreparedBody(resting, arrays, frame, turn, corner, is_rounded)


def _unit_exits(resting: poses.RestingPoses) -> Array:
    """Level (P,) of the lowest saddle from any pose of a unit to one of another.

    Infinite where all poses are one unit.
    """
    tree = resting.equilibria.arrays.tree
    pose = resting.clusters.pose[resting.equilibria.rank]
    unit_of_node, is_mixed = part_poses(tree, resting.unit[pose])
    children = unit_of_node[tree.child[is_mixed]]
    is_unit = children >= 0
    level = np.broadcast_to(tree.level[is_mixed, None], children.shape)
    exits = np.full(len(resting.poses), math.inf)
    np.minimum.at(exits, children[is_unit], level[is_unit])
    return np.asarray(exits[resting.unit])


class Neighbours(NamedTuple):
    """Corners along the edges of each corner; all empty for a body of one ball."""

    start: Index  # (C + 1,)
    corner: Index  # (E,)
    distance: Array  # (E,); to it


def _find_neighbours(points: Array) -> Neighbours:
    """Neighbours over edges between flat faces.

    Diagonals within a face depend on how the hull was computed.
    """
    count = points.shape[0]
    if count <= LEAF:
        no_corners = np.zeros(0, dtype=np.int64)
        return Neighbours(no_corners, no_corners.copy(), np.zeros(0))
    hull = hull_of(vectors.to_unit_size(points)).qhull
    triangles = hull.simplices.astype(np.int64)
    is_valid, flat = build_body(
        points, triangles, hull.neighbors.astype(np.int64), FLAT
    )
    if is_valid and np.bincount(flat.corner, minlength=count).all():
        pairs = np.stack((flat.corner, flat.corner[flat.twin]), axis=1)
    else:
        pairs = np.concatenate(
            [triangles[:, ends] for ends in permutations(range(3), 2)]
        )
    pair_code = np.unique(pairs[:, 0] * count + pairs[:, 1])
    corner, neighbour = np.divmod(pair_code, count)
    start = np.append(0, np.cumsum(np.bincount(corner, minlength=count)))
    distance = vectors.lengths(points[corner] - points[neighbour])
    return Neighbours(start, neighbour, distance)


class Sides(NamedTuple):
    """Sides that leave each corner."""

    start: Index  # (C + 1,)
    end: Index  # (N,); corner at the far end
    left_pose: Index  # (N,); pose that the face to the left of a side descends to
    right_pose: Index


def _find_sides(
    resting: poses.RestingPoses, corner_number: Index, is_mirrored: bool
) -> Sides:
    arrays = resting.body.arrays
    pose_of_face = resting.pose_of_face
    begins = corner_number[arrays.corner]
    order = np.argsort(begins, kind="stable")
    left = pose_of_face[arrays.face][order]
    right = pose_of_face[arrays.face[arrays.twin]][order]
    return Sides(
        np.append(0, np.cumsum(np.bincount(begins))),
        begins[arrays.twin][order],
        *((right, left) if is_mirrored else (left, right)),
    )


LEAF = 16
"""Corners that a search goes through one by one; most parts of the paper's size need no
tree."""

ROUNDING = 1e-12
"""Radius of the part by which a ball is larger than its corners require, as a
fraction."""


def ball_tree(points: Array) -> tuple[Index, Array, Index]:
    """Binary tree of balls, in the order in which it is walked."""
    order: list[Index] = []  # (C,); points as the leaves hold them
    balls: list[tuple[float, ...]] = []  # (B, 4); centre and radius
    # (B, 3); begin and end in `order`, node that follows the subtree
    ranges: list[list[int]] = []
    # Nodes are numbered as they are first seen, a left child right after its parent.
    pending: list[Index] = [np.arange(points.shape[0])]
    ancestors: list[tuple[int, int]] = []  # a node, and the end of its corners
    corner_count = 0
    while pending:
        corners = pending.pop()
        node = len(balls)
        center = 0.5 * (points[corners].min(axis=0) + points[corners].max(axis=0))
        radius = float(vectors.lengths(points[corners] - center).max()) + ROUNDING
        balls.append((*center.tolist(), radius))
        ranges.append([corner_count, corner_count + corners.shape[0], node + 1])
        ancestors.append((node, corner_count + corners.shape[0]))
        if corners.shape[0] <= LEAF:
            order.append(corners)
            corner_count += corners.shape[0]
        else:
            axis = int(np.argmax(np.ptp(points[corners], axis=0)))
            half = corners.shape[0] // 2
            # Stable, since a partition would order its halves differently on other
            # processors.
            ranked_corners = corners[np.argsort(points[corners, axis], kind="stable")]
            pending += [ranked_corners[half:], ranked_corners[:half]]
        while ancestors and ancestors[-1][1] == corner_count:
            closed_node, _ = ancestors.pop()
            ranges[closed_node][layout.BALL_NEXT] = len(balls)
    return np.concatenate(order), np.array(balls), np.array(ranges, dtype=np.int64)
