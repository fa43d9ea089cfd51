"""Which shells are bodies, which are voids, and which have to be turned inside out.

Shells that do not cut each other form a forest: the parent of a shell is the smallest one
around it. Outside of everything and inside a void there is nothing, inside a body there is
metal. A shell wound inward encloses nothing; that makes sense in metal only. Where it lies
in nothing it was exported inverted and is turned, and from there on down the windings tell
nothing: the shells in it are voids and bodies in turn.
"""

import numpy as np

from ..kernels.mesh.measures import bounds, tetrahedra
from ..records import Array, Index, Mask
from ..tolerances import OVERLAP
from .overlap import check_patience, reach_into_each_other
from .winding import Shells, crossings

# Rounding of a sum of volumes of order one; a folded sheet encloses no more.
_NO_VOLUME = 1e-14

_FEW = 4  # candidates that are asked at first


def oriented_outward(vertices: Array, shells: Shells) -> tuple[Index, float]:
    """Turn the shells so that all normals point out of the material.

    Returns the triangles, and the share of the volume that counts twice where bodies reach into
    each other by more than `OVERLAP` of the size, else 0.
    """
    low, high = bounds(vertices)
    size = float((high - low).max())
    points = (vertices - (low + 0.5 * (high - low))) / size
    weights = tetrahedra(points, shells.triangles)
    if shells.total == 1:
        inverted = float(weights.sum()) < 0.0
        return np.ascontiguousarray(shells.triangles[:, :: -1 if inverted else 1]), 0.0
    volumes = np.bincount(shells.shell, weights=weights, minlength=shells.total).astype(
        np.float64
    )
    rank = np.argsort(np.argsort(-np.abs(volumes), kind="stable"))
    order = np.argsort(rank[shells.shell], kind="stable")
    ranked = shells._replace(
        triangles=shells.triangles[order], shell=rank[shells.shell][order]
    )
    volumes = volumes[np.argsort(rank)]
    outward, owner, doubled = _nesting(points, ranked, volumes)
    turn = (outward != (volumes > 0.0))[ranked.shell]
    triangles = np.empty_like(ranked.triangles)
    triangles[order] = np.where(
        turn[:, None], ranked.triangles[:, ::-1], ranked.triangles
    )
    body = owner[ranked.shell]
    if not doubled and not reach_into_each_other(points, ranked.triangles, body):
        return triangles, 0.0
    return triangles, _share_counted_twice(points, triangles[order], body)


def _share_counted_twice(points: Array, triangles: Index, body: Index) -> float:
    """Share of the volume of all bodies beyond that of their union; 1 where none is known."""
    from manifold3d import (
        Error,
        Manifold,
        Mesh64,
        OpType,
    )  # only bodies that overlap need it

    solids = [
        Manifold(Mesh64(points, triangles[body == number].astype(np.uint64)))
        for number in np.unique(body)
    ]
    whole = sum(solid.volume() for solid in solids)
    union = Manifold.batch_boolean(solids, OpType.Add)
    return 1.0 - union.volume() / whole if union.status() == Error.NoError else 1.0


def _nesting(points: Array, shells: Shells, volumes: Array) -> tuple[Mask, Index, bool]:
    """Apply the rules of the module's docstring to shells (S,) by falling volume, inward.

    Whether each has to bound material from outside; number of its body, of a void that of the body
    around it; whether one body lies in the metal of another.
    """
    parent = _parents(points, shells, volumes)
    outward = volumes > 0.0
    body = np.arange(shells.total)
    untold = np.zeros(shells.total, dtype=bool)
    doubled = False
    for shell, around in enumerate(parent.tolist()):
        if abs(volumes[shell]) <= _NO_VOLUME:
            body[shell] = 0  # a loose flap is nobody's second body
            continue
        in_metal = around >= 0 and outward[around]
        if around >= 0 and untold[around]:
            outward[shell] = not in_metal
            untold[shell] = True
        elif not in_metal and not outward[shell]:
            outward[shell] = untold[shell] = True
        doubled |= bool(in_metal and outward[shell])
        if not outward[shell]:
            body[shell] = body[around]
    return outward, body, doubled


def _parents(points: Array, shells: Shells, volumes: Array) -> Index:
    """Find the smallest shell around each (S,), -1 for none; shells by falling volume."""
    corners = points[shells.triangles]
    first = np.searchsorted(shells.shell, np.arange(shells.total + 1))
    low = np.minimum.reduceat(corners.min(axis=1), first[:-1])
    high = np.maximum.reduceat(corners.max(axis=1), first[:-1])
    parent = np.full(shells.total, -1)
    for shell in range(1, shells.total):
        check_patience()
        if abs(volumes[shell]) <= _NO_VOLUME:
            break
        around = np.flatnonzero(
            (low[:shell] <= low[shell] + OVERLAP).all(axis=1)
            & (high[:shell] >= high[shell] - OVERLAP).all(axis=1)
        )
        if len(around) == 0:
            continue
        own = slice(int(first[shell]), int(first[shell + 1]))
        inside = _inner_point(points, shells.triangles[own])
        if inside is None:
            continue
        parent[shell] = _smallest_around(points, shells, first, around, inside)
    return parent


def _smallest_around(
    points: Array, shells: Shells, first: Index, candidates: Index, inside: Array
) -> int:
    """Find the last of the candidates (rising) that encloses a point, -1 for none.

    It tends to be among the smallest: a few of these are asked first.
    """
    batch = _FEW
    while len(candidates):
        candidates, asked = candidates[:-batch], candidates[-batch:]
        near = np.concatenate([np.arange(first[k], first[k + 1]) for k in asked])
        x, y, z = inside.tolist()
        which, height, sign = crossings(points, shells.triangles[near], x, y)
        above = height > z
        enclosing = np.flatnonzero(
            np.bincount(shells.shell[near[which[above]]], weights=sign[above])
        )
        if len(enclosing):
            return int(enclosing.max())
        batch *= 4
    return -1


def _inner_point(points: Array, triangles: Index) -> Array | None:
    """Find a point well inside one shell: the middle of its widest vertical passage there."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u = b - a
    v = c - a
    widest = int(np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).argmax())
    x, y = ((a + b + c)[widest, :2] / 3.0).tolist()
    _, height, sign = crossings(points, triangles, x, y)
    if len(height) < 2:
        return None
    order = np.argsort(height, kind="stable")
    passage = np.diff(height[order]) * (np.cumsum(sign[order])[:-1] != 0)
    longest = int(passage.argmax())
    if passage[longest] <= 0.0:
        return None
    return np.array([x, y, height[order[longest]] + 0.5 * passage[longest]])
