"""Welding: vertices that coincide become one, and what that leaves over is cleared away.

Files repeat a vertex for each triangle around it. All vertices are projected onto one
direction of incommensurable components: coincident vertices are neighbours in the sorted
projections, and few others are. Only neighbours are measured in space.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..tolerances import WELD
from .connectivity import components

# Square roots of primes, normalised: no lattice or symmetry plane projects onto one value.
_DIRECTION: Final = np.sqrt([2.0, 3.0, 5.0]) / np.sqrt(10.0)

# Neighbours looked at within a slab of foreign vertices with equal projection. More than a
# handful never occur unless a facet happens to be perpendicular to _DIRECTION to 1e-8.
_MOST_NEIGHBOURS: Final = 64


def weld(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Merge coincident vertices and drop the triangles that collapse.

    Parameters
    ----------
    vertices : (V, 3) array
    triangles : (T, 3) array

    Returns
    -------
    vertices : (W, 3) array
        Those in use, each the first of its coincident ones, in the order given; the very
        array given when nothing changes.
    triangles : (U, 3) array

    Notes
    -----
    Vertices within `WELD` of the largest extent are merged, transitively.
    """
    vertices, triangles = without_unused(vertices, triangles)
    if len(triangles) == 0:
        return vertices, triangles
    low = vertices.min(axis=0)
    extent = float((vertices.max(axis=0) - low).max())
    first = _first_of_coincident(vertices, vertices @ _DIRECTION, WELD * extent)
    if first is None:
        return without_unused(vertices, _without_collapsed(triangles))
    kept = first == np.arange(len(vertices))
    renumbered = np.cumsum(kept) - 1
    triangles = _without_collapsed(renumbered[first][triangles])
    return without_unused(vertices[kept], triangles)


def without_unused(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Leave out vertices of no triangle; the very arrays given when there are none."""
    used = np.zeros(len(vertices), dtype=bool)
    used[triangles.ravel()] = True
    if used.all():
        return vertices, triangles
    return vertices[used], (np.cumsum(used) - 1)[triangles]


def _without_collapsed(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Leave out triangles with a repeated corner."""
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    return triangles if whole.all() else triangles[whole]


def _first_of_coincident(
    vertices: NDArray[np.float64], along: NDArray[np.float64], tolerance: float
) -> NDArray[np.int64] | None:
    """For each vertex the lowest index among those it coincides with; None: all differ.

    Parameters
    ----------
    vertices : (V, 3) array
    along : (V,) array
        Projections onto a unit vector: never farther apart than the vertices.
    tolerance : float
    """
    order = np.argsort(along)
    sorted_along = along[order]
    close = np.diff(sorted_along) <= tolerance
    if not close.any():
        return None
    sorted_vertices = vertices[order]
    step = sorted_vertices[1:] - sorted_vertices[:-1]
    same = close & (np.einsum("ij,ij->i", step, step) <= tolerance * tolerance)
    run = np.concatenate(([0], np.cumsum(~same)))
    if not np.array_equal(close, same):
        # A foreign vertex has come between: look past it.
        apart = _pairs_past_foreign(sorted_vertices, sorted_along, close & ~same, tolerance)
        if len(apart):
            run = components(int(run[-1]) + 1, run[apart])[run]
    first = np.full(int(run.max()) + 1, len(vertices))
    np.minimum.at(first, run, order)
    label = np.empty(len(vertices), dtype=np.int64)
    label[order] = first[run]
    return label


def _pairs_past_foreign(
    vertices: NDArray[np.float64],
    along: NDArray[np.float64],
    foreign: NDArray[np.bool_],
    tolerance: float,
) -> NDArray[np.int64]:
    """Coincident pairs (k, 2) of sorted vertices that are not next to each other.

    Only slabs (runs of close projections) with a foreign neighbour in them are searched.
    """
    slab = np.concatenate(([0], np.cumsum(np.diff(along) > tolerance)))
    crowded = np.zeros(int(slab[-1]) + 1, dtype=bool)
    crowded[slab[1:][foreign]] = True
    here = np.flatnonzero(crowded[slab])
    found = [np.zeros((0, 2), dtype=np.int64)]
    for lag in range(2, _MOST_NEIGHBOURS + 1):
        here = here[here + lag < len(along)]
        here = here[along[here + lag] - along[here] <= tolerance]
        if len(here) == 0:
            break
        step = vertices[here + lag] - vertices[here]
        near = here[np.einsum("ij,ij->i", step, step) <= tolerance * tolerance]
        found.append(np.stack((near, near + lag), axis=1))
    return np.concatenate(found)


def without_repeated(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Clear away triangles that occupy the same three vertices.

    Parameters
    ----------
    triangles : (T, 3) array

    Returns
    -------
    (U, 3) array
        One of each orientation is kept. Opposite pairs are internal walls, where two bodies
        were joined, and vanish; unless every triangle has its opposite: then the mesh was
        exported double-sided and the first of each pair stays.
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
    kept: NDArray[np.int64] = first if wall.all() else first[~wall]
    return triangles[np.sort(kept)]
