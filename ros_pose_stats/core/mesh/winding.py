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

"""Closedness, shells and a consistent winding of a welded triangle mesh.

A surface is closed when every directed edge is balanced by its reverse. Triangles are
linked through the edges that exactly two of them share; such linked triangles form
patches, and a closed patch is a shell. Edges with four or more triangles, where bodies
touch along an edge, link patches only if those are not closed by themselves there.

Making the winding of a patch consistent is a two-colouring. It is found without walking
the mesh, as connected components of its double cover: each triangle stands there twice,
as given and turned round, and two copies are linked when they agree along a shared
edge.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.mesh.connections import component_labels, grouped_edges, linked_triangles
from ..records import Array, Index, Mask
from ..tolerances import WELD
from .vectors import area_vectors

# Most patches of shells with crowded edges that are examined, widest first.
_MOST_PATCHES = 256


class Edges(NamedTuple):
    """The directed edges of a mesh, grouped by the undirected edge they run along."""

    # (3T,); directed edges 3 t + i from corner i of triangle t on, sorted so
    edge: Index
    forward: Mask  # (3T,) bool; whether it runs from the lower to the higher vertex
    start: Index  # (E,); where each undirected edge begins in the two arrays above
    uses: Index  # (E,); how many triangles have that edge


class Shells(NamedTuple):
    """A closed surface, consistently wound within each of its shells."""

    triangles: Index  # (T, 3)
    shell: Index  # (T,); number of the shell of each triangle, 0, 1, ... without gaps
    shell_count: int


def find_shells(vertices: Array, triangles: Index) -> Shells | None:
    """Split triangles into shells and wind each as most of its area was.

    Repeated triangles are removed.

    None when the surface is open, one-sided, or of patches wound against each other.
    """
    triangles, edges = _distinct_triangles(triangles)
    if len(triangles) == 0 or (edges.uses & 1).any():
        return None
    pairs, agree = linked_triangles(*edges)
    patch = component_labels(len(triangles), pairs)
    if not agree.all():
        turn = _triangles_to_turn(vertices, triangles, pairs, agree)
        if turn is None:
            return None
        triangles = triangles.copy()
        triangles[turn] = triangles[turn, ::-1]
        edges = edges._replace(forward=edges.forward ^ turn[edges.edge // 3])
    if len(pairs) * 2 < len(edges.edge):
        shell = _join_patches(edges, patch)
        if not _is_balanced(edges, shell) or _has_both_senses(
            vertices, triangles, patch, shell
        ):
            return None
    else:
        shell = patch
    return Shells(triangles, shell, int(shell.max()) + 1)


def wind_alike(vertices: Array, triangles: Index) -> Index | None:
    """Linked triangles (U, 3) wound alike; none where that is impossible."""
    triangles, edges = _distinct_triangles(triangles)
    pairs, agree = linked_triangles(*edges)
    if agree.all():
        return triangles
    turn = _triangles_to_turn(vertices, triangles, pairs, agree)
    return (
        None if turn is None else np.where(turn[:, None], triangles[:, ::-1], triangles)
    )


def _distinct_triangles(triangles: Index) -> tuple[Index, Edges]:
    """Without repeated triangles where there may be any, and the edges."""
    edges = group_edges(triangles)
    if not (edges.uses > 2).any():
        return triangles, edges
    distinct = remove_repeated(triangles)
    return distinct, edges if len(distinct) == len(triangles) else group_edges(distinct)


def remove_repeated(triangles: Index) -> Index:
    """Remove triangles that occupy the same three vertices.

    Opposite ones are walls and vanish.

    Where every triangle has its opposite the mesh was exported double-sided, and the
    first stays.
    """
    corners = np.sort(triangles, axis=1)
    a, b, c = triangles.T
    is_odd = (a > b) ^ (b > c) ^ (a > c)
    order = np.lexsort((corners[:, 2], corners[:, 1], corners[:, 0]))
    is_new = np.ones(len(triangles), dtype=bool)
    is_new[1:] = (corners[order[1:]] != corners[order[:-1]]).any(axis=1)
    if is_new.all():
        return triangles
    group = np.cumsum(is_new) - 1
    has_odd = np.zeros(int(group[-1]) + 1, dtype=bool)
    has_even = has_odd.copy()
    has_odd[group[is_odd[order]]] = True
    has_even[group[~is_odd[order]]] = True
    is_wall = has_odd & has_even
    representatives = order[is_new]  # lexsort is stable: the first in the order given
    remaining: Index = representatives if is_wall.all() else representatives[~is_wall]
    return triangles[np.sort(remaining)]


def group_edges(triangles: Index) -> Edges:
    """Group the directed edges of triangles (T, 3) by undirected edge."""
    return Edges(*grouped_edges(np.ascontiguousarray(triangles)))


def _triangles_to_turn(
    vertices: Array, triangles: Index, pairs: Index, agree: Mask
) -> Mask | None:
    """Which triangles (T,) to turn round; None where no winding is consistent."""
    size = len(triangles)
    first, second = pairs.T
    swap = np.where(agree, 0, size)
    cover = np.concatenate(
        (
            np.stack((first, second + swap), axis=1),
            np.stack((first + size, second + size - swap), axis=1),
        )
    )
    side = component_labels(2 * size, cover)
    original_side = side[:size]
    turned_side = side[size:]
    if (original_side == turned_side).any():
        return None
    area = np.linalg.norm(area_vectors(vertices, triangles), axis=1)
    side_area = np.bincount(original_side, weights=area, minlength=int(side.max()) + 1)
    # Of the two sides of a patch the one that keeps more area; ties: the lower number.
    has_less = side_area[original_side] < side_area[turned_side]
    is_tie = side_area[original_side] == side_area[turned_side]
    is_turned: Mask = has_less | (is_tie & (original_side > turned_side))
    return is_turned


def _join_patches(edges: Edges, patch: Index) -> Index:
    """Shell of each triangle: patches that are not closed by themselves are joined."""
    edge, owner, _ = _crowded_edges(edges)
    patch_count = int(patch.max()) + 1
    _, pair, uses = np.unique(
        edge * patch_count + patch[owner], return_inverse=True, return_counts=True
    )
    is_closed = uses[pair] == 2
    edge_is_closed = np.ones(len(edges.start), dtype=bool)
    np.logical_and.at(edge_is_closed, edge, is_closed)
    follows = edge[1:] == edge[:-1]
    joints = np.flatnonzero(follows & ~edge_is_closed[edge[1:]])
    links = np.stack((patch[owner[joints]], patch[owner[joints + 1]]), axis=1)
    return component_labels(patch_count, links)[patch]


def _is_balanced(edges: Edges, shell: Index) -> bool:
    """Whether every shell runs both ways equally often along the crowded edges."""
    edge, owner, forward = _crowded_edges(edges)
    _, pair = np.unique(
        edge * (int(shell.max()) + 1) + shell[owner], return_inverse=True
    )
    return not np.bincount(pair, weights=np.where(forward, 1.0, -1.0)).any()


def _has_both_senses(
    vertices: Array, triangles: Index, patch: Index, shell: Index
) -> bool:
    """Whether a shell of several patches encloses space in both senses.

    Crowded edges may balance though one half is inside out; a vertical line shows it.
    """
    width = widths_seen_from_above(vertices, triangles)
    order = np.lexsort((-width, patch))
    representatives = order[
        np.searchsorted(patch[order], np.arange(int(patch.max()) + 1))
    ]
    patches = np.bincount(shell[representatives])
    representatives = representatives[
        (patches[shell[representatives]] > 1) & (width[representatives] > 0.0)
    ]
    representatives = representatives[
        np.argsort(-width[representatives], kind="stable")
    ][:_MOST_PATCHES]
    senses = np.zeros((int(shell.max()) + 1, 2), dtype=bool)
    for triangle in representatives:
        shell_triangles = triangles[shell == shell[triangle]]
        _, _, height, winding = passages_through(
            vertices, shell_triangles, triangles[triangle]
        )
        winding = winding[np.diff(height) > WELD * float(np.ptp(vertices[:, 2]))]
        senses[shell[triangle]] |= [(winding < 0).any(), (winding > 0).any()]
    return bool(senses.all(axis=1).any())


def _crowded_edges(edges: Edges) -> tuple[Index, Index, Mask]:
    """Undirected edge, triangle and sense of directed edges along crowded edges."""
    number = np.repeat(np.arange(len(edges.uses)), edges.uses)
    is_crowded = (edges.uses > 2)[number]
    return number[is_crowded], edges.edge[is_crowded] // 3, edges.forward[is_crowded]


def widths_seen_from_above(vertices: Array, triangles: Index) -> Array:
    """Twice the areas (T,) of triangles on a horizontal plane."""
    return np.abs(area_vectors(vertices, triangles)[:, 2])


def passages_through(
    vertices: Array, triangles: Index, triangle: Index
) -> tuple[float, float, Array, Index]:
    """Passages along the vertical line through the middle of a triangle (3,).

    Its x and y, the heights (k,) at which it crosses triangles, rising, and how often
    each passage from one height to the next (k - 1,) is enclosed.
    """
    a, b, c = vertices[triangle, :2]
    x, y = ((a + b + c) / 3.0).tolist()
    _, height, sign = find_crossings(vertices, triangles, x, y)
    order = np.argsort(height, kind="stable")
    return x, y, height[order], np.cumsum(sign[order])[:-1]


def find_crossings(
    vertices: Array, triangles: Index, x: float, y: float
) -> tuple[Index, Array, Index]:
    """Triangles crossed by the line at (x, y), heights, and +1 up or -1 down."""
    x_of_vertex = vertices[:, 0]
    y_of_vertex = vertices[:, 1]
    begin = triangles
    end = triangles[:, [1, 2, 0]]
    winding = np.zeros(len(triangles), dtype=np.int64)
    above_begin = y_of_vertex[begin] <= y
    above_end = y_of_vertex[end] <= y
    spans = above_begin != above_end
    row, column = np.nonzero(spans)
    lower = np.minimum(begin[row, column], end[row, column])
    higher = np.maximum(begin[row, column], end[row, column])
    rises = y_of_vertex[lower] < y_of_vertex[higher]
    turn = (x_of_vertex[higher] - x_of_vertex[lower]) * (y - y_of_vertex[lower]) - (
        x - x_of_vertex[lower]
    ) * (y_of_vertex[higher] - y_of_vertex[lower])
    crosses = np.where(rises, turn, -turn) > 0.0
    direction = np.where(above_begin[row, column], 1, -1)
    np.add.at(winding, row[crosses], direction[crosses])
    crossed = np.flatnonzero(winding)
    return crossed, heights_at(vertices[triangles[crossed]], x, y), winding[crossed]


def heights_at(corners: Array, x: Array | float, y: Array | float) -> Array:
    """Evaluate z at (x, y) on planes of triangles (k, 3, 3), within their corners."""
    a = corners[:, 0]
    u = corners[:, 1] - corners[:, 0]
    v = corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    dx = x - a[:, 0]
    dy = y - a[:, 1]
    divisor = np.where(area == 0.0, 1.0, area)
    s = (dx * v[:, 1] - dy * v[:, 0]) / divisor
    t = (u[:, 0] * dy - u[:, 1] * dx) / divisor
    height = a[:, 2] + s * u[:, 2] + t * v[:, 2]
    # A triangle that stands almost upright gives noise here; its corners bound it.
    clipped: Array = np.clip(
        height, corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    )
    return clipped
