"""A part's surface in fewer triangles, for pictures."""

import numpy as np
from numpy.typing import NDArray

from ..records import Part

Array = NDArray[np.float64]
Index = NDArray[np.uint32]

FINEST = 20_000
"""Triangles that a picture of some hundred pixels shows as well as the whole mesh."""

WHOLE_EXTENT = 1.0
"""Largest error that decimation may make, in extents: none is too large, the number counts."""


def visible_triangles(part: Part, most: int = FINEST) -> Array:
    """Triangles to draw a part by: its surface, decimated where that has too many.

    `most`: triangles, at least 100; with fewer no shape is left. Returns (t, 3, 3): corners in the
    part frame, metres, each one of the part's own vertices; t <= most. Counter-clockwise seen from
    outside; an open mesh is drawn as received, not as the hull that stands in for it, with each of
    its triangles wound both ways.
    """
    vertices, triangles = _drawn_surface(part)
    is_open = _is_open(part)
    if is_open:
        most //= 2
    if len(triangles) > most:
        triangles = part.prepare(_fewer_triangles, most)
    corners = vertices[triangles]
    return np.concatenate([corners, corners[:, ::-1]]) if is_open else np.asarray(corners)


def _is_open(part: Part) -> bool:
    return any(warning.startswith("OPEN_MESH:") for warning in part.warnings)


def _drawn_surface(part: Part) -> tuple[Array, NDArray[np.integer]]:
    if not _is_open(part):
        return part.surface_vertices, part.surface_triangles
    a, b, c = part.triangles.T
    return part.vertices, part.triangles[(a != b) & (b != c) & (c != a)]


def _fewer_triangles(part: Part, most: int) -> Index:
    vertices, triangles = _drawn_surface(part)
    if most < FINEST < len(triangles):  # a large mesh is gone through once, for all sizes
        triangles = part.prepare(_fewer_triangles, FINEST)
    return decimate(vertices, triangles, most)


def decimate(vertices: Array, triangles: NDArray[np.integer], most: int) -> Index:
    """Collapse edges of a mesh, those first that change its shape least.

    `vertices` (V, 3); `triangles` (T, 3): of any mesh, also open, of many bodies, or with edges of
    more than two triangles. Returns (t, 3) uint32: into the same vertices; t <= most. Where no
    edge can be collapsed without tearing the mesh, the largest triangles are left.
    """
    from meshoptimizer import simplify  # loaded for pictures alone

    low, high = vertices.min(axis=0), vertices.max(axis=0)
    extent = float((high - low).max()) or 1.0
    places = np.ascontiguousarray((vertices - low) / extent, dtype=np.float32)
    given = np.ascontiguousarray(triangles, dtype=np.uint32).reshape(-1)
    found = np.empty_like(given)
    count = simplify(found, given, places, target_index_count=3 * most,
                     target_error=WHOLE_EXTENT)
    left: Index = found[:count].reshape(-1, 3)
    if len(left) > most:
        left = left[_largest(places[left], most)]
    return left.copy()


def _largest(corners: NDArray[np.float32], count: int) -> NDArray[np.int64]:
    """Numbers of the largest triangles, in their order."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = (normals * normals).sum(axis=1)
    return np.sort(np.argsort(-areas, kind="stable")[:count])
