"""Circular chains of hull edges: the rims that a tessellated round surface leaves on a hull.

An edge is continued by the one that goes on straightest from its end, where both think so of
each other. That makes chains of all edges, and in these the stretches on one circle are looked
for. A circle is laid through corners far apart and then held against all between, since three
neighbours of a fine tessellation say nothing about their circle but rounding.
"""

from typing import NamedTuple

import numpy as np

from ..array_types import Array, Array2, Fixed2, Index, Index1
from ..compilation import entry_kernel, inlined, kernel
from ..vectors import Vec3, divide, dot, length, point_at, subtract, write_row
from .circles import Circle, circle_distance, circle_of, circle_tolerance, fit_circle
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
    """Find all chains of edges whose corners lie on one circle, but for the rounding."""
    onward = _continuations(points, body)
    count = body.corner.shape[0]
    most = count // 2
    found = Runs(
        np.zeros(most + 2, np.int64),
        np.empty(most, np.int64),
        np.zeros(most + 1, np.int64),
        np.zeros((most + 1, 8)),
    )
    visited = np.zeros(count, np.bool_)
    chain = np.empty(2 * count, np.int64)
    runs = 0
    for closed in range(2):
        for k in range(count):
            # What no edge leads to begins an open chain; what is left in the end is closed.
            if visited[k] or (closed == 0 and onward[body.twin[k]] >= 0):
                continue
            size = 0
            here = k
            while here >= 0 and not visited[here]:
                visited[here] = visited[body.twin[here]] = True
                chain[size] = here
                size += 1
                here = onward[here]
            if size >= FEWEST:
                runs = _divide(
                    points, body, chain, size, closed == 1, rounding, found, runs
                )
    edges = found.start[runs]
    return Runs(
        found.start[: runs + 1].copy(),
        found.side[:edges].copy(),
        found.closed[:runs].copy(),
        found.circle[:runs].copy(),
    )


@kernel
def _continuations(points: Array, body: BodyArrays) -> Index:
    """Side (N,) that goes on straightest from each, -1 where none does or not mutually."""
    follow = body.next_side
    count = body.next_side.shape[0]
    along = np.empty((count, 3))
    best = np.full(count, -1, np.int64)
    for k in range(count):
        step = subtract(
            point_at(points, body.corner[follow[k]]), point_at(points, body.corner[k])
        )
        size = length(step)
        write_row(along, k, 0, divide(step, size) if size > 0.0 else step)
    for k in range(count):
        here = follow[k]
        straightest = STRAIGHTEST
        for _ in range(MOST_AROUND):
            if here == body.twin[k]:
                break
            cosine = dot(point_at(along, k), point_at(along, here))
            if cosine > straightest:
                straightest = cosine
                best[k] = here
            here = follow[body.twin[here]]
        if here != body.twin[k]:
            best[k] = -1
    mutual = np.full(count, -1, np.int64)
    for k in range(count):
        if best[k] >= 0 and best[body.twin[best[k]]] == body.twin[k]:
            mutual[k] = best[k]
    return mutual


@kernel
def _divide(
    points: Array,
    body: BodyArrays,
    chain: Index,
    size: int,
    closed: bool,
    rounding: float,
    found: Runs,
    runs: int,
) -> int:
    """Add the runs of one chain to those found; give their new number."""
    corner = np.empty(2 * size + 1, np.int64)
    for k in range(size):
        corner[k] = body.corner[chain[k]]
        corner[size + k] = corner[k]
        chain[size + k] = chain[k]
    corner[2 * size] = corner[0]
    if not closed:
        corner[size] = body.corner[body.twin[chain[size - 1]]]
        return _scan(points, corner, chain, 0, size, rounding, found, runs)
    circle = circle_of(points, corner, 0, size)
    if _holds(points, corner, 0, size, circle, rounding):
        return _add(points, corner, chain, 0, size, circle, found, runs)
    # A closed chain is looked through from the end of one of its runs.
    for i in range(size):
        end = _grown(points, corner, i, i + size, rounding)
        if end == i + size:
            return _add(
                points,
                corner,
                chain,
                i,
                end,
                circle_of(points, corner, i, end),
                found,
                runs,
            )
        if end > 0:
            begin = end if end <= size else end - size
            return _scan(
                points, corner, chain, begin, begin + size, rounding, found, runs
            )
    return runs


@kernel
def _scan(
    points: Array,
    corner: Index,
    chain: Index,
    begin: int,
    end: int,
    rounding: float,
    found: Runs,
    runs: int,
) -> int:
    i = begin
    while i + FEWEST <= end:
        j = _grown(points, corner, i, end, rounding)
        if j > 0:
            # The whole arc takes in at its beginning what it took in at its end: a corner that
            # a cut left beside the circle, which its first few edges would not allow.
            while i > begin and _holds(
                points, corner, i - 1, j, circle_of(points, corner, i - 1, j), rounding
            ):
                i -= 1
            runs = _add(
                points,
                corner,
                chain,
                i,
                j,
                circle_of(points, corner, i, j),
                found,
                runs,
            )
            begin = i = j
        else:
            i += 1
    return runs


@kernel
def _grown(points: Array, corner: Index, i: int, end: int, rounding: float) -> int:
    """Last corner of the longest run that begins at corner i of a chain; -1 where none does."""
    first = _direction(points, corner, i)
    j = i + FEWEST
    while j <= end and dot(first, _direction(points, corner, j - 1)) > STRAIGHTEST:
        j += 1
    if j > end:
        return -1
    circle = circle_of(points, corner, i, j)
    if not _holds(points, corner, i, j, circle, rounding):
        return -1
    fitted = j
    while j < end:
        if 2 * (j - i) > 3 * (fitted - i):
            circle = circle_of(points, corner, i, j)
            fitted = j
        if not _reaches(points, corner, j, circle, rounding):
            if fitted == j:
                break
            circle = circle_of(points, corner, i, j)
            fitted = j
            if not _reaches(points, corner, j, circle, rounding):
                break
        j += 1
    while j >= i + FEWEST:
        if _holds(points, corner, i, j, circle_of(points, corner, i, j), rounding):
            return j
        # A curve that leaves its circle slowly was followed too far.
        j -= max(1, (j - i) // 8)
    return -1


@inlined
def _direction(points: Array, corner: Index, k: int) -> Vec3:
    """Unit vector along edge k of a chain."""
    step = subtract(point_at(points, corner[k + 1]), point_at(points, corner[k]))
    return divide(step, length(step))


@inlined
def _reaches(
    points: Array, corner: Index, j: int, circle: Circle, rounding: float
) -> bool:
    """Whether the edge from corner j of a chain to the next is one of a run on this circle."""
    here = point_at(points, corner[j + 1])
    return length(
        subtract(here, point_at(points, corner[j]))
    ) <= 2.0 * HALF_SPAN * circle.radius and circle_distance(
        circle, here
    ) <= circle_tolerance(circle, rounding)


@kernel
def _holds(
    points: Array, corner: Index, i: int, j: int, circle: Circle, rounding: float
) -> bool:
    """Whether the corners i to j of a chain and the edges between them are a run."""
    if circle.radius == 0.0 or circle_distance(
        circle, point_at(points, corner[i])
    ) > circle_tolerance(circle, rounding):
        return False
    k = i
    while k < j and _reaches(points, corner, k, circle, rounding):
        k += 1
    return k == j


@kernel
def _add(
    points: Array,
    corner: Index,
    chain: Index,
    i: int,
    j: int,
    rough: Circle,
    found: Runs,
    runs: int,
) -> int:
    """Keep the edges i to j of a chain with the circle fitted to all of their corners."""
    begin = found.start[runs]
    for k in range(i, j):
        found.side[begin + k - i] = chain[k]
    found.start[runs + 1] = begin + j - i
    closed = corner[i] == corner[j]
    found.closed[runs] = 1 if closed else 0
    circle = fit_circle(points, corner, i, j, rough)
    write_row(found.circle, runs, CENTER, circle.center)
    write_row(found.circle, runs, AXIS, circle.axis)
    found.circle[runs, RADIUS] = circle.radius
    farthest = 0.0
    for k in range(i, j + 1):
        farthest = max(farthest, circle_distance(circle, point_at(points, corner[k])))
    found.circle[runs, DEVIATION] = farthest
    return runs + 1
