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

"""Triangles in a tree of boxes: which of them are near a point.

Nodes stand in the order of a walk from the root, first child first, and each says where
the walk goes on if its box is left out: a search needs no stack.
"""

from typing import NamedTuple

import numpy as np

from ..array_types import Array, Array2, Index, Index1
from ..compilation import inlined, kernel
from ..vectors import Vec3, add, cross, dot, length, scale, subtract, triangle_at

LEAF = 4
"""Most triangles of a leaf."""

DEEPEST = 64
"""Divisions, after which triangles whose centres coincide stay together."""


SLIVER = 16.0
"""Area of a box's three faces over that of the triangle in it, from which on that is a
sliver. An isosceles right triangle has at most 5.3, whichever way it is turned; one of
a fan across a cap of n corners has some n, and the boxes of a fan overlap."""


class TriangleTree(NamedTuple):
    """Boxes around triangles."""

    box: Array2  # (N, 6) lowest, then highest corner of each node
    begin: Index1  # (N,) of its triangles in `order`; -1 for a node with children
    end: Index1  # (N,)
    skip: Index1  # (N,) node that follows where this one is left out
    order: Index1  # (T,) triangles, by leaf


@kernel
def triangle_tree(points: Array, triangles: Index, margins: Array) -> TriangleTree:
    """Put triangles into boxes that are wider by their margins (T,)."""
    count = triangles.shape[0]
    low = np.empty((count, 3))
    high = np.empty((count, 3))
    for t in range(count):
        for c in range(3):
            a = points[triangles[t, 0], c]
            b = points[triangles[t, 1], c]
            d = points[triangles[t, 2], c]
            low[t, c] = min(a, min(b, d)) - margins[t]
            high[t, c] = max(a, max(b, d)) + margins[t]
    tree = TriangleTree(
        np.empty((2 * count, 6)),
        np.full(2 * count, -1, np.int64),
        np.full(2 * count, -1, np.int64),
        np.zeros(2 * count, np.int64),
        np.arange(count),
    )
    # Ranges still to be divided: begin, end, depth.
    stack = np.empty((2 * DEEPEST, 3), np.int64)
    stack[0] = (0, count, 0)
    fitting = _put_slivers_last(tree.order, points, triangles)
    size = 1
    nodes = 0
    while size > 0:
        size -= 1
        begin, end, depth = stack[size]
        middle = begin
        if depth == 0 and 0 < fitting < count:
            middle = fitting
        elif end - begin > LEAF and depth < DEEPEST:
            middle = _divide(tree.order, low, high, begin, end)
        if middle in (begin, end):
            tree.begin[nodes] = begin
            tree.end[nodes] = end
        else:
            stack[size] = (middle, end, depth + 1)
            stack[size + 1] = (begin, middle, depth + 1)
            size += 2
        # Nodes of a range follow each other, so that the end of one begins the next.
        tree.skip[nodes] = end
        nodes += 1
    _set_skips(tree, nodes)
    # Behind each node are its children: the first follows it, the second that one.
    for node in range(nodes - 1, -1, -1):
        if tree.begin[node] >= 0:
            _enclose_leaf(tree, node, low, high)
        else:
            _enclose_children(tree, node)
    return tree


@kernel
def _put_slivers_last(order: Index, points: Array, triangles: Index) -> int:
    """Sort the order by whether triangles are slivers; return how many are none.

    A search ends with the first triangle that is near. Where a rim's point is on a wall
    as well as on a fan, it is found without a walk through the boxes of the fan.
    """
    fitting = 0
    for k in range(order.shape[0]):
        a, b, c = triangle_at(points, triangles, order[k])
        x = max(a.x, b.x, c.x) - min(a.x, b.x, c.x)
        y = max(a.y, b.y, c.y) - min(a.y, b.y, c.y)
        z = max(a.z, b.z, c.z) - min(a.z, b.z, c.z)
        area = 0.5 * length(cross(subtract(b, a), subtract(c, a)))
        if x * y + y * z + z * x < SLIVER * area:
            order[fitting], order[k] = order[k], order[fitting]
            fitting += 1
    return fitting


@inlined
def _enclose_leaf(tree: TriangleTree, node: int, low: Array, high: Array) -> None:
    for c in range(3):
        lowest = low[tree.order[tree.begin[node]], c]
        highest = high[tree.order[tree.begin[node]], c]
        for k in range(tree.begin[node] + 1, tree.end[node]):
            lowest = min(lowest, low[tree.order[k], c])
            highest = max(highest, high[tree.order[k], c])
        tree.box[node, c] = lowest
        tree.box[node, 3 + c] = highest


@inlined
def _enclose_children(tree: TriangleTree, node: int) -> None:
    first = node + 1
    second = tree.skip[first]
    for c in range(3):
        tree.box[node, c] = min(tree.box[first, c], tree.box[second, c])
        tree.box[node, 3 + c] = max(tree.box[first, 3 + c], tree.box[second, 3 + c])


@kernel
def _divide(order: Index, low: Array, high: Array, begin: int, end: int) -> int:
    """Divide a range at the middle of its longest extent; return where."""
    axis = 0
    widest = -1.0
    middle = 0.0
    for c in range(3):
        lowest = highest = low[order[begin], c] + high[order[begin], c]
        for k in range(begin + 1, end):
            center = low[order[k], c] + high[order[k], c]
            lowest = min(lowest, center)
            highest = max(highest, center)
        if highest - lowest > widest:
            widest = highest - lowest
            middle = 0.5 * (lowest + highest)
            axis = c
    k = begin
    last = end
    while k < last:
        if low[order[k], axis] + high[order[k], axis] < middle:
            k += 1
        else:
            last -= 1
            order[k], order[last] = order[last], order[k]
    return k


@kernel
def _set_skips(tree: TriangleTree, nodes: int) -> None:
    """Turn the end of each node's range into the node after it."""
    node_at = np.full(tree.order.shape[0] + 1, nodes, np.int64)
    for node in range(nodes - 1, -1, -1):
        end = tree.skip[node]
        tree.skip[node] = node_at[end]
        # Of several nodes that begin at one triangle the first is the widest.
        begin = _first_of(tree, node)
        node_at[begin] = node


@inlined
def _first_of(tree: TriangleTree, node: int) -> int:
    """First position in `order` below a node."""
    while tree.begin[node] < 0:
        node += 1
    return int(tree.begin[node])


@inlined
def is_in_box(tree: TriangleTree, node: int, point: Vec3, reach: float) -> bool:
    """Whether a point is within a reach of a node's box."""
    box = tree.box
    return (
        box[node, 0] - reach <= point.x <= box[node, 3] + reach
        and box[node, 1] - reach <= point.y <= box[node, 4] + reach
        and box[node, 2] - reach <= point.z <= box[node, 5] + reach
    )


@inlined
def square_distance(point: Vec3, a: Vec3, b: Vec3, c: Vec3) -> float:
    """Square of the distance of a point from a triangle.

    Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    ab = subtract(b, a)
    ac = subtract(c, a)
    normal = cross(ab, ac)
    square = dot(normal, normal)
    nearest = min(
        _square_to_edge(point, a, b),
        min(_square_to_edge(point, b, c), _square_to_edge(point, c, a)),
    )
    if square > 0.0:
        offset = subtract(point, a)
        v = dot(cross(offset, ac), normal)
        w = dot(cross(ab, offset), normal)
        if v >= 0.0 and w >= 0.0 and v + w <= square:
            height = dot(offset, normal) / length(normal)
            nearest = min(nearest, height * height)
    return nearest


@inlined
def _square_to_edge(point: Vec3, a: Vec3, b: Vec3) -> float:
    """Square of the distance of a point from the line between two others."""
    edge = subtract(b, a)
    square = dot(edge, edge)
    share = 0.0
    if square > 0.0:
        share = min(max(dot(subtract(point, a), edge) / square, 0.0), 1.0)
    offset = subtract(point, add(a, scale(edge, share)))
    return dot(offset, offset)
