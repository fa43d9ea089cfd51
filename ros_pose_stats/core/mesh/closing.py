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

"""Small holes are closed by caps, and it is bounded how wrong the caps can be.

The edges that a triangle is missing at form closed loops. Each simple loop gets a cap
that has no corners of its own, triangulated as seen along the normal of the loop; loops
in one plane are capped together, so that the lost face of a tube is a ring.

Where caps would be a guess there are none: over a sheet, through the surface, or over
the two rims of a bore whose wall is lost.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ...base import text
from .. import tolerances
from ..kernels.mesh import connections
from ..records import Array, Index
from . import vectors, winding
from .bodies import overlap

LARGEST_SHARE = 0.5
"""Largest area of all caps, as a fraction of the other triangles'. A hemisphere lacks
just that; a sheet would need caps as large as itself."""

SAME_PLANE = 1e-4
"""Most difference of components of the unit normals, and of distances in sizes, in one
plane."""

_FEWEST_AROUND = 6  # fewest edges around a bore

_SLIT = 1e-18
"""Square of the area, over the fourth power of the length, of a loop that has no
width."""

_MOST_OPEN_EDGES = 1.0
"""Open edges a triangle from which on a mesh is loose triangles rather than a
surface."""


class Closing(NamedTuple):
    """What came of closing the holes of a mesh."""

    # the closed surface; None where it is not plain how to close it
    shells: winding.Shells | None
    problem: str = ""  # why there is none, to go on from "the mesh"
    holes: int = 0  # loops of open edges
    # largest volume that other caps without corners of their own may add or remove:
    # that of the convex hulls of the loops
    open_volume: float = 0.0
    # of the widest cap, or ring of caps, as a fraction of the mesh's size
    width: float = 0.0


def close_holes(
    vertices: Array, scaled: vectors.UnitPoints, triangles: Index
) -> Closing:
    """Close the holes of a mesh whose vertices are welded, and `scaled` to size one."""
    surface = winding.wind_alike(vertices, triangles)
    if surface is None:
        return Closing(None, "is one-sided like a Möbius strip")
    edges = find_open_edges(surface)
    if edges is None:
        return Closing(None, "has edges that several triangles share in no order")
    if len(edges.begin) == 0:
        return Closing(None, "encloses no solid")
    if len(edges.begin) > _MOST_OPEN_EDGES * len(surface):
        return Closing(None, "is made of loose triangles")
    rims = join_loops(edges)
    loops = [edges.begin[rim] for rim in rims]
    holes = text.several(len(loops), "hole")
    points, _, size = scaled
    if _has_lost_wall(points, edges, rims):
        return Closing(None, f"has {holes}, of which two may be the ends of one bore")
    groups = _group_coplanar(points, loops)
    caps = [_cap(points, plane_loops) for plane_loops in groups]
    closed_surface = np.concatenate([surface, *caps])
    if vectors.surface_area(
        points, closed_surface[len(surface) :]
    ) > LARGEST_SHARE * vectors.surface_area(points, surface):
        return Closing(
            None, f"is a sheet, with {holes}, rather than the surface of a solid"
        )
    cap_of_triangle = np.repeat(
        np.arange(len(caps) + 1), [len(surface), *map(len, caps)]
    )
    if overlap.reach_into_each_other(points, closed_surface, cap_of_triangle):
        return Closing(None, f"has {holes}, whose caps would cross the surface")
    shells = winding.find_shells(vertices, closed_surface)
    if shells is None:
        return Closing(None, f"has {holes}, which touch in more than one way")
    volume = sum(_hull_volume(points[loop]) for loop in loops)
    width = max(
        _width(points, plane_loops, cap)
        for plane_loops, cap in zip(groups, caps, strict=True)
    )
    return Closing(shells, "", len(loops), volume * size * size * size, width)


def _width(points: Array, loops: Sequence[Index], cap: Index) -> float:
    """Twice the area of a cap over the length of its loops.

    That is the width of a slit or a ring, and the radius of a disc.
    """
    length = sum(
        float(vectors.lengths(points[loop] - points[np.roll(loop, -1)]).sum())
        for loop in loops
    )
    return 2.0 * vectors.surface_area(points, cap) / length


def _has_lost_wall(points: Array, edges: "OpenEdges", rims: Sequence[Index]) -> bool:
    """Whether two rims within flat faces have one shape: ends of a lost bore."""
    shapes: list[tuple[Array, Array, Array]] = []
    for rim in rims:
        if len(rim) < _FEWEST_AROUND:
            continue
        corners = points[edges.begin[rim]]
        neighbours = points[edges.neighbour[rim]]
        normal = vectors.loop_normal(corners)
        center = corners.sum(axis=0) / len(rim)
        offsets = np.concatenate((corners, neighbours)) - center
        if np.abs((offsets * normal).sum(axis=1)).max() > tolerances.COPLANAR:
            continue
        distances = np.sort(vectors.lengths(corners - center))
        distances /= distances[-1]
        for rim_distances, rim_center, rim_normal in shapes:
            height = float(((center - rim_center) * rim_normal).sum())
            if abs(height) <= tolerances.COPLANAR or len(distances) != len(
                rim_distances
            ):
                continue
            if np.allclose(rim_distances, distances, 0.0, 1e-3):
                return True
        shapes.append((distances, center, normal))
    return False


def _group_coplanar(points: Array, loops: Sequence[Index]) -> list[list[Index]]:
    """Loops that lie in one plane together, each of the others alone."""
    planes: list[Array] = []
    groups: list[list[Index]] = []
    for loop in loops:
        normal = vectors.loop_normal(points[loop]) if len(loop) > 3 else np.zeros(3)
        heights = (points[loop] * normal).sum(axis=1)
        plane: Array = np.full(4, np.nan)  # of a loop alone: equal to none
        if normal.any() and float(np.ptp(heights)) < tolerances.COPLANAR:
            plane = np.append(normal, heights.mean())
        for group_plane, group in zip(planes, groups, strict=True):
            if _is_same_plane(plane, group_plane):
                group.append(loop)
                break
        else:
            planes.append(plane)
            groups.append([loop])
    return groups


def _is_same_plane(first: Array, second: Array) -> bool:
    """Whether planes (4,), each a normal and a distance, are one from either side."""
    return bool(
        (np.abs(first - second) < SAME_PLANE).all()
        or (np.abs(first + second) < SAME_PLANE).all()
    )


def _cap(points: Array, loops: Sequence[Index]) -> Index:
    """Triangles that close one loop, or several that lie in a plane."""
    if len(loops) == 1 and len(loops[0]) == 3:
        return loops[0][None]
    from manifold3d import triangulate  # only open meshes need it

    axes = _projection_axes(points, loops)
    projections = [(points[loop][:, :, None] * axes).sum(axis=1) for loop in loops]
    return np.asarray(np.concatenate(loops)[triangulate(projections)])


def _projection_axes(points: Array, loops: Sequence[Index]) -> Array:
    """Two axes (3, 2) of the plane onto which loops are projected, the largest's."""
    spokes = points[loops[0]] - points[loops[0][0]]
    longest_spoke = spokes[vectors.lengths(spokes).argmax()]
    normals = np.array([vectors.loop_area(points[loop]) for loop in loops])
    normal = normals[vectors.lengths(normals).argmax()]
    if (
        float((normal * normal).sum())
        > _SLIT * float((longest_spoke * longest_spoke).sum()) ** 2
    ):
        # The coordinate axis farthest from it.
        direction = np.eye(3)[np.abs(normal).argmin()]
    else:
        # Any plane that holds the slit will do.
        direction = longest_spoke
        normal = np.cross(longest_spoke, np.eye(3)[np.abs(longest_spoke).argmin()])
    second_axis = np.cross(normal, direction)
    axes = np.array([np.cross(second_axis, normal), second_axis])
    return vectors.unit_vectors(axes).T


def _hull_volume(corners: Array) -> float:
    """Volume of the convex hull of a loop (n, 3); 0 where it is flat."""
    try:
        return float(ConvexHull(corners).volume)
    except QhullError:
        return 0.0


class OpenEdges(NamedTuple):
    """Edges that lack a triangle, directed as that triangle would run along them."""

    begin: Index  # (E,); vertices
    end: Index
    neighbour: Index  # (E,); the third vertex of the triangle that is there
    # (E,); which fan of linked triangles around the vertex it borders on
    begin_fan: Index
    end_fan: Index


def find_open_edges(triangles: Index) -> OpenEdges | None:
    """Edges that lack a triangle, of triangles (T, 3) wound alike.

    None where some lack more.
    """
    begin = triangles.ravel()
    end = triangles[:, [1, 2, 0]].ravel()
    next_edge = np.arange(len(begin)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    order, forward, group_start, uses = winding.group_edges(triangles)
    sense = np.where(forward, 1, -1)
    surplus = np.add.reduceat(sense, group_start)
    if (np.abs(surplus) > 1).any():
        return None
    first_of_pair = order[group_start[uses == 2]]
    second_of_pair = order[group_start[uses == 2] + 1]
    links = np.concatenate(
        (
            np.stack((first_of_pair, next_edge[second_of_pair]), axis=1),
            np.stack((next_edge[first_of_pair], second_of_pair), axis=1),
        )
    )
    fan = connections.component_labels(len(begin), links)
    open_groups = np.flatnonzero(surplus)
    # Of three along an edge any one of the surplus direction stands for the edge.
    candidates = np.flatnonzero(sense == np.repeat(surplus, uses))
    representative = order[
        candidates[np.searchsorted(candidates, group_start[open_groups])]
    ]
    return OpenEdges(
        end[representative],
        begin[representative],
        end[next_edge[representative]],
        fan[next_edge[representative]],
        fan[representative],
    )


def join_loops(edges: OpenEdges) -> list[Index]:
    """Join open edges to loops, each of which meets no vertex twice.

    Where two holes touch, a loop goes on along its hole, not the fan of triangles it
    came by.
    """
    edges_from: dict[int, list[int]] = {}
    for edge, vertex in enumerate(edges.begin.tolist()):
        edges_from.setdefault(vertex, []).append(edge)
    begin = edges.begin.tolist()
    end = edges.end.tolist()
    loops = []
    for start in begin:
        path: list[int] = []
        position: dict[int, int] = {}
        vertex = start
        fan = -1
        while edges_from[vertex]:
            position[vertex] = len(path)
            exits = edges_from[vertex]
            along_hole = [
                k for k, edge in enumerate(exits) if edges.begin_fan[edge] != fan
            ]
            choice = along_hole[0] if along_hole else 0
            edge = exits.pop(choice)
            path.append(edge)
            vertex = end[edge]
            fan = int(edges.end_fan[edge])
            if vertex in position:
                loop = path[position[vertex] :]
                del path[position[vertex] :]
                loops.append(np.array(loop))
                for loop_edge in loop:
                    del position[begin[loop_edge]]
                if path:
                    fan = int(edges.end_fan[path[-1]])
    return loops
