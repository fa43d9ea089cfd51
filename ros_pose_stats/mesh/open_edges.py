"""The open edges of a mesh and the loops that they form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.mesh.connections import component_labels


class OpenEdges(NamedTuple):
    """Edges that lack a triangle, directed as that triangle would run along them."""

    begin: NDArray[np.int64]  # (E,); vertices
    end: NDArray[np.int64]
    beside: NDArray[np.int64]  # (E,); the third vertex of the triangle that is there
    # (E,); which fan of linked triangles around the vertex it borders on
    begin_fan: NDArray[np.int64]
    end_fan: NDArray[np.int64]


def open_edges(triangles: NDArray[np.int64]) -> OpenEdges | None:
    """Find the edges that lack a triangle.

    `triangles` (T, 3): linked ones wound alike. Returns none where an edge lacks several
    triangles, or has too many that run one way.
    """
    begin, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    after = np.arange(len(begin)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    order = np.lexsort((high, low))
    new = np.ones(len(order), dtype=bool)
    new[1:] = (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0)
    first = np.flatnonzero(new)
    uses = np.diff(np.append(first, len(order)))
    surplus = np.add.reduceat(np.where(begin < end, 1, -1)[order], first)
    if (np.abs(surplus) > 1).any():
        return None
    one, two = order[first[uses == 2]], order[first[uses == 2] + 1]
    links = np.concatenate((np.stack((one, after[two]), axis=1),
                            np.stack((after[one], two), axis=1)))
    fan = component_labels(len(begin), links)
    lacking = np.flatnonzero(surplus)
    # Of three along an edge any one of the surplus direction stands for the edge.
    excess = (np.where(begin < end, 1, -1)[order] == np.repeat(surplus, uses))
    place = np.flatnonzero(excess)
    owner = order[place[np.searchsorted(place, first[lacking])]]
    return OpenEdges(end[owner], begin[owner], end[after[owner]], fan[after[owner]], fan[owner])


def join_loops(edges: OpenEdges) -> list[NDArray[np.int64]]:
    """Join open edges to loops.

    Where two holes touch at a vertex, a loop goes on along the hole, not along the fan of
    triangles by which it came.

    Returns the edges of each loop, which meets no vertex twice.
    """
    leaving: dict[int, list[int]] = {}
    for edge, vertex in enumerate(edges.begin.tolist()):
        leaving.setdefault(vertex, []).append(edge)
    begin, end = edges.begin.tolist(), edges.end.tolist()
    loops = []
    for start in begin:
        path: list[int] = []
        at: dict[int, int] = {}
        vertex, fan = start, -1
        while leaving[vertex]:
            at[vertex] = len(path)
            ways = leaving[vertex]
            other = next((k for k, way in enumerate(ways) if edges.begin_fan[way] != fan), 0)
            edge = ways.pop(other)
            path.append(edge)
            vertex, fan = end[edge], int(edges.end_fan[edge])
            if vertex in at:
                loop = path[at[vertex]:]
                del path[at[vertex]:]
                loops.append(np.array(loop))
                for one in loop:
                    del at[begin[one]]
                if path:
                    fan = int(edges.end_fan[path[-1]])
    return loops
