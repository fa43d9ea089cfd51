"""Equilibria of a convex body in one call: stable faces, basins, merge tree, toppling graph."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...tolerances import TIP_MARGIN
from ..array_types import Array, Fixed1, Fixed2, FixedIndex1, FixedIndex2, Index
from ..compilation import entry_kernel, kernel
from ..levels.merge_tree import MergeTree, merge_tree
from .convex_body import BodyArrays
from .descent import basins, descend, faces_beyond, without_barrier
from .toppling import settle, toppling


class EquilibriumArrays(NamedTuple):
    """What the geometry of a body at rest says, before any estimate."""

    stable: Index            # (S,) faces
    basin: Index             # (F,) position in `stable` that a face descends to
    saddle: Index            # (H,) polygon sides with a saddle of r and R
    unstable: Index          # (U,) hull points with a maximum of r and R
    target: Index            # (F, 2) toppling graph
    share: Array             # (F, 2)
    toppled: Array           # (F,) centroid solid angles carried down it, fractions of 4 pi
    tree: MergeTree


@entry_kernel
def find_equilibria(points: Fixed2, body: BodyArrays) -> EquilibriumArrays:
    """Find the equilibria of a convex body (sections 2.C, 4.B and 4.D).

    `points` (H, 3): hull points relative to the centre of mass, scaled to a radius of 1.
    """
    beyond = faces_beyond(body)
    parent = descend(body, beyond)
    while without_barrier(body, beyond, parent):
        pass
    stable, basin = basins(parent)
    target, share = toppling(points, body, beyond, parent)
    toppled = settle(body.angle / body.angle.sum(), target, share)
    return EquilibriumArrays(stable, basin, saddle_sides(body), unstable_points(body),
                             target, share, toppled, merge_tree(body, stable, basin))


@kernel
def saddle_sides(body: BodyArrays) -> Index:
    """Sides where the distance from the centre of mass has a saddle.

    The foot Q lies inside the segment, and the plane through Q normal to it supports the
    body: the feet on both faces lie inside of the side.
    """
    found = np.empty(body.twin.shape[0], np.int64)
    count = 0
    for k in range(body.twin.shape[0]):
        if (k < body.twin[k] and body.start[k] > TIP_MARGIN and body.stop[k] > TIP_MARGIN
                and body.inset[k] > TIP_MARGIN and body.inset[body.twin[k]] > TIP_MARGIN):
            found[count] = k
            count += 1
    return found[:count].copy()


@kernel
def unstable_points(body: BodyArrays) -> Index:
    """Corners where the distance from the centre of mass has a maximum."""
    least = np.full(body.radius.shape[0], math.inf)
    for k in range(body.twin.shape[0]):
        v = body.corner[k]
        least[v] = min(least[v], body.start[k])
    found = np.empty(body.radius.shape[0], np.int64)
    count = 0
    for v in range(least.shape[0]):
        if TIP_MARGIN < least[v] < math.inf:
            found[count] = v
            count += 1
    return found[:count].copy()


@entry_kernel
def settle_on_stable(initial: Fixed1, target: FixedIndex2, share: Fixed2) -> Array:
    """`settle` for callers outside the kernels."""
    return settle(initial, target, share)


@entry_kernel
def ways_out(body: BodyArrays, basin: FixedIndex1, pose: FixedIndex1) -> Index:
    """Polygon sides (k,) of stable faces that lead out of their pose.

    `basin` (F,): see `EquilibriumArrays`; `pose` (F,): pose of each stable face, -1 for other
    faces.
    """
    face, twin, inset = body.face, body.twin, body.inset
    found = np.empty(twin.shape[0], np.int64)
    count = 0
    for k in range(twin.shape[0]):
        f = face[k]
        if pose[f] < 0:
            continue
        g = face[twin[k]]
        # A foot outside of a side by rounding, with a higher face beyond it that comes back.
        if pose[g] != pose[f] and (inset[k] > 0.0 or basin[g] != basin[f]):
            found[count] = k
            count += 1
    return found[:count].copy()
