"""Which facets of a body are those of one round or toothed surface that it rolls on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..kernels.body.convex_body import BodyArrays
from .coaxial import ON_AXIS, Group, loops_of, off_axis
from .reshaping import Chain

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def strips(points: Array, arrays: BodyArrays, groups: Sequence[Group], chains: Sequence[Chain]
           ) -> Index:
    """Number the strips of facets between two runs about one axis, or a run and a tip.

    `points` (H, 3); `chains`: their rims, as they stand in this body. Returns (F,) int: number of
    the strip of each face, from 0 on; -1 for a face of none.
    """
    found = np.full(len(arrays.area), -1, dtype=np.int64)
    count = 0
    for number, group in enumerate(groups):
        mine = [chain for chain in chains if chain.rim.group == number]
        count = _number_strips(points, arrays, group, mine, found, count)
    return found


def _number_strips(points: Array, arrays: BodyArrays, group: Group, chains: Sequence[Chain],
                   found: Index, count: int) -> int:
    """Number the strips about one axis from `count` on, in place; return the next number."""
    rim, place, size = np.full((3, len(points)), -1, dtype=np.int64)
    tips = np.flatnonzero(off_axis(points, group) < ON_AXIS)
    rim[tips] = len(chains)
    is_corner = np.zeros(len(points), dtype=np.bool_)
    is_corner[arrays.corner] = True
    for k, chain in enumerate(chains):
        there = chain.point[is_corner[chain.point]]
        rim[there], place[there] = k, np.arange(len(there))
        size[there] = len(there) if chain.closed else -1
    faces = np.unique(arrays.face[rim[arrays.corner] >= 0])
    corner, begin = loops_of(arrays, faces)
    sizes = np.diff(np.append(begin, len(corner)))
    following = np.roll(corner, -1)
    following[begin + sizes - 1] = corner[begin]
    low, high = (one.reduceat(rim[corner], begin) for one in (np.minimum, np.maximum))
    fits = (rim[corner] == np.repeat(low, sizes)) | (rim[corner] == np.repeat(high, sizes))
    apart = np.abs(place[corner] - place[following])
    fits &= (rim[corner] != rim[following]) | (apart == 1) | (apart == size[corner] - 1)
    strip = np.logical_and.reduceat(fits, begin) & (low >= 0) & (low < high)
    if not strip.any():
        return count
    pair = low[strip] * (len(chains) + 1) + high[strip]
    numbers = np.unique(pair, return_inverse=True)[1]
    found[faces[strip]] = count + numbers
    return count + int(numbers.max()) + 1
