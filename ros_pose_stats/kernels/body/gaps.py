"""Edges of a hull that lie on the surface of the mesh, and those that bridge a gap."""

from __future__ import annotations

import numpy as np

from ..array_types import Array, Fixed2, FixedIndex1, FixedIndex2, Index
from ..compilation import entry_kernel, inlined
from ..vectors import dot, length, minus, point_at, scaled


@entry_kernel
def edges_on_surface(vertices: Fixed2, triangles: FixedIndex2, ends: FixedIndex2,
                     first: FixedIndex1, order: FixedIndex1, tolerance: float) -> Index:
    """How many ends (E,) of each edge of the hull lie on an edge of the mesh that runs along it.

    An edge of the hull that is an edge of the mesh has two, and so has one that the mesh
    divides. Over a gap there are none.

    `vertices` (V, 3); `triangles` (T, 3): the mesh; `ends` (E, 2): vertices of the edges; `first`
    (V + 1,); `order` (2E,): ends by vertex: 2 e + i is end i of edge e, from `first[v]` on those
    at vertex v; `tolerance`: by how much vertices on an edge may be off its line.
    """
    seen = np.zeros(order.shape[0], np.bool_)
    for t in range(triangles.shape[0]):
        for i in range(3):
            a = triangles[t, i]
            if first[a] == first[a + 1]:
                continue
            for step in range(1, 3):
                b = triangles[t, (i + step) % 3]
                for k in range(first[a], first[a + 1]):
                    end = order[k]
                    if not seen[end]:
                        other = ends[end // 2, 1 - end % 2]
                        seen[end] = other == b or _is_along(vertices, a, b, other, tolerance)
    found = np.zeros(ends.shape[0], np.int64)
    for e in range(ends.shape[0]):
        found[e] = int(seen[2 * e]) + int(seen[2 * e + 1])
    return found


@inlined
def _is_along(vertices: Array, a: int, b: int, other: int, tolerance: float) -> bool:
    """Whether vertex b lies on the straight line between vertices a and other."""
    chord = minus(point_at(vertices, other), point_at(vertices, a))
    away = minus(point_at(vertices, b), point_at(vertices, a))
    share = dot(away, chord) / dot(chord, chord)
    if share >= 1.0:
        return False
    return length(minus(away, scaled(chord, max(share, 0.0)))) <= tolerance
