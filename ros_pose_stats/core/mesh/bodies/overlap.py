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

"""Whether bodies reach into each other.

They do when an edge of one pierces a triangle of another by more than a tolerance.
Edges and triangles are divided together by planes across the axes; in each division
only what lies within the box around the other bodies is kept. Short lists are tested in
one go.

A passage through the rim of a triangle proves nothing by itself: bars laid across each
other have it where they merely touch, a cross of two equal bars where they overlap.
Such a passage counts when a point next to it, just inside the first body, is inside the
second too.
"""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from ...records import Array, Index, Mask
from ...tolerances import OVERLAP
from ..vectors import cross, unit_vectors
from ..winding import find_crossings

# Edge-triangle pairs tested at once: below this a division costs more than it saves.
_AT_ONCE = 40_000

# A division that leaves more than this share of the pairs is given up.
_WORTHWHILE = 0.7

# Handling one element in a division takes about as long as testing this many pairs.
_DIVISION_COST = 15

# Most pairs looked at for each triangle, of few triangles and of any number (a
# twentieth of a microsecond each). Only meshes of long slivers that lie all along each
# other get there; what is left then goes untested.
_PAIRS_EACH = 400
_FEWEST_PAIRS = 2_000_000
_MOST_PAIRS = 150_000_000

# A passage this far beyond the box around a triangle is not one through its rim.
_BESIDE = 4.0 * OVERLAP

# Most passages through rims that are examined; each takes a pass over the whole mesh.
_MOST_RIMS = 64


class _Elements(NamedTuple):
    """Edges or triangles."""

    low: Array  # (N, 3); boxes around them
    high: Array
    # (N, 3); vertex numbers; the third one of an edge is the far corner of a triangle
    # at it
    corners: Index
    body: Index  # (N,)

    def pick(self, mask: Mask) -> "_Elements":
        return self if mask.all() else _Elements._make(column[mask] for column in self)


class _Passages(NamedTuple):
    """Where edges pierce triangles, ways to their inner ends, the bodies pierced."""

    point: Array
    to_inner_end: Array
    edge: Index
    body: Index
    in_rim: Mask


def reach_into_each_other(points: Array, triangles: Index, body: Index) -> bool:
    """Whether bodies of size one reach into each other by more than `OVERLAP`."""
    if (body == body[0]).all():
        return False
    begin = triangles.ravel()
    end = triangles[:, [1, 2, 0]]
    opposite = triangles[:, [2, 0, 1]]
    is_forward = begin < end.ravel()  # a closed surface runs along each edge both ways
    corners = np.stack((begin, end.ravel(), opposite.ravel()), axis=1)[is_forward]
    divisions = [
        (
            _with_boxes(points, corners, 2, np.repeat(body, 3)[is_forward]),
            _with_boxes(points, triangles, 3, body),
        )
    ]
    budget = min(max(_PAIRS_EACH * len(triangles), _FEWEST_PAIRS), _MOST_PAIRS)
    rims = _MOST_RIMS
    while divisions and budget > 0:
        check_patience()
        edges, faces = divisions.pop()
        faces = faces.pick(_reach_others(faces, edges))
        edges = edges.pick(_reach_others(edges, faces))
        pairs = len(edges.body) * len(faces.body)
        budget -= _DIVISION_COST * (len(edges.body) + len(faces.body))
        halves = None if pairs <= _AT_ONCE else _divide(edges, faces)
        if halves is not None:
            divisions += halves
            continue
        for tested, passages in _find_passages(points, edges, faces):
            check_patience()
            if not passages.in_rim.all():
                return True
            for k in range(min(rims, len(passages.body))):
                if _leads_inside(
                    points, triangles[body == passages.body[k]], passages, k
                ):
                    return True
            rims -= min(rims, len(passages.body))
            budget -= tested
            if budget <= 0:
                break
    return False


def _with_boxes(points: Array, corners: Index, count: int, body: Index) -> _Elements:
    """Elements with boxes around the first `count` of their corners."""
    low = high = points[corners[:, 0]]
    for k in range(1, count):
        points_of_corner = points[corners[:, k]]
        low = np.minimum(low, points_of_corner)
        high = np.maximum(high, points_of_corner)
    return _Elements(low, high, corners, body)


def _reach_others(elements: _Elements, others: _Elements) -> Mask:
    """Which elements (N,) reach into the box around those of other bodies."""
    reaches = np.ones(len(elements.body), dtype=bool)
    if len(others.body) == 0:
        return ~reaches
    for axis in range(3):
        for reach, limit in (
            (elements.high[:, axis], others.low[:, axis]),
            (-elements.low[:, axis], -others.high[:, axis]),
        ):
            first = int(limit.argmin())
            holder = others.body[first]
            other_limit = limit[others.body != holder].min(initial=np.inf)
            reaches &= reach > np.where(
                elements.body == holder, other_limit, limit[first]
            )
    return reaches


def _divide(
    edges: _Elements, faces: _Elements
) -> list[tuple[_Elements, _Elements]] | None:
    """Divide both lists by the best of three planes; None if none is worthwhile."""
    fewest_pairs = _WORTHWHILE * len(edges.body) * len(faces.body)
    halves = None
    middle = np.median(0.5 * (faces.low + faces.high), axis=0)
    for axis in range(3):
        level = middle[axis]
        lower_half = (edges.low[:, axis] <= level, faces.low[:, axis] <= level)
        upper_half = (edges.high[:, axis] >= level, faces.high[:, axis] >= level)
        pairs = sum(
            np.count_nonzero(edge_mask) * np.count_nonzero(face_mask)
            for edge_mask, face_mask in (lower_half, upper_half)
        )
        if pairs < fewest_pairs:
            fewest_pairs = pairs
            halves = (lower_half, upper_half)
    if halves is None:
        return None
    return [
        (edges.pick(edge_mask), faces.pick(face_mask))
        for edge_mask, face_mask in halves
    ]


def _find_passages(
    points: Array, edges: _Elements, faces: _Elements
) -> Iterator[tuple[int, _Passages]]:
    """Yield all passages between two lists, and how many pairs were tested for them."""
    rows = max(1, _AT_ONCE // max(1, len(faces.body)))
    corner = points[faces.corners]
    normal = unit_vectors(
        cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 1])
    )
    for start in range(0, len(edges.body), rows):
        batch = slice(start, start + rows)
        boxes_meet = edges.body[batch, None] != faces.body
        for axis in range(3):
            boxes_meet &= edges.low[batch, None, axis] < faces.high[:, axis]
            boxes_meet &= edges.high[batch, None, axis] > faces.low[:, axis]
        edge, face = np.nonzero(boxes_meet)
        yield (
            boxes_meet.size,
            _test_pairs(points, edges.corners, faces, normal, edge + start, face),
        )


def _test_pairs(
    points: Array,
    edges: Index,
    faces: _Elements,
    normals: Array,
    edge: Index,
    face: Index,
) -> _Passages:
    """Find the passages among pairs of edges (k,) and faces (k,), both by number.

    Most pairs drop out by what is cheap: the triangle's plane, then the box around it.
    """
    normal = normals[face]
    ends = points[edges[edge, :2]]
    depth = np.einsum(
        "kei,ki->ke", ends - points[faces.corners[face, 0]][:, None], normal
    )
    pierces_plane = np.flatnonzero(
        (np.minimum(depth[:, 0], depth[:, 1]) < -OVERLAP)
        & (np.maximum(depth[:, 0], depth[:, 1]) > OVERLAP)
    )
    ends, depth, normal = (rows[pierces_plane] for rows in (ends, depth, normal))
    edge, face = (numbers[pierces_plane] for numbers in (edge, face))
    share = (depth[:, 0] / (depth[:, 0] - depth[:, 1]))[:, None]
    point = ends[:, 0] + share * (ends[:, 1] - ends[:, 0])
    in_box = np.flatnonzero(
        (
            (point > faces.low[face] - _BESIDE) & (point < faces.high[face] + _BESIDE)
        ).all(axis=1)
    )
    ends, depth, normal, point = (rows[in_box] for rows in (ends, depth, normal, point))
    edge, face = (numbers[in_box] for numbers in (edge, face))
    corner = points[faces.corners[face]]
    side = np.roll(corner, -1, axis=1) - corner
    side_normal = np.cross(normal[:, None], side) / np.linalg.norm(
        side, axis=2, keepdims=True
    )
    margin = np.einsum("kci,kci->kc", point[:, None] - corner, side_normal).min(axis=1)
    inner_end = ends[np.arange(len(ends)), depth.argmin(axis=1)]
    passes = margin > -OVERLAP
    return _Passages(
        point[passes],
        (inner_end - point)[passes],
        edges[edge[passes]],
        faces.body[face[passes]],
        margin[passes] <= OVERLAP,
    )


def _leads_inside(
    points: Array, pierced_body: Index, passages: _Passages, k: int
) -> bool:
    """Whether passage `k` leads to a point inside both bodies.

    `pierced_body` (T, 3): triangles of the pierced one.

    From the edge it is a little way onto a triangle at it, and into the material.
    """
    begin, end, opposite = points[passages.edge[k]]
    direction = (end - begin) / np.linalg.norm(end - begin)
    offset = (opposite - begin) - ((opposite - begin) @ direction) * direction
    width = np.linalg.norm(offset)
    if width <= 8.0 * OVERLAP:
        return False  # a sliver: there is no way off its edge
    offset = offset / width
    step = passages.to_inner_end[k]
    step = step * min(0.5, 20.0 * OVERLAP / float(np.linalg.norm(step)))
    # The far corner is to the left of a directed edge as seen from outside.
    inward = -np.cross(direction, offset)
    x, y, z = passages.point[k] + step + OVERLAP * (4.0 * offset + inward)
    _, height, sign = find_crossings(points, pierced_body, x, y)
    return bool(sign[height > z].sum() != 0)


_of_thread = threading.local()


class TakesLongError(Exception):
    """The time is over; nothing is known of the mesh yet."""


@contextmanager
def patience(seconds: float) -> Iterator[None]:
    """Have `check_patience` raise in this thread once so many seconds have passed."""
    _of_thread.until = time.monotonic() + seconds
    try:
        yield
    finally:
        _of_thread.until = np.inf


def check_patience() -> None:
    """Go on only while there is time."""
    if time.monotonic() > getattr(_of_thread, "until", np.inf):
        raise TakesLongError
