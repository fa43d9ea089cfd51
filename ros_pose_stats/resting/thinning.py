"""Fewer corners for bodies whose free form is finer than what they roll on."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..kernels.body.convex_body import BodyArrays
from ..kernels.body.hull import outermost_corners
from ..kernels.principal_axes import principal_axes
from ..mesh.vectors import scatter
from .reshaping import Outline
from .side_counts import COARSEST, ENOUGH

FINE: Final = 1000
"""Corners off all runs up to which a body stays as the file has it: it is quick enough."""

GRID: Final = 7
"""Directions a turn for every five sides: so that the deepest corner left out is no deeper."""

TIE: Final = 1e-7
"""Corners this close to the farthest, in radii, are as far: the other end of a straight edge."""


def thin_out(outline: Outline, arrays: BodyArrays, sides: int) -> None:
    """Leave out corners off all reshaped runs of a body that has very many, in place.

    What stays lies farthest out in one of many directions, as far apart as those of a polygon of
    `sides`, or of fewer, but not below `COARSEST`, while there are more corners than `ENOUGH`. The
    directions are mirrored at the principal planes, so that a symmetric body stays so.

    `arrays`: the body as the file has it.
    """
    taken = np.zeros(len(outline.points), dtype=np.bool_)
    for chain in outline.chains:
        if chain.sides or chain.rim.kind == "toothed":
            taken[chain.point[chain.point < len(taken)]] = True
    free = outline.keeps & ~taken
    if free.sum() <= FINE:
        return
    others = outline.count - len(outline.points) + int((outline.keeps & taken).sum())
    first, beside = _neighbours(arrays, len(outline.points))
    axes = np.ascontiguousarray(principal_axes(scatter(outline.points[arrays.corner]))[1].T)
    poles = axes
    for twelfths in range(12, 3, -1):
        level = sides * twelfths // 12
        if level < COARSEST and twelfths < 12:
            break
        grid = GRID * level // 5
        if twelfths == 12:
            # Over a rim about the poles there are the fewest directions: a prism's axis is there.
            turned = [np.roll(axes, turn, axis=0) for turn in range(3)]
            found = [outermost_corners(outline.points, first, beside, one, grid, TIE)
                     for one in turned]
            counts = [int((one & free).sum()) for one in found]
            best = counts.index(min(counts))
            poles, chosen = turned[best], found[best]
        else:
            chosen = outermost_corners(outline.points, first, beside, poles, grid, TIE)
        if (chosen & free).sum() + others <= ENOUGH:
            break
    outline.changed |= bool((free & ~chosen).any())
    outline.keeps &= chosen | taken


def _neighbours(arrays: BodyArrays, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Neighbours of each corner over the edges: where they begin, and their numbers."""
    first = np.zeros(count + 1, dtype=np.int64)
    np.cumsum(np.bincount(arrays.corner, minlength=count), out=first[1:])
    order = np.argsort(arrays.corner, kind="stable")
    return first, arrays.corner[arrays.twin[order]]
