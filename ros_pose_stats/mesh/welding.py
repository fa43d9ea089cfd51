"""Welding: coincident vertices are merged, and collapsed or repeated triangles removed."""

import numpy as np

from ..kernels.mesh import measures, nearness
from ..records import Array, Index
from ..tolerances import WELD


def weld(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Merge vertices within `WELD` of the largest extent and drop triangles that collapse.

    Returns the first of coincident vertices; the very array given when nothing changes.
    """
    vertices, triangles = without_unused(vertices, triangles)
    if len(triangles) == 0:
        return vertices, triangles
    low, high = measures.bounds(vertices)
    extent = float((high - low).max())
    if extent == 0.0:
        return vertices[:1], triangles[:0]
    found, first = nearness.first_of_coincident(vertices, low, WELD * extent)
    if not found:
        return without_unused(vertices, _without_collapsed(triangles))
    kept = first == np.arange(len(vertices))
    renumbered = np.cumsum(kept) - 1
    triangles = _without_collapsed(renumbered[first][triangles])
    return without_unused(vertices[kept], triangles)


def without_unused(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Leave out vertices of no triangle; the very arrays given when there are none."""
    used = np.zeros(len(vertices), dtype=bool)
    used[triangles.ravel()] = True
    if used.all():
        return vertices, triangles
    return vertices[used], (np.cumsum(used) - 1)[triangles]


def _without_collapsed(triangles: Index) -> Index:
    """Leave out triangles with a repeated corner."""
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    return triangles if whole.all() else triangles[whole]


def without_repeated(triangles: Index) -> Index:
    """Remove triangles that occupy the same three vertices; one of each orientation stays.

    Opposite pairs are internal walls and vanish; unless every triangle has its opposite: then the
    mesh was exported double-sided and the first stays.
    """
    corners = np.sort(triangles, axis=1)
    a, b, c = triangles.T
    odd = (a > b) ^ (b > c) ^ (a > c)
    order = np.lexsort((corners[:, 2], corners[:, 1], corners[:, 0]))
    new = np.ones(len(triangles), dtype=bool)
    new[1:] = (corners[order[1:]] != corners[order[:-1]]).any(axis=1)
    if new.all():
        return triangles
    group = np.cumsum(new) - 1
    has_odd = np.zeros(int(group[-1]) + 1, dtype=bool)
    has_even = has_odd.copy()
    has_odd[group[odd[order]]] = True
    has_even[group[~odd[order]]] = True
    wall = has_odd & has_even
    first = order[new]  # lexsort is stable: the first in the order given
    kept: Index = first if wall.all() else first[~wall]
    return triangles[np.sort(kept)]
