"""A convex body from the planes of its faces, for a shape that is changed face by face.

The dual of a face n . x <= d is the point n / d; the facets of the hull of these points are the
corners of the body. What did not move comes back as it was: a corner close to one of the body
before is that corner.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from ..errors import MeshError
from ..kernels.body.convex_body import BodyArrays

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SNAP: Final = 2e-5
"""Corners this close, in radii, to one that was there before are that corner. Where more than
three faces meet in rounded coordinates, their planes miss each other by as much."""

SAME: Final = 1e-9
"""New corners this close are one."""


def corners_of_planes(normals: Array, distances: Array, before: Array) -> Array:
    """Corners (C, 3) of the body that planes bound.

    `normals` (K, 3): unit vectors, outward; `distances` (K,): from the origin, which lies inside.
    Planes that bound nothing are left out; `before` (H, 3): corners of the body that was changed.
    Raises MeshError if the origin is not inside, or the planes leave the body open.
    """
    if distances.min() <= 0.0:
        raise MeshError("faces around the centre of mass", "a face that was moved beyond it",
                        "change the part less")
    try:
        dual = ConvexHull(normals / distances[:, None]).equations
    except QhullError as error:
        raise MeshError("planes that bound a body", "planes that leave it open",
                        "change the part less") from error
    dual = np.unique(dual, axis=0)
    if dual[:, 3].max() >= 0.0:
        raise MeshError("planes that bound a body", "planes that leave it open",
                        "change the part less")
    corners = dual[:, :3] / -dual[:, 3:]
    gap, nearest = cKDTree(before).query(corners, distance_upper_bound=SNAP)
    stays = np.isfinite(gap)
    fresh = corners[~stays]
    if len(fresh):
        tree = cKDTree(fresh)
        first = np.arange(len(fresh))
        for one, other in sorted(tree.query_pairs(SAME)):
            first[other] = min(first[other], first[one])
        fresh = fresh[np.unique(first)]
    return np.ascontiguousarray(np.concatenate((before[np.unique(nearest[stays])], fresh)))


def plane_of_face(arrays: BodyArrays, normals: Array) -> Index:
    """Which of some planes (K, 3) each face (F,) of a body lies in; a body has none twice."""
    return np.asarray(cKDTree(normals).query(arrays.normal)[1], dtype=np.int64)


def fan_triangles(arrays: BodyArrays) -> Index:
    """Triangles (T, 3) of the faces of a body, wound outward, each face a fan."""
    sizes = np.diff(arrays.face_start)
    side = np.arange(arrays.corner.shape[0])
    place = side - arrays.face_start[arrays.face]
    inner = side[(place > 0) & (place < sizes[arrays.face] - 1)]
    first = arrays.face_start[arrays.face[inner]]
    return np.stack((arrays.corner[first], arrays.corner[inner], arrays.corner[inner + 1]), axis=1)
