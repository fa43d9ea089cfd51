"""A coarse convex stand-in for a part, for pictures."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh.hull import hull_of
from ..records import Part
from .convex_body import convex_body

ENOUGH = 3000
"""Most points to choose from; with more a picture looks the same, but takes the node longer."""


HULL = 4000
"""Triangles of a hull that stands in for a mesh in a picture; more would not be visible."""


def decimated_hull(part: Part, most: int) -> NDArray[np.float64]:
    """Triangles of the convex hull, or of the hull of its farthest corners.

    Parameters
    ----------
    part : Part
    most : int
        Triangles, at least 4.

    Returns
    -------
    (t, 3, 3) array
        Corners in the part frame, metres, counter-clockwise seen from outside; t <= most.
    """
    body = convex_body(part, 0)
    points = body.points
    corners = most // 2 + 2  # a closed triangulation of n corners has 2 n - 4 triangles
    if len(points) > corners:
        few = _choose_outer(points)
        points = few[_spread_out(few, corners)]
    try:
        hull = hull_of(points)
    except MeshError:  # the chosen corners lie in a plane
        hull = hull_of(body.points)
    triangles = hull.qhull.simplices
    a, b, c = (hull.qhull.points[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.qhull.equations[:, :3]) < 0.0
    triangles = np.where(inward[:, None], triangles[:, ::-1], triangles)
    where = hull.qhull.points[triangles] * hull.scale + hull.shift
    return np.asarray(where * body.radius + part.center_of_mass)


def _choose_outer(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Choose at most `ENOUGH` of the points, with those farthest out to all sides."""
    if len(points) <= ENOUGH:
        return points
    sides = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    outermost = (points @ sides.T).argmax(axis=0)
    evenly = np.linspace(0, len(points) - 1, ENOUGH - len(sides)).astype(np.int64)
    return np.asarray(points[np.union1d(outermost, evenly)])


def _spread_out(points: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Choose `count` points (their numbers), each the farthest from those before it."""
    chosen = np.empty(count, dtype=np.int64)
    chosen[0] = int((points * points).sum(axis=1).argmax())
    nearest = np.full(len(points), np.inf)
    for k in range(1, count):
        away = points - points[chosen[k - 1]]
        nearest = np.minimum(nearest, (away * away).sum(axis=1))
        chosen[k] = int(nearest.argmax())
    return chosen


def visible_triangles(part: Part, most: int) -> NDArray[np.float64]:
    """Triangles to draw a part by: its surface, or a coarse convex hull of a larger mesh.

    Parameters
    ----------
    part : Part
    most : int
        Triangles, at least 4.

    Returns
    -------
    (t, 3, 3) array
        Corners in the part frame, metres, counter-clockwise seen from outside; t <= most.
    """
    if len(part.surface_triangles) <= most:
        return np.asarray(part.surface_vertices[part.surface_triangles])
    return decimated_hull(part, min(most, HULL))
