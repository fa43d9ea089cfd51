"""Closedness, shells and a consistent winding of a welded triangle mesh.

A surface is closed when every directed edge is balanced by its reverse. Triangles are
linked through the edges that exactly two of them share; such linked triangles form
patches, and a closed patch is a shell. Edges with four or more triangles, where bodies
touch along an edge, link patches only if those are not closed by themselves there.

Making the winding of a patch consistent is a two-colouring. It is found without walking the
mesh, as connected components of its double cover: each triangle stands there twice, as given
and turned round, and two copies are linked when they agree along a shared edge.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.mesh.connections import component_labels, grouped_edges, linked_triangles
from ..records import Array, Index, Mask
from ..tolerances import WELD

# Most patches of shells with crowded edges that are examined, widest first.
_MOST_PATCHES = 256


class Edges(NamedTuple):
    """The directed edges of a mesh, grouped by the undirected edge they run along."""

    edge: (
        Index  # (3T,); directed edges 3 t + i from corner i of triangle t on, sorted so
    )
    forward: Mask  # (3T,) bool; whether it runs from the lower to the higher vertex
    start: Index  # (E,); where each undirected edge begins in the two arrays above
    uses: Index  # (E,); how many triangles have that edge


class Shells(NamedTuple):
    """A closed surface, consistently wound within each of its shells."""

    triangles: Index  # (T, 3)
    shell: Index  # (T,); number of the shell of each triangle, 0, 1, ... without gaps
    total: int


def closed_shells(vertices: Array, triangles: Index) -> Shells | None:
    """Remove repeated triangles, split the rest into shells and wind each as most of its area was.

    None when the surface is open, one-sided, or of patches wound against each other.
    """
    triangles, edges = _cleared(triangles)
    if len(triangles) == 0 or (edges.uses & 1).any():
        return None
    pairs, agree = linked_triangles(*edges)
    patch = component_labels(len(triangles), pairs)
    if not agree.all():
        turn = _turned(vertices, triangles, pairs, agree)
        if turn is None:
            return None
        triangles = triangles.copy()
        triangles[turn] = triangles[turn, ::-1]
        edges = edges._replace(forward=edges.forward ^ turn[edges.edge // 3])
    if len(pairs) * 2 < len(edges.edge):
        shell = _joined_patches(edges, patch)
        if not _balanced(edges, shell) or _mixed(vertices, triangles, patch, shell):
            return None
    else:
        shell = patch
    return Shells(triangles, shell, int(shell.max()) + 1)


def wound_alike(vertices: Array, triangles: Index) -> Index | None:
    """Linked triangles (U, 3) wound alike; none where that is impossible."""
    triangles, edges = _cleared(triangles)
    pairs, agree = linked_triangles(*edges)
    if agree.all():
        return triangles
    turn = _turned(vertices, triangles, pairs, agree)
    return (
        None if turn is None else np.where(turn[:, None], triangles[:, ::-1], triangles)
    )


def _cleared(triangles: Index) -> tuple[Index, Edges]:
    """Without repeated triangles where there may be any, and the edges."""
    edges = edges_of(triangles)
    if not (edges.uses > 2).any():
        return triangles, edges
    cleared = without_repeated(triangles)
    return cleared, edges if len(cleared) == len(triangles) else edges_of(cleared)


def without_repeated(triangles: Index) -> Index:
    """Remove triangles that occupy the same three vertices; opposite ones are walls and vanish.

    Where every triangle has its opposite the mesh was exported double-sided, and the first stays.
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
    kept: Index = first if wall.all() else first[~wall]
    return triangles[np.sort(kept)]


def edges_of(triangles: Index) -> Edges:
    """Group the directed edges of triangles (T, 3) by undirected edge."""
    return Edges(*grouped_edges(np.ascontiguousarray(triangles)))


def _turned(
    vertices: Array, triangles: Index, pairs: Index, agree: Mask
) -> Mask | None:
    """Which triangles (T,) to turn round; None where no winding is consistent."""
    size = len(triangles)
    left, right = pairs.T
    swap = np.where(agree, 0, size)
    cover = np.concatenate(
        (
            np.stack((left, right + swap), axis=1),
            np.stack((left + size, right + size - swap), axis=1),
        )
    )
    side = component_labels(2 * size, cover)
    as_given = side[:size]
    turned = side[size:]
    if (as_given == turned).any():
        return None
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept_area = np.bincount(as_given, weights=area, minlength=int(side.max()) + 1)
    # Of the two sides of a patch the one that keeps more area; ties: the lower number.
    lose = kept_area[as_given] < kept_area[turned]
    tie = kept_area[as_given] == kept_area[turned]
    outcome: Mask = lose | (tie & (as_given > turned))
    return outcome


def _joined_patches(edges: Edges, patch: Index) -> Index:
    """Shell of each triangle: patches joined where they are not closed by themselves."""
    edge, owner, _ = _crowded(edges)
    patch_count = int(patch.max()) + 1
    _, where, times = np.unique(
        edge * patch_count + patch[owner], return_inverse=True, return_counts=True
    )
    alone = times[where.ravel()] == 2
    crowded_alone = np.ones(len(edges.start), dtype=bool)
    np.logical_and.at(crowded_alone, edge, alone)
    follows = edge[1:] == edge[:-1]
    join = np.flatnonzero(follows & ~crowded_alone[edge[1:]])
    links = np.stack((patch[owner[join]], patch[owner[join + 1]]), axis=1)
    return component_labels(patch_count, links)[patch]


def _balanced(edges: Edges, shell: Index) -> bool:
    """Whether every shell runs both ways equally often along the crowded edges."""
    edge, owner, forward = _crowded(edges)
    _, where = np.unique(
        edge * (int(shell.max()) + 1) + shell[owner], return_inverse=True
    )
    return not np.bincount(where.ravel(), weights=np.where(forward, 1.0, -1.0)).any()


def _mixed(vertices: Array, triangles: Index, patch: Index, shell: Index) -> bool:
    """Whether a shell of several patches encloses space in both senses.

    Crowded edges may balance though one half is inside out; a vertical line shows it.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    u = b - a
    v = c - a
    wide = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    order = np.lexsort((-wide, patch))
    widest = order[np.searchsorted(patch[order], np.arange(int(patch.max()) + 1))]
    patches = np.bincount(shell[widest])
    widest = widest[(patches[shell[widest]] > 1) & (wide[widest] > 0.0)]
    widest = widest[np.argsort(-wide[widest], kind="stable")][:_MOST_PATCHES]
    senses = np.zeros((int(shell.max()) + 1, 2), dtype=bool)
    for triangle in widest:
        same = triangles[shell == shell[triangle]]
        x, y = ((a + b + c)[triangle, :2] / 3.0).tolist()
        _, height, sign = crossings(vertices, same, x, y)
        upward = np.argsort(height, kind="stable")
        passage = np.diff(height[upward]) > WELD * float(np.ptp(vertices[:, 2]))
        winding = np.cumsum(sign[upward])[:-1][passage]
        senses[shell[triangle]] |= [(winding < 0).any(), (winding > 0).any()]
    return bool(senses.all(axis=1).any())


def _crowded(edges: Edges) -> tuple[Index, Index, Mask]:
    """Undirected edge, triangle and sense of each directed edge along edges of more than two."""
    number = np.repeat(np.arange(len(edges.uses)), edges.uses)
    crowded = (edges.uses > 2)[number]
    return number[crowded], edges.edge[crowded] // 3, edges.forward[crowded]


def crossings(
    vertices: Array, triangles: Index, x: float, y: float
) -> tuple[Index, Array, Index]:
    """Triangles crossed by the line at (x, y), at which height, and +1 upward or -1 downward."""
    across = vertices[:, 0]
    along = vertices[:, 1]
    begin = triangles
    end = triangles[:, [1, 2, 0]]
    winding = np.zeros(len(triangles), dtype=np.int64)
    above_begin = along[begin] <= y
    above_end = along[end] <= y
    spans = above_begin != above_end
    row, column = np.nonzero(spans)
    lower = np.minimum(begin[row, column], end[row, column])
    higher = np.maximum(begin[row, column], end[row, column])
    rises = along[lower] < along[higher]
    turn = (across[higher] - across[lower]) * (y - along[lower]) - (
        x - across[lower]
    ) * (along[higher] - along[lower])
    crosses = np.where(rises, turn, -turn) > 0.0
    direction = np.where(above_begin[row, column], 1, -1)
    np.add.at(winding, row[crosses], direction[crosses])
    which = np.flatnonzero(winding)
    return which, _heights(vertices[triangles[which]], x, y), winding[which]


def _heights(corners: Array, x: float, y: float) -> Array:
    """Evaluate z at (x, y) on the planes of triangles (k, 3, 3), never beyond their corners."""
    a = corners[:, 0]
    u = corners[:, 1] - corners[:, 0]
    v = corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    dx = x - a[:, 0]
    dy = y - a[:, 1]
    safe = np.where(area == 0.0, 1.0, area)
    s = (dx * v[:, 1] - dy * v[:, 0]) / safe
    t = (u[:, 0] * dy - u[:, 1] * dx) / safe
    height = a[:, 2] + s * u[:, 2] + t * v[:, 2]
    # A triangle that stands almost upright gives noise here; its corners bound it.
    bounded: Array = np.clip(
        height, corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    )
    return bounded
