"""Corners that may touch the plate during a step; the others cost next to nothing.

Over a step the height of a point r is z + p . r with z and p given by their series. With B
the sum of the sizes of the higher coefficients it lies above a parabola that opens
downwards, so above the lower of its ends. Taken at the centre of a ball, less its radius, the same
bound clears all corners in the ball at once.

A corner that touches is the lowest one then, so the vertical direction is in its normal
cone. Where the direction moves little compared with the cones, the corners whose cones it may
enter are found from neighbour to neighbour, starting at the lowest.
"""

from __future__ import annotations

from ..array_types import Array, Index
from ..compilation import inlined
from ..vectors import Vec3, dot, dot_from, length, minus, read_row
from .layout import (
    BALL_BEGIN,
    BALL_CENTRE,
    BALL_END,
    BALL_NEXT,
    BALL_RADIUS,
    BALL_REACH,
    BEND,
    HEIGHT,
    LOWEST,
    OUTLOOK,
    PS,
    SEARCH,
    SLOPE,
    ZS,
    DropBody,
    DropRules,
    Work,
    corner_of,
)

NARROW = 2.0
"""Corners are found from neighbour to neighbour up to this (swing² times their number).

That is a fraction of one corner if they are spread evenly; for more the balls are faster.
"""


@inlined
def candidates(body: DropBody, rules: DropRules, work: Work, last: int) -> int:
    """List in `found` the corners that may touch during the step; return their number.

    Those that come within what counts as touching are among them. `outlook` is set to
    height, slope over the step, and B of each.
    """
    series = work.series
    swing = 0.0
    for k in range(1, last + 1):
        swing += _size(series, k)
    bend_p = swing - _size(series, 1)
    bend_z = 0.0
    for k in range(2, last + 1):
        bend_z += abs(series[k, ZS])
    if body.beside.shape[0] > 0 and swing * swing * body.x.shape[0] < NARROW:
        return spread(body, work, swing, bend_p, bend_z, rules.touching)
    return gather(body, work, bend_p, bend_z, rules.touching)


@inlined
def _size(series: Array, k: int) -> float:
    return length(read_row(series, k, PS))


@inlined
def gather(body: DropBody, work: Work, bend_p: float, bend_z: float, margin: float) -> int:
    """Candidates by way of the balls."""
    ball, ball_range = body.ball, body.ball_range
    count = 0
    node = 0
    while node < ball.shape[0]:
        height, slope = _height_and_slope(work.series, read_row(ball, node, BALL_CENTRE))
        bend = bend_z + bend_p * ball[node, BALL_REACH]
        if min(height, height + slope - bend) - ball[node, BALL_RADIUS] > margin:
            node = ball_range[node, BALL_NEXT]
            continue
        if ball_range[node, BALL_NEXT] == node + 1:
            for j in range(ball_range[node, BALL_BEGIN], ball_range[node, BALL_END]):
                count = _list(body, work, j, bend_p, bend_z, margin, count)
        node += 1
    return count


@inlined
def spread(body: DropBody, work: Work, swing: float, bend_p: float, bend_z: float,
           margin: float) -> int:
    """Candidates by way of the neighbours: every cone within `swing` of the direction."""
    work.tally[SEARCH] += 1
    search = work.tally[SEARCH]
    low = _lowest(body, work)
    work.seen[low] = search
    work.queue[0] = low
    begin, end = 0, 1
    count = 0
    up = read_row(work.series, 0, PS)
    while begin < end:
        j = work.queue[begin]
        begin += 1
        count = _list(body, work, j, bend_p, bend_z, margin, count)
        for k in range(body.beside_start[j], body.beside_start[j + 1]):
            i = body.beside[k]
            if work.seen[i] == search:
                continue
            rise = dot(up, minus(corner_of(body, i), corner_of(body, j)))
            if abs(rise) <= swing * body.beside_length[k] + margin:
                work.seen[i] = search
                work.queue[end] = i
                end += 1
    return count


@inlined
def _lowest(body: DropBody, work: Work) -> int:
    """Lowest corner, by going down from the last one; a convex body has no other low point.

    Heights are compared as they are rounded, not differences, so that level corners cannot
    lead in a circle.
    """
    up = read_row(work.series, 0, PS)
    low = work.tally[LOWEST]
    least = dot(up, corner_of(body, low))
    while True:
        best = -1
        for k in range(body.beside_start[low], body.beside_start[low + 1]):
            i = body.beside[k]
            height = dot(up, corner_of(body, i))
            if height < least:
                best, least = i, height
        if best < 0:
            break
        low = best
    work.tally[LOWEST] = low
    return int(low)


@inlined
def _height_and_slope(series: Array, r: Vec3) -> tuple[float, float]:
    return (dot_from(series[0, ZS], read_row(series, 0, PS), r),
            dot_from(series[1, ZS], read_row(series, 1, PS), r))


@inlined
def _list(body: DropBody, work: Work, j: int, bend_p: float, bend_z: float, margin: float,
          count: int) -> int:
    """Add a corner to the list unless its parabola stays above; return the new length."""
    height, slope = _height_and_slope(work.series, corner_of(body, j))
    bend = bend_z + bend_p * body.reach[j]
    if min(height, height + slope - bend) > margin:
        return count
    work.found[count] = j
    outlook = work.outlook
    outlook[count, HEIGHT], outlook[count, SLOPE], outlook[count, BEND] = height, slope, bend
    return count + 1


@inlined
def stays_above(outlook: Array, i: int, fraction: float, margin: float) -> bool:
    """Whether a listed corner cannot come as close as `margin` within a fraction of the step."""
    height = outlook[i, HEIGHT]
    end = height + fraction * (outlook[i, SLOPE] - fraction * outlook[i, BEND])
    return bool(min(height, end) > margin)


@inlined
def lowest_first(found: Index, outlook: Array, count: int) -> None:
    """Put the corner that seems to come lowest in front: its landing rules out most others."""
    best = 0
    for i in range(1, count):
        if (outlook[i, HEIGHT] + outlook[i, SLOPE]
                < outlook[best, HEIGHT] + outlook[best, SLOPE]):
            best = i
    if best > 0:
        found[0], found[best] = found[best], found[0]
        for k in range(OUTLOOK):
            outlook[0, k], outlook[best, k] = outlook[best, k], outlook[0, k]


@inlined
def height_series(body: DropBody, series: Array, last: int, j: int, c: Array) -> None:
    """Power series of the height of a corner."""
    r = corner_of(body, j)
    for k in range(last + 1):
        c[k] = dot_from(series[k, ZS], read_row(series, k, PS), r)
