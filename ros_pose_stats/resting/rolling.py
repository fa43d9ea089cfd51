"""Which facets of a body are those of one round or toothed surface that it rolls on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..kernels.body.convex_body import BodyArrays
from .reshaping import ON_AXIS, Chain
from .round_surfaces import Group

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def strips(points: Array, arrays: BodyArrays, groups: Sequence[Group], chains: Sequence[Chain]
           ) -> Index:
    """Number the strips of facets between two runs about one axis, or a run and a tip.

    Parameters
    ----------
    points : (H, 3) array
    arrays : BodyArrays
    groups : sequence of Group
    chains : sequence of Chain
        Their rims, as they stand in this body.

    Returns
    -------
    (F,) array of int
        Number of the strip of each face, from 0 on; -1 for a face of none.
    """
    found = np.full(len(arrays.area), -1, dtype=np.int64)
    is_corner = np.zeros(len(points), dtype=np.bool_)
    is_corner[arrays.corner] = True
    count = 0
    for number, group in enumerate(groups):
        mine = [chain for chain in chains if chain.rim.group == number]
        count = _number_strips(points, arrays, group, mine, is_corner, found, count)
    return found


def _number_strips(points: Array, arrays: BodyArrays, group: Group, chains: Sequence[Chain],
                   is_corner: NDArray[np.bool_], found: Index, count: int) -> int:
    """Number the strips about one axis from `count` on, in place; return the next number."""
    many = len(chains) + 1
    rim = np.full(len(points), -1, dtype=np.int64)
    place, size = np.zeros_like(rim), np.zeros_like(rim)
    away = points - group.center
    x, y = (away * group.frame[0]).sum(axis=1), (away * group.frame[1]).sum(axis=1)
    rim[x * x + y * y < ON_AXIS * ON_AXIS] = many - 1
    for k, chain in enumerate(chains):
        there = chain.point[is_corner[chain.point]]
        rim[there], place[there] = k, np.arange(len(there))
        size[there] = len(there) if chain.closed else -1
    begin, ends = arrays.face_start[:-1], arrays.corner
    low = np.minimum.reduceat(rim[ends], begin)
    high = np.maximum.reduceat(rim[ends], begin)
    following = ends[arrays.twin]  # where a side ends, its twin starts
    fits = (rim[ends] == low[arrays.face]) | (rim[ends] == high[arrays.face])
    apart = np.abs(place[ends] - place[following])
    fits &= (rim[ends] != rim[following]) | (apart == 1) | (apart == size[ends] - 1)
    strip = np.logical_and.reduceat(fits, begin) & (low >= 0) & (low < high)
    if not strip.any():
        return count
    _, numbers = np.unique(low[strip] * (many + 1) + high[strip], return_inverse=True)
    found[strip] = count + numbers
    return count + int(numbers.max()) + 1
