# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""A part's surface in fewer triangles, for pictures."""

import numpy as np

from ..records import Array, Corners, Part
from .arrays import remove_collapsed
from .vectors import area_vectors

# Triangles that a picture of some hundred pixels shows as well as the whole mesh
FINEST = 20_000

TOLERANCES = 2.0 ** np.arange(-13.0, -0.75, 0.25)
"""Of decimation, in extents: from a fraction of a pixel up to half of the part. Small
steps leave more of the shape: twice as large ones displace the thread of a screw by
half as much again."""


def visible_triangles(part: Part, limit: int = FINEST) -> Array:
    """Triangles (t, 3, 3) to draw a part by, metres: at most `limit`.

    Of open meshes both sides.
    """
    vertices, triangles = _surface_to_draw(part)
    is_open = part.is_open
    if is_open:
        limit //= 2
    if len(triangles) > limit:
        vertices, triangles = part.prepare(_decimated_surface, limit)
    corners = vertices[triangles]
    return (
        np.concatenate([corners, corners[:, ::-1]]) if is_open else np.asarray(corners)
    )


def thin_out(corners: Array, limit: int) -> Array:
    """At most `limit` triangles in place of those (t, 3, 3) that a part is drawn by."""
    points, point = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    vertices, triangles = decimate(points, point.reshape(-1, 3), limit)
    return np.asarray(vertices[triangles])


def _surface_to_draw(part: Part) -> tuple[Array, Corners]:
    if not part.is_open:
        return part.surface_vertices, part.surface_triangles
    return part.vertices, remove_collapsed(part.triangles)


def _decimated_surface(part: Part, limit: int) -> tuple[Array, Corners]:
    surface = _surface_to_draw(part)
    if limit < FINEST < len(surface[1]):
        # A large mesh is gone through once, for all sizes.
        surface = part.prepare(_decimated_surface, FINEST)
    return decimate(*surface, limit)


def decimate(vertices: Array, triangles: Corners, limit: int) -> tuple[Array, Corners]:
    """Collapse edges within growing tolerances, then keep the largest triangles."""
    from manifold3d import Manifold, Mesh64  # loaded for pictures alone

    extent = float(np.ptp(vertices, axis=0).max()) or 1.0
    # In no plane of the mesh.
    apex = vertices.max(axis=0) + extent * np.array([3.0, 5.0, 7.0])
    cone = _cone(triangles, len(vertices))
    # More rims have only meshes of loose triangles and pairs.
    if len(cone) <= len(triangles):
        closed_triangles = np.concatenate([triangles, cone]).astype(np.uint64)
        body = Manifold(
            Mesh64(np.concatenate([vertices, apex[None]]), closed_triangles)
        )
        for tolerance in extent * TOLERANCES:
            body = body.simplify(tolerance)
            mesh = body.to_mesh64()
            points = np.array(mesh.vert_properties)
            remaining = np.array(mesh.tri_verts, dtype=np.int64)
            remaining = remaining[(points[remaining] != apex).any(axis=2).all(axis=1)]
            if len(remaining) == 0:
                break
            vertices = points
            triangles = remaining
            if len(triangles) <= limit:
                return vertices, triangles
    areas = (area_vectors(vertices / extent, triangles) ** 2).sum(axis=1)
    return vertices, triangles[np.sort(np.argsort(-areas, kind="stable")[:limit])]


def _cone(triangles: Corners, apex: int) -> Corners:
    """Triangles (r, 3) from all rims of a mesh to an apex, as the modeller demands."""
    ends = np.concatenate(
        [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
    )
    ends = ends.astype(np.int64)
    edges, edge = np.unique(
        ends.min(axis=1) * apex + ends.max(axis=1), return_inverse=True
    )
    surplus = np.bincount(edge, np.sign(ends[:, 1] - ends[:, 0])).astype(np.int64)
    low = edges // apex
    high = edges % apex
    rims = np.stack(
        [
            np.where(surplus > 0, high, low),
            np.where(surplus > 0, low, high),
            np.full_like(low, apex),
        ],
        axis=1,
    )
    return np.repeat(rims, abs(surplus), axis=0)
