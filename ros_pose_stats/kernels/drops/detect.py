"""The first event on a step: a vertex reaches the plate, or a contact lets go.

Few corners can touch during a step; the others cost next to nothing. Over a step the height of a
point r is z + p . r with z and p given by their series. With B the sum of the sizes of the higher
coefficients it lies above a parabola that opens downwards, so above the lower of its ends. Taken
at the centre of a ball, less its radius, the same bound clears all corners in the ball at once.

A corner that touches is the lowest one then, so the vertical direction is in its normal
cone. Where the direction moves little compared with the cones, the corners whose cones it may
enter are found from neighbour to neighbour, starting at the lowest.
"""

import math
from typing import NamedTuple

from ...tolerances import AT_REST, JUST_TOUCHING, PULL, SINKING
from ..array_types import Array, Index
from ..compilation import inlined
from ..vectors import Vec3, dot, dot_from, length, minus, read_row
from . import layout as at
from .roots import first_zero, lowest_bound

# what an event is, if no contact that lets go
NOTHING = -2
LANDING = -1

FEW = 2
"""Up to this many corners are looked at in any order."""


class Event(NamedTuple):
    """What happens first on a step."""

    what: int        # `LANDING`, `NOTHING`, or which of the vertices in contact lets go
    fraction: float  # of the step, 1 where nothing happens
    corner: int      # that lands, -1 for none
    close: int       # corners in `work.found`: all that come as close as counts as touching


@inlined
def detect(body: at.DropBody, rules: at.DropRules, work: at.Work, last: int) -> Event:
    """Find the first event on the step whose series has been prepared."""
    first, what = math.inf, NOTHING
    corner, close = -1, 0
    if work.tally[at.MODE] != at.FLIGHT:
        first, what = first_release(work, last)
    if not _stays_clear(work.state, work.clock[at.STEP]):
        landing, corner, close = first_landing(body, rules, work, last, first)
        if landing < first:
            first, what = landing, LANDING
    return Event(what, min(first, 1.0), corner, close)


@inlined
def _stays_clear(state: Array, step: float) -> bool:
    """In flight: the centre of mass stays a radius above the plate, out of reach."""
    return bool(state[at.Z] > 1.0 and state[at.Z] + step * (state[at.V] - 0.5 * step) > 1.0)


@inlined
def first_release(work: at.Work, last: int) -> tuple[float, int]:
    """When the first contact force comes down to zero, as a fraction of the step.

    Returns infinity if none does; which of the contacts, or `NOTHING`.
    """
    series, poly = work.series, work.poly
    mode = work.tally[at.MODE]
    first, event = math.inf, NOTHING
    edge = work.contact[at.LENGTH]
    for which in range(2):
        if work.active[which] < 0:
            continue
        for k in range(last):
            far = series[k, at.TORQUE] / edge
            if mode != at.EDGE:
                poly[k] = series[k, at.FORCE]
            elif which == 1:
                poly[k] = far
            else:
                poly[k] = series[k, at.FORCE] - far
        grown = 0
        if poly[0] <= PULL * (work.clock[at.STEP] * work.clock[at.STEP]):  # it starts from zero
            if poly[1] < 0.0:
                return 0.0, which
            grown = 1
        when = first_zero(poly, grown, last - 1, min(first, 1.0), work.local)
        if when < first:
            first, event = when, which
    return first, event


@inlined
def first_landing(body: at.DropBody, rules: at.DropRules, work: at.Work, last: int,
                  before: float) -> tuple[float, int, int]:
    """When the first corner reaches the plate, if that is before a given fraction.

    Contact is a height of at most 0 that falls: a corner that is a rounding below the
    plate and moves up touches nothing.
    Returns infinity if none does; the corner; number of corners in `work.found`.
    """
    first, corner = math.inf, -1
    flying = work.tally[at.MODE] == at.FLIGHT
    live = candidates(body, rules, work, last)
    if live > FEW:
        lowest_first(work.found, work.outlook, live)
    for i in range(live):
        if stays_above(work.outlook, i, min(first, before, 1.0), 0.0):
            continue
        j = work.found[i]
        if not flying and (j == work.active[0] or j == work.active[1]):
            continue
        r = at.corner_of(body, j)
        for k in range(last + 1):
            work.poly[k] = dot_from(work.series[k, at.ZS], read_row(work.series, k, at.PS), r)
        if lowest_bound(work.poly, last) > 0.0:
            continue
        known = _known_zeros(work, j)
        if known == 0 and work.poly[0] <= 0.0:
            known = _zeros_on_plate(work)
            if known == 0:
                return 0.0, j, live
        if known > 0 and work.poly[0] > JUST_TOUCHING:
            for k in range(1, known):
                work.poly[k] = 0.0
            known = 0
        if known > 0 and work.poly[known] <= 0.0:
            continue  # sinks by a rounding; if by more, it lands on the next step
        when = first_zero(work.poly, known, last, min(first, before, 1.0), work.local)
        if when < first:
            first, corner = when, j
    return first, corner, live


@inlined
def _zeros_on_plate(work: at.Work) -> int:
    """How many coefficients are zero for a corner on the plate that nothing is known of.

    None if it moves or accelerates downwards, beyond rounding: it lands.
    """
    step = work.clock[at.STEP]
    still = AT_REST * step
    if work.poly[1] > still:
        return 1
    if work.poly[1] < -still or work.poly[2] < -SINKING * (step * step):
        return 0
    return 2


@inlined
def _known_zeros(work: at.Work, j: int) -> int:
    """How many of a corner's leading coefficients are zero but for rounding.

    One where it has just been hit, two where it has been brought to rest, three where its
    contact force has just come down to zero.
    """
    for i in range(work.tally[at.NEAR]):
        if work.near[i] == j:
            return int(1 + work.rested[i])
    return 0


NARROW = 2.0
"""Corners are found from neighbour to neighbour up to this (swing² times their number).

That is a fraction of one corner if they are spread evenly; for more the balls are faster.
"""


@inlined
def candidates(body: at.DropBody, rules: at.DropRules, work: at.Work, last: int) -> int:
    """List in `found` the corners that may touch during the step; return their number.

    Those that come within what counts as touching are among them. `outlook` is set to
    height, slope over the step, and B of each.
    """
    series = work.series
    swing = 0.0
    for k in range(1, last + 1):
        swing += length(read_row(series, k, at.PS))
    bend_p = swing - length(read_row(series, 1, at.PS))
    bend_z = 0.0
    for k in range(2, last + 1):
        bend_z += abs(series[k, at.ZS])
    if body.beside.shape[0] > 0 and swing * swing * body.x.shape[0] < NARROW:
        return spread(body, work, swing, bend_p, bend_z, rules.touching)
    return gather(body, work, bend_p, bend_z, rules.touching)


@inlined
def gather(body: at.DropBody, work: at.Work, bend_p: float, bend_z: float, margin: float) -> int:
    """Candidates by way of the balls."""
    ball, ball_range = body.ball, body.ball_range
    count = node = 0
    while node < ball.shape[0]:
        height, slope = _height_and_slope(work.series, read_row(ball, node, at.BALL_CENTRE))
        bend = bend_z + bend_p * ball[node, at.BALL_REACH]
        if min(height, height + slope - bend) - ball[node, at.BALL_RADIUS] > margin:
            node = ball_range[node, at.BALL_NEXT]
            continue
        if ball_range[node, at.BALL_NEXT] == node + 1:
            for j in range(ball_range[node, at.BALL_BEGIN], ball_range[node, at.BALL_END]):
                count = _list(body, work, j, bend_p, bend_z, margin, count)
        node += 1
    return count


@inlined
def spread(body: at.DropBody, work: at.Work, swing: float, bend_p: float, bend_z: float,
           margin: float) -> int:
    """Candidates by way of the neighbours: every cone within `swing` of the direction."""
    work.tally[at.SEARCH] += 1
    search = work.tally[at.SEARCH]
    low = _lowest(body, work)
    work.seen[low] = search
    work.queue[0] = low
    begin, end, count = 0, 1, 0
    up = read_row(work.series, 0, at.PS)
    while begin < end:
        j = work.queue[begin]
        begin += 1
        count = _list(body, work, j, bend_p, bend_z, margin, count)
        for k in range(body.beside_start[j], body.beside_start[j + 1]):
            i = body.beside[k]
            if work.seen[i] == search:
                continue
            rise = dot(up, minus(at.corner_of(body, i), at.corner_of(body, j)))
            if abs(rise) <= swing * body.beside_length[k] + margin:
                work.seen[i] = search
                work.queue[end] = i
                end += 1
    return count


@inlined
def _lowest(body: at.DropBody, work: at.Work) -> int:
    """Lowest corner, by going down from the last one; a convex body has no other low point.

    Heights are compared as they are rounded, not differences, so that level corners cannot
    lead in a circle.
    """
    up = read_row(work.series, 0, at.PS)
    low = work.tally[at.LOWEST]
    least = dot(up, at.corner_of(body, low))
    while True:
        best = -1
        for k in range(body.beside_start[low], body.beside_start[low + 1]):
            i = body.beside[k]
            height = dot(up, at.corner_of(body, i))
            if height < least:
                best, least = i, height
        if best < 0:
            break
        low = best
    work.tally[at.LOWEST] = low
    return int(low)


@inlined
def _height_and_slope(series: Array, r: Vec3) -> tuple[float, float]:
    return (dot_from(series[0, at.ZS], read_row(series, 0, at.PS), r),
            dot_from(series[1, at.ZS], read_row(series, 1, at.PS), r))


@inlined
def _list(body: at.DropBody, work: at.Work, j: int, bend_p: float, bend_z: float, margin: float,
          count: int) -> int:
    """Add a corner to the list unless its parabola stays above; return the new length."""
    height, slope = _height_and_slope(work.series, at.corner_of(body, j))
    bend = bend_z + bend_p * body.reach[j]
    if min(height, height + slope - bend) > margin:
        return count
    work.found[count] = j
    outlook = work.outlook
    outlook[count, at.HEIGHT], outlook[count, at.SLOPE] = height, slope
    outlook[count, at.BEND] = bend
    return count + 1


@inlined
def stays_above(outlook: Array, i: int, fraction: float, margin: float) -> bool:
    """Whether a listed corner cannot come as close as `margin` within a fraction of the step."""
    height = outlook[i, at.HEIGHT]
    end = height + fraction * (outlook[i, at.SLOPE] - fraction * outlook[i, at.BEND])
    return bool(min(height, end) > margin)


@inlined
def lowest_first(found: Index, outlook: Array, count: int) -> None:
    """Put the corner that seems to come lowest in front: its landing rules out most others."""
    best = 0
    for i in range(1, count):
        if (outlook[i, at.HEIGHT] + outlook[i, at.SLOPE]
                < outlook[best, at.HEIGHT] + outlook[best, at.SLOPE]):
            best = i
    if best > 0:
        found[0], found[best] = found[best], found[0]
        for k in range(at.OUTLOOK):
            outlook[0, k], outlook[best, k] = outlook[best, k], outlook[0, k]
