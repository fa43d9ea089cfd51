"""The convex hull of a part, computed once.

Qhull works on points shifted to the centre of their bounding box and scaled to size one:
its own tolerances assume numbers of order one.
"""

from __future__ import annotations

import threading
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from ..errors import MeshError
from ..records.part import Part


class Hull(NamedTuple):
    """A convex hull in shifted and scaled coordinates.

    Attributes
    ----------
    qhull : scipy.spatial.ConvexHull
        Of `(points - shift) / scale`; its indices are those of the points given.
    shift : (3,) array
        Centre of the bounding box, metres.
    scale : float
        Largest extent of the bounding box, metres.
    """

    qhull: ConvexHull
    shift: NDArray[np.float64]
    scale: float


_HULLS: WeakKeyDictionary[Part, Hull] = WeakKeyDictionary()
_LOCK = threading.Lock()


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
    low, high = points.min(axis=0), points.max(axis=0)
    shift, scale = low + 0.5 * (high - low), float((high - low).max())
    try:
        qhull = ConvexHull((points - shift) / scale)
    except (QhullError, ValueError) as error:
        raise MeshError("points that span a volume", f"{len(points)} points in a plane or line",
                        "check that the mesh is a solid part") from error
    return Hull(qhull, shift, scale)


def hull_of_part(part: Part) -> Hull:
    """Convex hull of a part's `surface_vertices`, kept for as long as the part lives.

    Two threads that ask for the same part for the first time may both compute it; they get
    equal answers.
    """
    with _LOCK:
        known = _HULLS.get(part)
    if known is not None:
        return known
    hull = hull_of(part.surface_vertices)
    keep_hull(part, hull)
    return hull


def keep_hull(part: Part, hull: Hull) -> None:
    """Remember a hull that was computed from the part's `surface_vertices`."""
    with _LOCK:
        _HULLS[part] = hull
