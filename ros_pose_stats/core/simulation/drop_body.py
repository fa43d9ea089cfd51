"""A part prepared for the drop kernels: its corners in principal axes, and balls around them."""

import math
from collections.abc import Iterator
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ..kernels.body.convex_body import build_body
from ..kernels.drops import evolve, layout
from ..kernels.principal_axes import principal_axes
from ..mesh import hull as hulls, vectors
from ..records import Array, DropScene, Index, Part
from ..resting import convex_body, poses, turns
from ..resting.rims import Run

CROWD = 8
"""Corners that may come to lie lowest during a step, if they are spread evenly.

This number is the quickest for 100 to 5 000 corners; to check one of them costs a tenth of a step
or less.
"""

FLAT = 1e-12
"""Distance, in radii, within which corners lie on a plane but for rounding; touching is 1e-9."""

THINNEST = 1e-12
"""Smallest principal moment of inertia, relative to the largest: a rod of points has 0."""


class PreparedBody(NamedTuple):
    """A convex body ready to be dropped."""

    resting: poses.RestingPoses  # the poses whose `index` numbers the outcomes
    arrays: layout.DropBody  # in principal axes
    axes: Array  # (3, 3); principal axes as columns, part axes to principal by `vector @ axes`
    corner: Index  # (C,); hull point of each corner of `arrays`

    @property
    def radius(self) -> float:
        """Largest distance from the centre of mass to a vertex, metres."""
        return self.resting.body.radius


def drop_body(part: Part, scene: DropScene) -> PreparedBody:
    """Prepare a part for drops, once for the poses of a scene; raises what `poses_in` raises."""
    resting = poses.poses_in(part, scene)  # refuses what is no part
    return part.prepare(_prepare, resting)


def _prepare(part: Part, resting: poses.RestingPoses) -> PreparedBody:
    body = resting.body
    moment, axes = principal_axes(resting.inertia)
    moment = np.maximum(moment, THINNEST * moment[2])
    used = np.unique(body.arrays.corner)
    points = vectors.turn_vectors(body.points[used], axes)
    order, ball, ball_range = ball_tree(points)
    points = points[order]
    corner = used[order]
    x, y, z = np.ascontiguousarray(points.T)
    rims = rolling_rims(resting, moment, axes, corner)
    arrays = layout.DropBody(
        x,
        y,
        z,
        moment,
        ball,
        ball_range,
        *_neighbours(points),
        *_sides(resting, corner),
        resting.equilibria.heights[resting.clusters.lowest_face],
        resting.clusters.exit_level,
        rims.pose,
        rims.level,
        rims.climb,
        rims.rim,
        min(evolve.TURN, 2.0 * math.sqrt(CROWD / corner.shape[0])),
    )
    return PreparedBody(resting, arrays, axes, corner)


def _neighbours(points: Array) -> tuple[Index, Index, Array]:
    """Where each corner's neighbours start, the neighbours and their distances.

    Over edges between flat faces: diagonals within a face depend on how the hull was computed.
    """
    count = points.shape[0]
    if count <= LEAF:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)
    hull = hulls.hull_of(points).qhull
    triangles = hull.simplices.astype(np.int64)
    valid, flat = build_body(points, triangles, hull.neighbors.astype(np.int64), FLAT)
    if valid and np.bincount(flat.corner, minlength=count).all():
        pairs = np.stack((flat.corner, flat.corner[flat.twin]), axis=1)
    else:
        pairs = np.concatenate(
            [triangles[:, ends] for ends in permutations(range(3), 2)]
        )
    code = np.unique(pairs[:, 0] * count + pairs[:, 1])
    first, second = np.divmod(code, count)
    start = np.append(0, np.cumsum(np.bincount(first, minlength=count)))
    return start, second, vectors.lengths(points[first] - points[second])


def _sides(
    resting: poses.RestingPoses, corner: Index
) -> tuple[Index, Index, Index, Index]:
    """Sides that leave each corner: where they start, their far ends, poses left and right."""
    arrays = resting.body.arrays
    place = np.full(resting.body.points.shape[0], -1, dtype=np.int64)
    place[corner] = np.arange(corner.shape[0])
    pose_of_face = resting.pose_of_face
    begins = place[arrays.corner]
    order = np.argsort(begins, kind="stable")
    start = np.append(0, np.cumsum(np.bincount(begins, minlength=corner.shape[0])))
    return (
        start,
        begins[arrays.twin][order],
        pose_of_face[arrays.face][order],
        pose_of_face[arrays.face[arrays.twin]][order],
    )


LEAF = 16
"""Corners that a search goes through one by one; most parts of the paper's size need no tree."""

ROUNDING = 1e-12
"""Radius of the part by which a ball is larger than its corners require, as a fraction."""


def ball_tree(points: Array) -> tuple[Index, Array, Index]:
    """Binary tree of balls, in the order in which it is walked."""
    order: list[Index] = []  # (C,); points as the leaves hold them
    balls: list[tuple[float, ...]] = []  # (B, 4); centre and radius
    ranges: list[
        list[int]
    ] = []  # (B, 3); begin and end in `order`, node that follows the subtree
    # Nodes are numbered as they are first seen, a left child right after its parent.
    waiting: list[Index] = [np.arange(points.shape[0])]
    ancestors: list[tuple[int, int]] = []  # a node, and the end of its corners
    placed = 0
    while waiting:
        inside = waiting.pop()
        node = len(balls)
        center = 0.5 * (points[inside].min(axis=0) + points[inside].max(axis=0))
        radius = float(vectors.lengths(points[inside] - center).max()) + ROUNDING
        balls.append((*center.tolist(), radius))
        ranges.append([placed, placed + inside.shape[0], node + 1])
        ancestors.append((node, placed + inside.shape[0]))
        if inside.shape[0] <= LEAF:
            order.append(inside)
            placed += inside.shape[0]
        else:
            axis = int(np.argmax(np.ptp(points[inside], axis=0)))
            middle = inside.shape[0] // 2
            # Stable, since a partition would order its halves differently on other processors.
            ranked = inside[np.argsort(points[inside, axis], kind="stable")]
            waiting += [ranked[middle:], ranked[:middle]]
        while ancestors and ancestors[-1][1] == placed:
            done, _ = ancestors.pop()
            ranges[done][layout.BALL_NEXT] = len(balls)
    return np.concatenate(order), np.array(balls), np.array(ranges, dtype=np.int64)


class RollingRims(NamedTuple):
    """What is added to a drop body; `kernels.drops.drop` tells how it is used."""

    pose: Index  # (C,); pose that a part is in that rolls on this corner's rim; -1 for none
    level: Array  # (C,); energy without that of the roll with which it can tip over
    climb: (
        Array  # (C,); height of the centre of mass above that at the rim's lowest place
    )
    rim: Array  # (P, 10); see `kernels.drops.layout`


def rolling_rims(
    resting: poses.RestingPoses, moment: Array, axes: Array, corner: Index
) -> RollingRims:
    """Find the rims of a part that it can roll on all the way round, in one pose.

    `moment`: of unit mass, lengths in radii; `corner`: hull points that the tables are about.
    """
    body = resting.body
    pose_of_face = resting.pose_of_face
    place = np.full(body.points.shape[0], -1, dtype=np.int64)
    place[corner] = np.arange(corner.shape[0])
    rims = RollingRims(
        np.full(corner.shape[0], -1),
        np.full(corner.shape[0], math.inf),
        np.zeros(corner.shape[0]),
        np.zeros((len(resting.poses), layout.RIM)),
    )
    for run, faces, edges in _rims(body):
        pose = int(pose_of_face[faces[0]])
        begin = body.points[body.arrays.corner[edges]]
        end = body.points[body.arrays.corner[body.arrays.twin[edges]]]
        low, high = np.sort(
            (
                vectors.components_along(begin, run.axis),
                vectors.components_along(end, run.axis),
            ),
            axis=0,
        )
        # How far from the rim's edges, along its axis, a part stands on each facet, in radii.
        inside: Array = np.full(body.faces, math.inf)
        np.minimum.at(
            inside,
            body.arrays.face[edges],
            np.where(body.arrays.inset[edges] > 0.0, np.maximum(low, -high), 0.0),
        )
        inside = inside[faces]
        if (
            rims.rim[pose].any()
            or (pose_of_face[faces] != pose).any()
            or not inside.min() > 0.0
        ):
            continue
        distance = body.arrays.distance[faces]
        edge = np.sqrt(distance * distance + inside * inside)
        rise = float((edge - distance).min())
        chord = vectors.lengths(vectors.cross(end - begin, run.axis))
        axle, center = vectors.turn_vectors(np.stack((run.axis, run.center)), axes)
        about, bumps, single = _shares(
            chord,
            0.5 * float(np.ptp(distance)) * rise,
            axle,
            moment,
            float((inside / distance).max()),
        )
        rims.rim[pose] = [
            *axle,
            *vectors.cross(axle, center),
            about,
            float((inside / edge).min()),
            bumps,
            single,
        ]
        for face, level in zip(faces.tolist(), distance.tolist(), strict=True):
            at = place[
                body.arrays.corner[
                    body.arrays.face_start[face] : body.arrays.face_start[face + 1]
                ]
            ]
            rims.pose[at] = pose
            rims.level[at] = np.minimum(rims.level[at], level + rise)
            rims.climb[at] = np.maximum(rims.climb[at], level - float(distance.min()))
    return rims


def _rims(body: convex_body.ConvexBody) -> Iterator[tuple[Run, Index, Index]]:
    """Runs of round surfaces whose facets along the axis close a ring, these and its edges.

    A flat or a slot in the rim leaves a longer facet there, which belongs to no run.
    """
    normal = body.arrays.normal
    face = body.arrays.face
    # A changed part may have lost all facets of a run.
    for number in np.unique(body.run_of_face[body.run_of_face >= 0]).tolist():
        first = np.flatnonzero(body.run_of_face == number)
        distance = body.arrays.distance[first]
        directions = normal[first]
        upright = [
            run
            for run in body.runs
            if run.kind == "round"
            and run.full
            and np.abs(vectors.components_along(directions, run.axis)).max()
            < turns.LEVEL
        ]
        if not upright:
            continue
        # Of several with one direction, the axis about which the facets are equally far away.
        run = upright[
            int(
                np.argmin(
                    [
                        np.ptp(
                            distance - vectors.components_along(directions, run.center)
                        )
                        for run in upright
                    ]
                )
            )
        ]
        ring = np.abs(vectors.components_along(normal, run.axis)) < turns.LEVEL
        here = ring[face]
        beyond = ring[face[body.arrays.twin]]
        links = np.bincount(face[here & beyond], minlength=body.faces)
        if (links[ring] == 2).all():
            yield run, np.flatnonzero(ring), np.flatnonzero(here & ~beyond)


def _shares(
    chord: Array, swing: float, axle: Array, moment: Array, slope: float
) -> tuple[float, float, float]:
    """Moment of inertia about a rim's axis, and the shares of a roll that the rim sets free.

    On a facet c wide across the axis the corner below moves at -w c / 2 to w c / 2, at a mean
    square of (w c)² / 12; twelve times that is kept back, for what bounces has more at times. A
    facet much wider than the others gives a blow of w c / 2; four times its energy is kept back.
    A centre of mass b beside the axis goes up and down at up to b w², as if the weight changed by
    as much: a part that leans over from below, to an edge h higher, and back from above gains at
    most twice the `swing` b h times w². Where the axis is not a principal one, the centrifugal
    moment tilts the body, at most to the `slope` at which it tips.
    """
    x, y, z = axle.tolist()
    about = float((moment * axle * axle).sum())
    pull = np.array(
        [
            y * z * (moment[2] - moment[1]),
            z * x * (moment[0] - moment[2]),
            x * y * (moment[1] - moment[0]),
        ]
    )
    square = chord * chord
    single = float(square.max()) + 4.0 * swing + 2.0 * vectors.length(pull) * slope
    return about, math.fsum(square.tolist()) / len(square) / about, single / about
