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

"""Rings of facets on which a part can roll on for long, and what rolls set free."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..kernels.drops import layout
from ..mesh import vectors
from ..records import Array, Index
from ..resting import convex_body, poses, turns


class RollingRims(NamedTuple):
    """What is added to a drop body; `kernels.drops.drop` tells how it is used."""

    rim: Array  # (R, 11); see `kernels.drops.layout`
    pose: Index  # (R,); a pose of each
    poses: Index  # (R,); how many it has, all of one unit
    corner_rim: Index  # (C,); rim that a corner is on, -1 for none


def find_rolling_rims(
    resting: poses.RestingPoses, moment: Array, axes: Array, corner: Index
) -> RollingRims:
    """Find the rings of facets on which a part can roll on for long.

    Where a roll ends that does not tip over is certain if its poses are one unit, or
    remains to be drawn; else once it keeps to the arc of one pose. `moment`: of unit
    mass, lengths in radii; `corner` (C,): hull point of each row in the tables.
    """
    body = resting.body
    rows: list[list[float]] = []
    rim_poses: list[Index] = []
    corner_rim = np.full(body.points.shape[0], -1)
    for ring in _find_rings(resting):
        if (corner_rim[body.arrays.corner[ring.sides]] >= 0).any():
            continue
        for arc in _arcs(resting, ring):
            row = _rim_row(body, arc.ring, moment, axes)
            if row is None:
                continue
            corner_rim[arc.corners] = len(rows)
            rows.append([*row, arc.way_out])
            rim_poses.append(arc.poses)
    return RollingRims(
        np.array(rows).reshape(-1, layout.RIM),
        np.array([int(poses[0]) for poses in rim_poses], dtype=np.int64),
        np.array([poses.size for poses in rim_poses], dtype=np.int64),
        corner_rim[corner],
    )


class Ring(NamedTuple):
    """Facets along an axis that close round a body."""

    axis: Array  # (3,)
    faces: Index  # (F,)
    sides: Index  # (N,); all of theirs
    ends: Index  # (E,); those that bound the ring


class Arc(NamedTuple):
    """Facets of a ring on which a roll ends in one pose, or in poses of one unit."""

    ring: Ring  # those facets alone
    poses: Index
    corners: Index
    way_out: float  # level of the edges over which the roll leaves them, if any


def _arcs(resting: poses.RestingPoses, ring: Ring) -> Iterator[Arc]:
    """The whole ring where its poses are one unit, all of it; else an arc a pose.

    An arc ends a facet before those of other poses, which may be much wider.
    """
    arrays = resting.body.arrays
    pose_of_face = resting.pose_of_face
    ring_poses = np.unique(pose_of_face[ring.faces])
    unit = np.flatnonzero(resting.unit == resting.unit[ring_poses[0]])
    if ring_poses.size == 1 or np.array_equal(ring_poses, unit):
        yield Arc(ring, ring_poses, arrays.corner[ring.sides], math.inf)
        return
    inner = np.setdiff1d(ring.sides, ring.ends)
    side_pose = pose_of_face[arrays.face[inner]]
    is_border = side_pose != pose_of_face[arrays.face[arrays.twin[inner]]]
    border_corner = arrays.corner[inner[is_border]]
    level = vectors.lengths(
        vectors.cross(resting.body.points[border_corner], ring.axis)
    )
    is_inside = np.ones(resting.body.faces, dtype=np.bool_)
    is_inside[arrays.face[inner[is_border]]] = False
    for pose in ring_poses.tolist():
        is_arc = is_inside & (pose_of_face == pose)
        faces = ring.faces[is_arc[ring.faces]]
        if faces.size < FEWEST_FACETS:
            continue
        sides = ring.sides[is_arc[arrays.face[ring.sides]]]
        ends = ring.ends[is_arc[arrays.face[ring.ends]]]
        way_out = float(level[side_pose[is_border] == pose].min())
        corners = np.setdiff1d(arrays.corner[sides], border_corner)
        yield Arc(
            Ring(ring.axis, faces, sides, ends), np.array([pose]), corners, way_out
        )


FEWEST_FACETS = 8  # of a ring; on fewer a roll ends before it could be told
MOST_SIDES = 256  # of stable faces, the longest, that a ring may lie along


def _find_rings(resting: poses.RestingPoses) -> Iterator[Ring]:
    """Rings along the axes of the body's runs, or along a side of a stable face."""
    body = resting.body
    face = body.arrays.face
    axes = _axes_of_rings(resting)
    along_axes = np.abs(vectors.turn_vectors(body.arrays.normal, axes.T)) < turns.LEVEL
    is_candidate = along_axes.sum(axis=0) >= FEWEST_FACETS
    seen_axes: list[Array] = []
    for axis, is_ring in zip(
        axes[is_candidate], along_axes.T[is_candidate], strict=True
    ):
        if any(
            vectors.length(vectors.cross(axis, other)) < turns.LEVEL
            for other in seen_axes
        ):
            continue
        seen_axes.append(axis)
        is_on_ring = is_ring[face]
        is_ring_beyond = is_ring[face[body.arrays.twin]]
        links = np.bincount(face[is_on_ring & is_ring_beyond], minlength=body.faces)
        if (links[is_ring] == 2).all():
            yield Ring(
                axis,
                np.flatnonzero(is_ring),
                np.flatnonzero(is_on_ring),
                np.flatnonzero(is_on_ring & ~is_ring_beyond),
            )


def _axes_of_rings(resting: poses.RestingPoses) -> Array:
    """Directions (n, 3) along which a ring may lie, those of full runs first."""
    body = resting.body
    run_axes = [run.axis for run in sorted(body.runs, key=lambda run: not run.full)]
    is_stable = np.zeros(body.faces, dtype=np.bool_)
    is_stable[resting.equilibria.faces] = True
    sides = np.flatnonzero(is_stable[body.arrays.face])
    edges = (
        body.points[body.arrays.corner[body.arrays.twin[sides]]]
        - body.points[body.arrays.corner[sides]]
    )
    edges = edges[np.argsort(-vectors.lengths(edges), kind="stable")]
    edges = edges[:MOST_SIDES]
    return np.vstack((*run_axes, vectors.unit_vectors(edges)))


def _rim_row(
    body: convex_body.ConvexBody, ring: Ring, moment: Array, axes: Array
) -> list[float] | None:
    """The row of a ring in the table of rims; None where it is no place to roll on."""
    arrays = body.arrays
    begin = body.points[arrays.corner[ring.ends]]
    end = body.points[arrays.corner[arrays.twin[ring.ends]]]
    low, high = np.sort(
        (
            vectors.components_along(begin, ring.axis),
            vectors.components_along(end, ring.axis),
        ),
        axis=0,
    )
    # How far from an end, along the axis, a part stands on each facet, in radii.
    end_distance: Array = np.full(body.faces, math.inf)
    np.minimum.at(
        end_distance,
        arrays.face[ring.ends],
        np.where(arrays.inset[ring.ends] > 0.0, np.maximum(low, -high), 0.0),
    )
    end_distance = end_distance[ring.faces]
    if not end_distance.min() > 0.0:
        return None
    height: Array = np.zeros(body.faces)
    np.maximum.at(
        height,
        arrays.face[ring.sides],
        vectors.lengths(
            vectors.cross(body.points[arrays.corner[ring.sides]], ring.axis)
        ),
    )
    height = height[ring.faces]
    edge = np.hypot(height, end_distance)
    rise = float((edge - height).min())
    distance = arrays.distance[ring.faces]
    chord = _widths(body, ring)[ring.faces]
    (axle,) = vectors.turn_vectors(ring.axis[None], axes)
    axle_inertia, bump_share, single_share, swing = _free_roll_shares(
        chord,
        _weight_swing(body, ring, chord),
        axle,
        moment,
        float((end_distance / distance).max()),
    )
    return [
        *axle.tolist(),
        axle_inertia,
        float((end_distance / edge).min()),
        rise,
        float(distance.min()),
        bump_share,
        single_share,
        swing,
    ]


def _widths(body: convex_body.ConvexBody, ring: Ring) -> Array:
    """How wide each face (F,) of a ring is across the axis; 0 for others."""
    arrays = body.arrays
    face = arrays.face[ring.sides]
    across = vectors.cross(ring.axis[None], arrays.normal[face])
    place = (body.points[arrays.corner[ring.sides]] * across).sum(axis=1)
    low: Array = np.zeros(body.faces)
    high: Array = np.zeros(body.faces)
    low[face] = high[face] = place
    np.minimum.at(low, face, place)
    np.maximum.at(high, face, place)
    return high - low


def _weight_swing(body: convex_body.ConvexBody, ring: Ring, chord: Array) -> float:
    """How far from the axle, at most, the centre of mass is on a ring's facets.

    By R + R'' = r: that is R'', the acceleration of the height over the turn's square,
    where the surface has the radius of curvature r; tipping over a corner it is -R.
    """
    arrays = body.arrays
    inner = np.setdiff1d(ring.sides, ring.ends)
    normal = arrays.normal[arrays.face[inner]]
    other_normal = arrays.normal[arrays.face[arrays.twin[inner]]]
    angle = np.arctan2(
        vectors.lengths(vectors.cross(normal, other_normal)),
        (normal * other_normal).sum(axis=1),
    )
    turn = 0.5 * np.bincount(arrays.face[inner], angle, body.faces)[ring.faces]
    distance = arrays.distance[ring.faces]
    return float(np.minimum(np.abs(chord / turn - distance), distance).max())


def _free_roll_shares(
    chord: Array, offset: float, axle: Array, moment: Array, slope: float
) -> tuple[float, float, float, float]:
    """Moment of inertia about a rim's axis, and shares of a roll that it sets free.

    On a facet c wide across the axis the corner below moves at -w c / 2 to w c / 2, at
    a mean square of (w c)² / 12; twelve times that is kept back, for what bounces has
    more at times. A facet much wider than the others gives a blow of w c / 2; four
    times its energy is kept back. Where the axis is not a principal one, the
    centrifugal moment tilts the body, at most to the `slope` at which it tips. A centre
    of mass b beside the axle (`offset`) goes up and down at up to b w², as if the
    weight changed by as much: a part that leans over from below, to an edge h higher,
    and back from above gains at most 2 b h w².
    """
    x, y, z = axle.tolist()
    axle_inertia = float((moment * axle * axle).sum())
    pull = np.array(
        [
            y * z * (moment[2] - moment[1]),
            z * x * (moment[0] - moment[2]),
            x * y * (moment[1] - moment[0]),
        ]
    )
    square = chord * chord
    return (
        axle_inertia,
        math.fsum(square.tolist()) / len(square) / axle_inertia,
        (float(square.max()) + 2.0 * vectors.length(pull) * slope) / axle_inertia,
        4.0 * offset / axle_inertia,
    )
