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

"""What hangs together in a mesh: triangles across edges, and components.

Directed edge 3 t + i runs from corner i of triangle t to the next one. Directed edges
are grouped by the undirected edge that they run along.
"""

import numpy as np

from ..array_types import FixedFlags1, FixedIndex1, FixedIndex2, Flags, Index
from ..compilation import entry_kernel, inlined, kernel
from ..sorting import rising_order

# columns of the sorted entries (3T, 2)
HIGHER_VERTEX = 0  # higher vertex
EDGE = 1  # twice the number of the directed edge, plus 1 where it runs from the lower

INSERTION_LIMIT = 48
"""Edges at one vertex up to which sorting them one by one is quicker than counting
digits.
"""


@entry_kernel
def grouped_edges(triangles: FixedIndex2) -> tuple[Index, Flags, Index, Index]:
    """Directed edges by their lower, then higher vertex: see `mesh.winding.Edges`."""
    entries, stop = _sorted_edges(triangles)
    count = entries.shape[0]
    edge = np.empty(count, np.int64)
    forward = np.empty(count, np.bool_)
    start = np.empty(count, np.int64)
    uses = np.empty(count, np.int64)
    groups = begin = 0
    for v in range(stop.shape[0]):
        for k in range(begin, stop[v]):
            edge[k] = entries[k, EDGE] // 2
            forward[k] = entries[k, EDGE] & 1 == 1
            if k == begin or entries[k, HIGHER_VERTEX] != entries[k - 1, HIGHER_VERTEX]:
                start[groups] = k
                uses[groups] = 0
                groups += 1
            uses[groups - 1] += 1
        begin = stop[v]
    return edge, forward, start[:groups].copy(), uses[:groups].copy()


@kernel
def _sorted_edges(triangles: Index) -> tuple[Index, Index]:
    """Directed edges (3T, 2) by lower, then higher vertex; where each lower ends.

    Counting puts the edges in order by the lower vertex. Few share it as a rule, so
    these are put in order by the higher one one by one.
    """
    vertices = 0
    for t in range(triangles.shape[0]):
        for i in range(3):
            vertices = max(vertices, triangles[t, i] + 1)
    position = np.zeros(vertices + 1, np.int64)
    for t in range(triangles.shape[0]):
        a = triangles[t, 0]
        b = triangles[t, 1]
        c = triangles[t, 2]
        position[min(a, b) + 1] += 1
        position[min(b, c) + 1] += 1
        position[min(c, a) + 1] += 1
    for v in range(vertices):
        position[v + 1] += position[v]
    entries = np.empty((triangles.size, 2), np.int64)
    for t in range(triangles.shape[0]):
        for i in range(3):
            a = triangles[t, i]
            b = triangles[t, i + 1 if i < 2 else 0]
            index = position[min(a, b)]
            position[min(a, b)] = index + 1
            entries[index, HIGHER_VERTEX] = max(a, b)
            entries[index, EDGE] = 2 * (3 * t + i) + (1 if a < b else 0)
    begin = 0
    for v in range(vertices):
        if position[v] - begin > INSERTION_LIMIT:
            _sort_by_digits(entries, begin, position[v])
        else:
            _sort_by_insertion(entries, begin, position[v])
        begin = position[v]
    return entries, position[:vertices]


@kernel
def _sort_by_digits(entries: Index, begin: int, end: int) -> None:
    """Sort a range of entries by their first number; equal ones stay as they were."""
    unsorted = entries[begin:end].copy()
    position = begin
    for i in rising_order(unsorted[:, HIGHER_VERTEX].copy()):
        entries[position, HIGHER_VERTEX] = unsorted[i, HIGHER_VERTEX]
        entries[position, EDGE] = unsorted[i, EDGE]
        position += 1


@inlined
def _sort_by_insertion(entries: Index, begin: int, end: int) -> None:
    """Sort a short range of entries by their first number; equal ones stay."""
    for k in range(begin + 1, end):
        vertex = entries[k, HIGHER_VERTEX]
        edge = entries[k, EDGE]
        j = k - 1
        while j >= begin and entries[j, HIGHER_VERTEX] > vertex:
            entries[j + 1, HIGHER_VERTEX], entries[j + 1, EDGE] = (
                entries[j, HIGHER_VERTEX],
                entries[j, EDGE],
            )
            j -= 1
        entries[j + 1, HIGHER_VERTEX] = vertex
        entries[j + 1, EDGE] = edge


@entry_kernel
def linked_triangles(
    edge: FixedIndex1, forward: FixedFlags1, start: FixedIndex1, uses: FixedIndex1
) -> tuple[Index, Flags]:
    """Triangle pairs (k, 2) across edges of two, and whether their windings agree."""
    pairs = np.empty((start.shape[0], 2), np.int64)
    agree = np.empty(start.shape[0], np.bool_)
    count = 0
    for e in range(start.shape[0]):
        if uses[e] == 2:
            k = start[e]
            pairs[count, 0] = edge[k] // 3
            pairs[count, 1] = edge[k + 1] // 3
            agree[count] = forward[k] != forward[k + 1]
            count += 1
    return pairs[:count].copy(), agree[:count].copy()


@kernel
def triangle_neighbours(triangles: Index) -> Index:
    """Triangle (T, 3) across the side opposite to each vertex; -1 unless two meet."""
    entries, stop = _sorted_edges(triangles)
    neighbours = np.full(triangles.shape, -1, np.int64)
    begin = 0
    for v in range(stop.shape[0]):
        while begin < stop[v]:
            end = begin + 1
            while (
                end < stop[v]
                and entries[end, HIGHER_VERTEX] == entries[begin, HIGHER_VERTEX]
            ):
                end += 1
            if end - begin == 2:
                h = entries[begin, EDGE] // 2
                opposite = entries[begin + 1, EDGE] // 2
                neighbours[h // 3, (h + 2) % 3] = opposite // 3
                neighbours[opposite // 3, (opposite + 2) % 3] = h // 3
            begin = end
    return neighbours


@inlined
def find_representative(link: Index, a: int) -> int:
    """Representative of the set of `a`; `link` is shortened on the way."""
    while link[a] != a:
        link[a] = link[link[a]]
        a = link[a]
    return a


@inlined
def join_sets(link: Index, a: int, b: int) -> None:
    """Unite the sets of `a` and `b`; the lowest member represents each set."""
    a = find_representative(link, a)
    b = find_representative(link, b)
    if a < b:
        link[b] = a
    else:
        link[a] = b


@entry_kernel
def component_labels(count: int, pairs: FixedIndex2) -> Index:
    """Component (count,) of each node: 0, 1, ... by the components' lowest nodes."""
    link = np.arange(count)
    for k in range(pairs.shape[0]):
        join_sets(link, pairs[k, 0], pairs[k, 1])
    labels = np.empty(count, np.int64)
    components = 0
    for i in range(count):
        lowest = find_representative(link, i)
        if lowest == i:
            labels[i] = components
            components += 1
        else:
            labels[i] = labels[lowest]
    return labels


@entry_kernel
def merge_corners(
    representative: FixedIndex1, triangles: FixedIndex2
) -> tuple[Index, Index]:
    """Vertices (W,) that are left, rising, and triangles (U, 3) between them.

    `representative` (V,): what each vertex is merged into. Triangles that collapse are
    left out, and vertices of no other triangle with them.
    """
    number = np.full(representative.shape[0], -1, np.int64)
    remaining = np.empty(triangles.shape, np.int64)
    count = 0
    for t in range(triangles.shape[0]):
        a = representative[triangles[t, 0]]
        b = representative[triangles[t, 1]]
        c = representative[triangles[t, 2]]
        if a != b and b != c and c != a:
            remaining[count] = (a, b, c)
            number[a] = number[b] = number[c] = 0
            count += 1
    kept = np.flatnonzero(number == 0)
    for k in range(kept.shape[0]):
        number[kept[k]] = k
    for t in range(count):
        for i in range(3):
            remaining[t, i] = number[remaining[t, i]]
    return kept, remaining[:count].copy()
