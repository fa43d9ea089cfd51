"""Meshes that are large, slow to check, or both."""

from __future__ import annotations

import numpy as np
import trimesh

TRIANGLE_BYTES = 24
"""Of a closed mesh in flat arrays: half a vertex of 24 bytes and three indices of 4."""


def fine_box(triangles, length=0.04):
    """A box whose six faces are grids: many triangles, eight corners of the hull.

    Returns
    -------
    vertices : (V, 3) array
        Metres.
    triangles : (T, 3) array
        About as many as were asked for.
    """
    cells = max(1, round((triangles / 12) ** 0.5))
    ticks = np.arange(cells + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(ticks, ticks, indexing="ij"))
    faces = []
    for axis in range(3):
        for side in (0, cells):
            corners = np.empty((len(u), 3), dtype=np.int64)
            corners[:, axis] = side
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = (u, v) if side else (v, u)
            faces.append(corners)
    points = np.concatenate(faces)
    names = (points[:, 0] * (cells + 1) + points[:, 1]) * (cells + 1) + points[:, 2]
    _, first, place = np.unique(names, return_index=True, return_inverse=True)
    place = place.reshape(6, cells + 1, cells + 1)
    a, b, c, d = place[:, :-1, :-1], place[:, 1:, :-1], place[:, 1:, 1:], place[:, :-1, 1:]
    rows = np.concatenate([np.stack(one, -1).reshape(-1, 3) for one in ((a, b, c), (a, c, d))])
    sides = np.array([1.0, 0.75, 0.5]) * length
    return points[first] / cells * sides, rows.astype(np.uint32)


def smooth_body(triangles, length=0.04):
    """An ellipsoid: every vertex is a corner of the hull."""
    rings = max(4, round((triangles / 4) ** 0.5))
    ball = trimesh.creation.uv_sphere(count=[rings, rings])
    return (np.asarray(ball.vertices) * [0.5, 0.4, 0.3] * length,
            np.asarray(ball.faces, dtype=np.uint32))
