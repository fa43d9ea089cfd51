"""The convex hull of a part, computed once.

Qhull works on points shifted to the centre of their bounding box and scaled to size one:
its own tolerances assume numbers of order one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from ..errors import MeshError
from ..kernels.extents import bounds, thinness
from ..records.part import Part
from ..tolerances import FLATTEST, SHAKEN
from .crowding import crowded


class Facets(NamedTuple):
    """What Qhull found.

    Attributes
    ----------
    points : (N, 3) array
        As given, not shaken.
    simplices : (M, 3) array
        Triangles, wound either way.
    neighbors : (M, 3) array
        Triangle opposite to each corner.
    equations : (M, 4) array
        Outward normal and offset of each triangle's plane.
    volume : float
    """

    points: NDArray[np.float64]
    simplices: NDArray[np.int32]
    neighbors: NDArray[np.int32]
    equations: NDArray[np.float64]
    volume: float

    @property
    def vertices(self) -> NDArray[np.int64]:
        """Points on the hull, rising."""
        on_hull = np.zeros(len(self.points), dtype=np.bool_)
        on_hull[self.simplices] = True
        return np.flatnonzero(on_hull)


class Hull(NamedTuple):
    """A convex hull in shifted and scaled coordinates.

    Attributes
    ----------
    qhull : Facets
        Of `(points - shift) / scale`; its indices are those of the points given.
    shift : (3,) array
        Centre of the bounding box, metres.
    scale : float
        Largest extent of the bounding box, metres.
    """

    qhull: Facets
    shift: NDArray[np.float64]
    scale: float


def hull_of(points: NDArray[np.float64]) -> Hull:
    """Convex hull of points in space.

    Parameters
    ----------
    points : (N, 3) array
        Metres, finite.

    Returns
    -------
    Hull

    Raises
    ------
    MeshError
        If the points lie in a plane.
    """
    points = np.ascontiguousarray(points)
    low, high = bounds(points)
    shift, scale = low + 0.5 * (high - low), float((high - low).max())
    try:
        qhull = _facets((points - shift) / scale)
    except (QhullError, ValueError) as error:
        raise MeshError("points that span a volume", f"{len(points)} points in a plane or line",
                        "check that the mesh is a solid part") from error
    return Hull(qhull, shift, scale)


def _facets(points: NDArray[np.float64]) -> Facets:
    """Run Qhull; on slightly moved points where a face is crowded."""
    # Flat points are no part; moved, they would seem to be one.
    if crowded(points) and thinness(points, *bounds(points)) >= FLATTEST:
        for step in SHAKEN:
            moves = np.random.default_rng(0).uniform(-step, step, points.shape)
            try:
                return _found(points, ConvexHull(points + moves))
            except QhullError:
                continue
    return _found(points, ConvexHull(points))


def _found(points: NDArray[np.float64], qhull: ConvexHull) -> Facets:
    return Facets(points, qhull.simplices, qhull.neighbors, qhull.equations, float(qhull.volume))


def hull_of_part(part: Part) -> Hull:
    """Convex hull of a part's `surface_vertices`, kept for as long as the part lives."""
    return part.prepare(_hull_of_surface)


def keep_hull(part: Part, hull: Hull) -> None:
    """Remember a hull that was computed from the part's `surface_vertices`."""
    part.keep(hull, _hull_of_surface)


def _hull_of_surface(part: Part) -> Hull:
    return hull_of(part.surface_vertices)
