"""Rims that a part rolls on, with what the trap stop needs to know of them.

A part that rolls upright on a rim keeps the energy of its roll for long: the spin about the rim's
axis, and the rise and fall of a centre of mass beside that axis. It cannot tip over with it as
long as the rest of its energy does not lift it over the edge of the rim where it stands.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.drops.layout import RIM
from ..mesh.vectors import lengths, turn_vectors
from ..resting.convex_body import ConvexBody
from ..resting.poses import RestingPoses
from ..resting.turns import LEVEL

Array = NDArray[np.float64]
Index = NDArray[np.int64]

class RollingRims(NamedTuple):
    """What is added to a drop body; `kernels.drops.trap` tells how it is used."""

    pose: Index  # (C,); pose that a part is in that rolls on this corner's rim; -1 for none
    level: Array  # (C,); energy without that of the spin with which it can tip over
    climb: Array  # (C,); height of the centre of mass above that at the rim's lowest place
    rim: Array  # (P, 5); see `kernels.drops.layout`


def rolling_rims(resting: RestingPoses, moment: Array, axes: Array, corner: Index) -> RollingRims:
    """Find the rims of a part that it can roll on all the way round, in one pose.

    `moment` (3,): principal moments of inertia of unit mass, lengths in radii; `axes` (3, 3):
    principal axes as columns; `corner` (C,): hull points that the tables are about.
    """
    body, found = resting.body, resting.equilibria
    pose_of_face = resting.clusters.pose[found.rank][found.arrays.basin]
    place = np.full(body.points.shape[0], -1, dtype=np.int64)
    place[corner] = np.arange(corner.shape[0])
    rims = RollingRims(np.full(corner.shape[0], -1), np.full(corner.shape[0], math.inf),
                       np.zeros(corner.shape[0]), np.zeros((len(resting.poses), RIM)))
    for axis, faces in _rims(body):
        pose, sides, off = int(pose_of_face[faces[0]]), *_sides(body, faces)
        inside = _inside(body, faces, sides[off])
        if rims.rim[pose].any() or (pose_of_face[faces] != pose).any() or not inside.min() > 0.0:
            continue
        distance = body.arrays.distance[faces]
        rise = float((np.sqrt(distance * distance + inside * inside) - distance).min())
        chord = (body.arrays.start + body.arrays.stop)[sides[off]]
        rims.rim[pose] = _shares(chord, 0.5 * float(np.ptp(distance)),
                                 turn_vectors(axis[None], axes)[0], moment,
                                 float((inside / distance).max()))
        for face, level in zip(faces.tolist(), distance.tolist(), strict=True):
            at = place[body.arrays.corner[body.arrays.face_start[face]:
                                          body.arrays.face_start[face + 1]]]
            rims.pose[at] = pose
            rims.level[at] = np.minimum(rims.level[at], level + rise)
            rims.climb[at] = np.maximum(rims.climb[at], level - float(distance.min()))
    return rims


def _rims(body: ConvexBody) -> Iterator[tuple[Array, Index]]:
    """Axes of round surfaces, each with the facets (k,) along it, if they close a ring.

    A flat or a slot in the rim leaves a longer facet there, which belongs to no run.
    """
    x, y, z = body.arrays.normal.T
    # A changed part may have lost all facets of a run.
    for number in np.unique(body.run_of_face[body.run_of_face >= 0]).tolist():
        first = np.flatnonzero(body.run_of_face == number)
        for run in body.runs:
            along = x * run.axis[0] + y * run.axis[1] + z * run.axis[2]
            if run.kind == "round" and run.full and float(np.abs(along[first]).max()) < LEVEL:
                faces = np.flatnonzero(np.abs(along) < LEVEL)
                sides, off = _sides(body, faces)
                links = np.bincount(body.arrays.face[sides[~off]], minlength=body.faces)
                if (links[faces] == 2).all():
                    yield run.axis, faces
                break


def _sides(body: ConvexBody, faces: Index) -> tuple[Index, NDArray[np.bool_]]:
    """Sides of some faces, and whether they lead off them."""
    arrays, chosen = body.arrays, np.zeros(body.faces, dtype=np.bool_)
    chosen[faces] = True
    sides = np.flatnonzero(chosen[arrays.face])
    return sides, np.asarray(~chosen[arrays.face[arrays.twin[sides]]])


def _inside(body: ConvexBody, faces: Index, edges: Index) -> Array:
    """How far (k,) inside the rim's edges a part stands on each facet, in radii."""
    inside = np.full(body.faces, math.inf)
    np.minimum.at(inside, body.arrays.face[edges], body.arrays.inset[edges])
    return np.asarray(inside[faces])


def _shares(chord: Array, beside: float, axle: Array, moment: Array, slope: float) -> Array:
    """What the kernels need of a rim (5,): its axis, and the shares of a roll that it sets free.

    On a facet c long the corner below moves at -w c / 2 to w c / 2, at a mean square of
    (w c)² / 12; twelve times that is kept back, for what bounces has more at times. A facet much
    longer than the others gives a blow of w c / 2; four times its energy is kept back. A centre of
    mass `beside` the axis goes up and down at up to w times that, and a fast part hops; twice its
    energy is kept back. Where the axis is not a principal one, the centrifugal moment tilts the
    body, at most to the `slope` at which it tips.
    """
    x, y, z = axle.tolist()
    about = float((moment * axle * axle).sum())
    pull = np.array([[y * z * (moment[2] - moment[1]), z * x * (moment[0] - moment[2]),
                      x * y * (moment[1] - moment[0])]])
    square = chord * chord
    single = float(square.max()) + 2.0 * beside * beside + 2.0 * float(lengths(pull)[0]) * slope
    return np.array([*(axle * math.sqrt(0.5 * about)),
                     math.fsum(square.tolist()) / len(square) / about, single / about])
