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

"""Circular chains of hull edges: the rims of tessellated round surfaces.

An edge is continued by the one that goes on straightest from its end, where both think
so of each other. That makes chains of all edges, and in these the stretches on one
circle are looked for. A circle is laid through corners far apart and then held against
all between, since three neighbours of a fine tessellation say nothing about their
circle but rounding.
"""

from typing import NamedTuple

import numpy as np

from ..array_types import Array, Array2, Fixed2, Index, Index1
from ..compilation import entry_kernel, inlined, kernel
from ..vectors import Vec3, divide, dot, length, point_at, subtract, write_row
from .circles import (
    Chain,
    Circle,
    circle_distance,
    circle_of,
    circle_tolerance,
    fit_circle,
)
from .convex_body import BodyArrays

STRAIGHTEST = 0.9077774785329087
"""Cosine of 24.8 degrees: the 15-gon turns by 24, the 14-gon by 25.7."""

HALF_SPAN = 0.2147353271670632
"""Sine of half of that."""

FEWEST = 4
"""Edges of a run."""

MOST_AROUND = 64
"""Edges around a corner up to which one may go on straight there; an apex has more."""

# columns of a circle (8,)
CENTER = 0  # 0, 1, 2
AXIS = 3  # 3, 4, 5
RADIUS = 6
DEVIATION = 7  # largest distance of a corner


class Runs(NamedTuple):
    """Chains of edges on one circle each, one after the other."""

    start: Index1  # (Q + 1,) first edge of each run
    side: Index1  # (E,) polygon side of each edge, in the order of the run
    closed: Index1  # (Q,) 1 where the last edge ends where the first begins
    circle: Array2  # (Q, 8)


@entry_kernel
def circular_runs(points: Fixed2, body: BodyArrays, rounding: float) -> Runs:
    """Find all chains of edges whose corners lie on one circle, up to the rounding."""
    continuation = _continuations(points, body)
    count = body.corner.shape[0]
    limit = count // 2
    runs = Runs(
        np.zeros(limit + 2, np.int64),
        np.empty(limit, np.int64),
        np.zeros(limit + 1, np.int64),
        np.zeros((limit + 1, 8)),
    )
    visited = np.zeros(count, np.bool_)
    sides = np.empty(count, np.int64)
    run_count = 0
    for closed in range(2):
        for k in range(count):
            # A side that no edge leads to begins an open chain. What has not been
            # visited after that is closed.
            if visited[k] or (closed == 0 and continuation[body.twin[k]] >= 0):
                continue
            size = 0
            side = k
            while side >= 0 and not visited[side]:
                visited[side] = visited[body.twin[side]] = True
                sides[size] = side
                size += 1
                side = continuation[side]
            if size < FEWEST:
                continue
            chain = _chain_of(points, body, sides[:size], rounding)
            if closed == 1:
                run_count = _divide_closed(chain, size, runs, run_count)
            else:
                chain.corner[size] = body.corner[body.twin[sides[size - 1]]]
                run_count = _divide_open(chain, 0, size, runs, run_count)
    edges = runs.start[run_count]
    return Runs(
        runs.start[: run_count + 1].copy(),
        runs.side[:edges].copy(),
        runs.closed[:run_count].copy(),
        runs.circle[:run_count].copy(),
    )


@kernel
def _continuations(points: Array, body: BodyArrays) -> Index:
    """Side (N,) that goes on straightest from each; -1 if none does so mutually."""
    next_side = body.next_side
    count = next_side.shape[0]
    direction = np.empty((count, 3))
    straightest = np.full(count, -1, np.int64)
    for k in range(count):
        begin = point_at(points, body.corner[k])
        step = subtract(point_at(points, body.corner[next_side[k]]), begin)
        size = length(step)
        write_row(direction, k, 0, divide(step, size) if size > 0.0 else step)
    for k in range(count):
        side = next_side[k]
        largest_cosine = STRAIGHTEST
        for _ in range(MOST_AROUND):
            if side == body.twin[k]:
                break
            cosine = dot(point_at(direction, k), point_at(direction, side))
            if cosine > largest_cosine:
                largest_cosine = cosine
                straightest[k] = side
            side = next_side[body.twin[side]]
        if side != body.twin[k]:
            straightest[k] = -1
    mutual = np.full(count, -1, np.int64)
    for k in range(count):
        side = straightest[k]
        if side >= 0 and straightest[body.twin[side]] == body.twin[k]:
            mutual[k] = side
    return mutual


@kernel
def _chain_of(points: Array, body: BodyArrays, sides: Index, rounding: float) -> Chain:
    """Chain of polygon sides, twice over, so that a closed one can begin anywhere."""
    size = sides.shape[0]
    chain = Chain(
        points, np.empty(2 * size + 1, np.int64), np.empty(2 * size, np.int64), rounding
    )
    for k in range(size):
        chain.side[k] = chain.side[size + k] = sides[k]
        chain.corner[k] = chain.corner[size + k] = body.corner[sides[k]]
    chain.corner[2 * size] = chain.corner[0]
    return chain


@kernel
def _divide_closed(chain: Chain, size: int, runs: Runs, run_count: int) -> int:
    """Add the runs of a closed chain; return the new number of runs."""
    if _is_run(chain, 0, size, circle_of(chain, 0, size)):
        return _add_run(chain, 0, size, runs, run_count)
    # A closed chain is looked through from the end of one of its runs.
    for i in range(size):
        end = _longest_run(chain, i, i + size)
        if end == i + size:
            return _add_run(chain, i, end, runs, run_count)
        if end > 0:
            begin = end if end <= size else end - size
            return _divide_open(chain, begin, begin + size, runs, run_count)
    return run_count


@kernel
def _divide_open(chain: Chain, begin: int, end: int, runs: Runs, run_count: int) -> int:
    """Add the runs between two corners of a chain; return the new number of runs."""
    i = begin
    while i + FEWEST <= end:
        j = _longest_run(chain, i, end)
        if j > 0:
            # The whole arc takes in at its beginning what it took in at its end: a
            # corner that a cut left beside the circle, which its first few edges would
            # not allow.
            while i > begin and _is_run(chain, i - 1, j, circle_of(chain, i - 1, j)):
                i -= 1
            run_count = _add_run(chain, i, j, runs, run_count)
            begin = i = j
        else:
            i += 1
    return run_count


@kernel
def _longest_run(chain: Chain, i: int, end: int) -> int:
    """Last corner of the longest run from corner i of a chain; -1 if there is none."""
    first = _direction(chain, i)
    j = i + FEWEST
    while j <= end and dot(first, _direction(chain, j - 1)) > STRAIGHTEST:
        j += 1
    if j > end:
        return -1
    circle = circle_of(chain, i, j)
    if not _is_run(chain, i, j, circle):
        return -1
    fitted = j
    while j < end:
        if 2 * (j - i) > 3 * (fitted - i):
            circle = circle_of(chain, i, j)
            fitted = j
        if not _continues_run(chain, j, circle):
            if fitted == j:
                break
            circle = circle_of(chain, i, j)
            fitted = j
            if not _continues_run(chain, j, circle):
                break
        j += 1
    while j >= i + FEWEST:
        if _is_run(chain, i, j, circle_of(chain, i, j)):
            return j
        # A curve that leaves its circle slowly was followed too far.
        j -= max(1, (j - i) // 8)
    return -1


@inlined
def _direction(chain: Chain, k: int) -> Vec3:
    """Unit vector along edge k of a chain."""
    begin = point_at(chain.points, chain.corner[k])
    step = subtract(point_at(chain.points, chain.corner[k + 1]), begin)
    return divide(step, length(step))


@inlined
def _continues_run(chain: Chain, j: int, circle: Circle) -> bool:
    """Whether the edge from corner j of a chain on is one of a run on this circle."""
    begin = point_at(chain.points, chain.corner[j])
    end = point_at(chain.points, chain.corner[j + 1])
    if length(subtract(end, begin)) > 2.0 * HALF_SPAN * circle.radius:
        return False
    return circle_distance(circle, end) <= circle_tolerance(circle, chain.rounding)


@kernel
def _is_run(chain: Chain, i: int, j: int, circle: Circle) -> bool:
    """Whether the corners i to j of a chain and the edges between them are a run."""
    begin = point_at(chain.points, chain.corner[i])
    if circle.radius == 0.0:
        return False
    if circle_distance(circle, begin) > circle_tolerance(circle, chain.rounding):
        return False
    k = i
    while k < j and _continues_run(chain, k, circle):
        k += 1
    return k == j


@kernel
def _add_run(chain: Chain, i: int, j: int, runs: Runs, run_count: int) -> int:
    """Add the edges i to j of a chain with the circle fitted to their corners."""
    begin = runs.start[run_count]
    for k in range(i, j):
        runs.side[begin + k - i] = chain.side[k]
    runs.start[run_count + 1] = begin + j - i
    runs.closed[run_count] = 1 if chain.corner[i] == chain.corner[j] else 0
    circle = fit_circle(chain, i, j, circle_of(chain, i, j))
    write_row(runs.circle, run_count, CENTER, circle.center)
    write_row(runs.circle, run_count, AXIS, circle.axis)
    runs.circle[run_count, RADIUS] = circle.radius
    deviation = 0.0
    for k in range(i, j + 1):
        corner = point_at(chain.points, chain.corner[k])
        deviation = max(deviation, circle_distance(circle, corner))
    runs.circle[run_count, DEVIATION] = deviation
    return run_count + 1
