"""Which faces are stable, and which stable face each of the others descends to.

A part standing on a face topples over a side when the foot of its centre of mass lies
beyond it (inset < 0); the neighbour's plane is then closer to the centre of mass. Every
rule below goes to a lower face only, ties by number, so that no walk can return.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..tolerances import TIP_MARGIN
from .body import BodyArrays
from .compilation import kernel

Index = NDArray[np.int64]


@kernel
def side_level(body: BodyArrays, k: int) -> float:
    """Smallest distance of a polygon side (a segment) from the origin.

    It is no smaller than the line's distance seen from either face; where corners lie off
    their planes by what still counts as coplanar, this is enforced.
    """
    level = max(body.reach[k], body.reach[body.twin[k]])
    if body.start[k] > 0.0 and body.stop[k] > 0.0:
        return float(level)
    ends = min(body.radius[body.corner[k]], body.radius[body.corner[body.twin[k]]])
    return float(max(level, ends))


@kernel
def is_lower(body: BodyArrays, g: int, f: int) -> bool:
    """Face g lies below face f in the order of distances."""
    if body.distance[g] == body.distance[f]:
        return g < f
    return bool(body.distance[g] < body.distance[f])


@kernel
def descend(body: BodyArrays) -> Index:
    """Neighbour that each face joins when it is flooded from below; itself where stable.

    Taken is the side nearest to the foot among those that the foot lies beyond: the level
    {r < E} of the face first touches that side, and {R < E} flows over it as well, so the
    basins found by following these steps serve both functions.
    """
    faces = body.distance.shape[0]
    parent = np.arange(faces)
    for f in range(faces):
        best, best_inset = math.inf, math.inf
        shallowest = math.inf
        lowest = f
        for k in range(body.face_start[f], body.face_start[f + 1]):
            shallowest = min(shallowest, body.inset[k])
            g = body.face[body.twin[k]]
            if not is_lower(body, g, f):
                continue
            if is_lower(body, g, lowest):
                lowest = g
            if body.inset[k] > TIP_MARGIN:
                continue
            level = side_level(body, k)
            if level < best or (level == best and body.inset[k] < best_inset):
                best, best_inset = level, body.inset[k]
                parent[f] = g
        # Rounding only: beyond a side, but the neighbour there is no lower.
        if shallowest <= TIP_MARGIN and parent[f] == f:
            parent[f] = lowest
    return parent


@kernel
def basins(parent: Index) -> tuple[Index, Index]:
    """Stable faces in order of number, and for each face the stable face it descends to.

    Returns
    -------
    stable : (S,) array
        Face numbers.
    basin : (F,) array
        Position in `stable`.
    """
    faces = parent.shape[0]
    basin = np.full(faces, -1, np.int64)
    stable = np.empty(faces, np.int64)
    count = 0
    for f in range(faces):
        if parent[f] == f:
            stable[count] = f
            basin[f] = count
            count += 1
    for f in range(faces):
        end = f
        while basin[end] < 0:
            end = parent[end]
        found = basin[end]
        walk = f
        while basin[walk] < 0:
            basin[walk] = found
            walk = parent[walk]
    return stable[:count].copy(), basin


@kernel
def without_barrier(body: BodyArrays, parent: Index) -> bool:
    """Let stable faces that nothing keeps in place descend further; tell whether any did.

    Among faces that are coplanar but for rounding, one can be the lowest of its neighbours
    and still have its foot outside, or a way out that does not rise at all. Each such step
    leaves one stable face less and must not lead back.
    """
    stable, basin = basins(parent)
    lowest = np.full(stable.shape[0], math.inf)
    way_out = np.full(stable.shape[0], -1, np.int64)
    for k in range(body.twin.shape[0]):
        own = basin[body.face[k]]
        if own == basin[body.face[body.twin[k]]]:
            continue
        level = side_level(body, k)
        if level < lowest[own]:
            lowest[own], way_out[own] = level, k
    moved = False
    for i in range(stable.shape[0]):
        f = stable[i]
        beyond = -1
        if lowest[i] <= body.distance[f]:
            beyond = body.face[body.twin[way_out[i]]]
        for k in range(body.face_start[f], body.face_start[f + 1]):
            across = body.face[body.twin[k]]
            if body.inset[k] <= 0.0 and basin[across] != i:
                beyond = across
        if beyond >= 0 and end_of(parent, beyond) != f:
            parent[f] = beyond
            moved = True
    return moved


@kernel
def end_of(parent: Index, f: int) -> int:
    """Stable face that a face descends to."""
    while parent[f] != f:
        f = parent[f]
    return f
