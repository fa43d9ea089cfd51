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

"""The first event on a step: a vertex reaches the plate, or a contact lets go.

Few corners can touch during a step; the others cost next to nothing. Over a step the
height of a point r is z + p . r with z and p given by their series. With B the sum of
the sizes of the coefficients of z and p from the fourth on, and that of the point's
third where it is negative, it lies above the parabola of the first ones less B x²,
which has no zero before a certain fraction. Taken at the centre of a ball, less its
radius, the same bound clears all corners in it at once.

A corner that touches is the lowest one then, so the vertical direction is in its normal
cone. Where the direction moves little compared with the cones, or little until a corner
lands for certain, the corners whose cones it may enter are found from neighbour to
neighbour, starting at the lowest.
"""

import math
from typing import NamedTuple

from ...tolerances import AT_REST, JUST_TOUCHING, PULL, SINKING
from ..array_types import Array, Index
from ..compilation import inlined
from ..vectors import Vec3, dot, dot_from, length, read_row, subtract, write_row
from . import layout
from .roots import first_zero

# what an event is, if no contact that lets go
NOTHING = -2
LANDING = -1


class Event(NamedTuple):
    """What happens first on a step."""

    kind: int  # `LANDING`, `NOTHING`, or which of the vertices in contact lets go
    fraction: float  # of the step, 1 where nothing happens
    corner: int  # that lands, -1 for none
    candidate_count: int  # in `work.candidates`: all that come as close as touching


@inlined
def detect_event(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work, last: int
) -> Event:
    """Find the first event on the step whose series has been prepared."""
    first = math.inf
    kind = NOTHING
    corner = -1
    close = 0
    if work.tally[layout.MODE] != layout.FLIGHT:
        first, kind = first_release(work, last)
    z = work.state[layout.Z]
    step = work.clock[layout.STEP]
    # Out of reach while the centre of mass stays a radius above the plate, in flight.
    if min(z, z + step * (work.state[layout.V] - 0.5 * step)) <= 1.0:
        landing, corner, close, end = first_landing(body, rules, work, last, first)
        if landing < first:
            first = landing
            kind = LANDING
        elif first > end:
            first = end
            kind = NOTHING
    return Event(kind, min(first, 1.0), corner, close)


@inlined
def first_release(work: layout.Work, last: int) -> tuple[float, int]:
    """When the first contact force comes down to zero, as a fraction of the step.

    Returns infinity if none does; which of the contacts, or `NOTHING`.
    """
    series = work.series
    poly = work.polynomial
    mode = work.tally[layout.MODE]
    first = math.inf
    kind = NOTHING
    edge = work.contact[layout.LENGTH]
    for vertex in range(2):
        if work.support[vertex] < 0:
            continue
        for k in range(last):
            second_force = series[k, layout.TORQUE] / edge
            if mode != layout.EDGE:
                poly[k] = series[k, layout.FORCE]
            elif vertex == 1:
                poly[k] = second_force
            else:
                poly[k] = series[k, layout.FORCE] - second_force
        first_coefficient = 0
        # A force that starts from zero is judged by its first change.
        if poly[0] <= PULL * (work.clock[layout.STEP] * work.clock[layout.STEP]):
            if poly[1] < 0.0:
                return 0.0, vertex
            first_coefficient = 1
        zero = first_zero(
            poly, first_coefficient, last - 1, min(first, 1.0), work.local_polynomial
        )
        if zero < first:
            first = zero
            kind = vertex
    return first, kind


@inlined
def first_landing(
    body: layout.DropBody,
    rules: layout.DropRules,
    work: layout.Work,
    last: int,
    limit: float,
) -> tuple[float, int, int, float]:
    """When the first corner reaches the plate, if that is before a given fraction.

    Contact is a height of at most 0 that falls: a corner that is a rounding below the
    plate and moves up touches nothing.
    Returns infinity if none does; the corner; number of corners in `work.candidates`;
    the fraction up to which it has looked.
    """
    first = math.inf
    corner = -1
    is_flying = work.tally[layout.MODE] == layout.FLIGHT
    count, end = list_candidates(body, rules, work, last)
    for i in range(count):
        put_soonest_first(work.candidates, work.landing_bound, i, count)
        if work.landing_bound[i] > min(first, limit, 1.0):
            break
        j = work.candidates[i]
        if not is_flying and (j == work.support[0] or j == work.support[1]):
            continue
        r = layout.corner_of(body, j)
        for k in range(last + 1):
            work.polynomial[k] = dot_from(
                work.series[k, layout.ZS], read_row(work.series, k, layout.PS), r
            )
        leading_zeros = _known_zeros(work, j)
        if leading_zeros == 0 and work.polynomial[0] <= 0.0:
            leading_zeros = _zeros_on_plate(work)
            if leading_zeros == 0:
                return 0.0, j, count, end
        if leading_zeros > 0 and work.polynomial[0] > JUST_TOUCHING:
            for k in range(1, leading_zeros):
                work.polynomial[k] = 0.0
            leading_zeros = 0
        if leading_zeros > 0 and work.polynomial[leading_zeros] <= 0.0:
            continue  # sinks by a rounding; if by more, it lands on the next step
        zero = first_zero(
            work.polynomial,
            leading_zeros,
            last,
            min(first, limit, 1.0),
            work.local_polynomial,
        )
        if zero < first:
            first = zero
            corner = j
    return first, corner, count, end


@inlined
def _zeros_on_plate(work: layout.Work) -> int:
    """How many coefficients are zero for a corner that has come to be on the plate.

    None if it moves or accelerates downwards, beyond rounding: it lands.
    """
    step = work.clock[layout.STEP]
    rest_speed = AT_REST * step
    if work.polynomial[1] > rest_speed:
        return 1
    if work.polynomial[1] < -rest_speed or work.polynomial[2] < -SINKING * (
        step * step
    ):
        return 0
    return 2


@inlined
def _known_zeros(work: layout.Work, j: int) -> int:
    """How many of a corner's leading coefficients are zero but for rounding.

    One where it has just been hit, two where it has been brought to rest, three where
    its contact force has just come down to zero.
    """
    for i in range(work.tally[layout.VERTICES]):
        if work.vertices[i] == j:
            return int(1 + work.rest_order[i])
    return 0


SPREAD_LIMIT = 2.0
"""Corners are found from neighbour to neighbour up to this (turn² times their number).

That is a fraction of one corner if they are spread evenly; for more the balls are
faster.
"""

ROLLING_TURN = 0.12
"""They are likewise up to this turn, for any number, until a landing that is certain.

What rolls goes over a few corners until then, while a ball around some corners reaches
far below a surface that is nearly level.
"""

SURE = 1.0 + 1e-6
"""Factor by which a landing that is certain may come later, for rounding."""

CUBIC = 3
"""Last coefficient of a height that is taken as it is rather than by its size."""


@inlined
def list_candidates(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work, last: int
) -> tuple[int, float]:
    """List the corners that may touch during the step, or until one lands for certain.

    Returns their number and the fraction of the step up to which they are listed. Those
    that come within what counts as touching are among them. `landing_bound` tells the
    fraction before which each does not touch.
    """
    series = work.series
    if last < CUBIC:
        write_row(series, CUBIC, layout.PS, Vec3(0.0, 0.0, 0.0))
        series[CUBIC, layout.ZS] = 0.0
    turn = curvature = 0.0
    for k in range(1, last + 1):
        size = length(read_row(series, k, layout.PS))
        turn += size
        if k > CUBIC:
            curvature += size + abs(series[k, layout.ZS])
    end = 1.0
    by_neighbours = False
    if body.neighbour.shape[0] > 0:
        by_neighbours = turn * turn * body.x.shape[0] < SPREAD_LIMIT
        if not by_neighbours and turn < ROLLING_TURN:
            end = min(end, _sure_landing(body, rules, work, curvature))
            by_neighbours = end < 1.0
    if by_neighbours:
        search = Search(end, end * turn, curvature, rules.touching)
        return search_neighbours(body, work, search), end
    return search_balls(body, work, curvature, rules.touching), 1.0


class Search(NamedTuple):
    """What bounds a search for corners that may touch."""

    end: float  # fraction of the step up to which it looks
    turn: float  # change of the vertical direction until then, at most
    curvature: float  # of a height, besides that of its parabola
    margin: float  # height that counts as touching


@inlined
def _sure_landing(
    body: layout.DropBody, rules: layout.DropRules, work: layout.Work, curvature: float
) -> float:
    """Fraction of the step by which the corner that is rolled on to has surely landed.

    Infinite where that is not certain: what touches already, and does not rise, may
    stay there.
    """
    if work.tally[layout.EXPECTED] < 0:
        return math.inf
    r = layout.corner_of(body, work.tally[layout.EXPECTED])
    path = _path_below(work.series, r, curvature)
    is_slow = path.slope <= AT_REST * work.clock[layout.STEP]
    if path.height <= rules.touching and is_slow:
        return math.inf
    bend = 2.0 * curvature + abs(_cubic(work.series, r))
    return SURE * time_to_plate(Path(path.height, path.slope, path.curve + bend))


@inlined
def search_balls(
    body: layout.DropBody, work: layout.Work, curvature: float, margin: float
) -> int:
    """Candidates by way of the balls."""
    ball = body.ball
    ball_range = body.ball_range
    whole_step = Search(1.0, math.inf, curvature, margin)
    count = node = 0
    while node < ball.shape[0]:
        path = _path_below(
            work.series, read_row(ball, node, layout.BALL_CENTRE), curvature
        )
        if _lowest_height(path, 1.0) - ball[node, layout.BALL_RADIUS] > margin:
            node = ball_range[node, layout.BALL_NEXT]
            continue
        if ball_range[node, layout.BALL_NEXT] == node + 1:
            for j in range(
                ball_range[node, layout.BALL_BEGIN], ball_range[node, layout.BALL_END]
            ):
                count = _list_corner(body, work, j, whole_step, count)
        node += 1
    return count


@inlined
def search_neighbours(body: layout.DropBody, work: layout.Work, search: Search) -> int:
    """Candidates by way of the neighbours: cones within the turn."""
    work.tally[layout.SEARCH] += 1
    number = work.tally[layout.SEARCH]
    lowest = _find_lowest_corner(body, work)
    work.last_search[lowest] = number
    work.queue[0] = lowest
    begin = 0
    end = 1
    count = 0
    up = read_row(work.series, 0, layout.PS)
    while begin < end:
        j = work.queue[begin]
        begin += 1
        count = _list_corner(body, work, j, search, count)
        for k in range(body.neighbour_start[j], body.neighbour_start[j + 1]):
            i = body.neighbour[k]
            if work.last_search[i] == number:
                continue
            rise = dot(
                up, subtract(layout.corner_of(body, i), layout.corner_of(body, j))
            )
            reach = search.turn * body.neighbour_distance[k] + search.margin
            if abs(rise) <= reach:
                work.last_search[i] = number
                work.queue[end] = i
                end += 1
    return count


@inlined
def _find_lowest_corner(body: layout.DropBody, work: layout.Work) -> int:
    """Lowest corner, by going down from the last one; no other corner is low.

    Heights are compared as they are rounded, not differences, so that level corners
    cannot lead in a circle.
    """
    up = read_row(work.series, 0, layout.PS)
    lowest = work.tally[layout.LOWEST]
    least_height = dot(up, layout.corner_of(body, lowest))
    while True:
        lower = -1
        for k in range(body.neighbour_start[lowest], body.neighbour_start[lowest + 1]):
            i = body.neighbour[k]
            height = dot(up, layout.corner_of(body, i))
            if height < least_height:
                lower = i
                least_height = height
        if lower < 0:
            break
        lowest = lower
    work.tally[layout.LOWEST] = lowest
    return int(lowest)


class Path(NamedTuple):
    """A parabola in time: height + slope x + curve x²."""

    height: float
    slope: float
    curve: float


@inlined
def _path_below(series: Array, r: Vec3, curvature: float) -> Path:
    """Parabola that the height of a point does not go below during the step."""
    return Path(
        dot_from(series[0, layout.ZS], read_row(series, 0, layout.PS), r),
        dot_from(series[1, layout.ZS], read_row(series, 1, layout.PS), r),
        dot_from(
            series[2, layout.ZS] - curvature + min(_cubic(series, r), 0.0),
            read_row(series, 2, layout.PS),
            r,
        ),
    )


@inlined
def _cubic(series: Array, r: Vec3) -> float:
    return dot_from(series[CUBIC, layout.ZS], read_row(series, CUBIC, layout.PS), r)


@inlined
def _lowest_height(path: Path, end: float) -> float:
    """Lowest value for 0 <= x <= `end`."""
    if 0.0 < -path.slope < 2.0 * end * path.curve:
        return path.height - path.slope * path.slope / (4.0 * path.curve)
    return min(path.height, path.height + end * path.slope + end * end * path.curve)


@inlined
def time_to_plate(path: Path) -> float:
    """First x >= 0 at which the height is at most 0 and falls; infinity for none."""
    height, slope, curve = path
    square = slope * slope - 4.0 * height * curve
    if slope > 0.0:
        if curve >= 0.0:
            return math.inf
        return (slope + math.sqrt(max(square, 0.0))) / (-2.0 * curve)
    if height <= 0.0:
        return 0.0
    denominator = math.sqrt(square) - slope if square >= 0.0 else 0.0
    return 2.0 * height / denominator if denominator > 0.0 else math.inf


@inlined
def _list_corner(
    body: layout.DropBody, work: layout.Work, j: int, search: Search, count: int
) -> int:
    """List a corner unless its parabola stays above; return the new length."""
    path = _path_below(work.series, layout.corner_of(body, j), search.curvature)
    if _lowest_height(path, search.end) > search.margin:
        return count
    work.candidates[count] = j
    work.landing_bound[count] = time_to_plate(path)
    return count + 1


@inlined
def put_soonest_first(
    candidates: Index, landing_bound: Array, begin: int, end: int
) -> None:
    """Put the corner that may land soonest first: its landing rules out most."""
    soonest = begin
    for i in range(begin + 1, end):
        if landing_bound[i] < landing_bound[soonest]:
            soonest = i
    candidates[begin], candidates[soonest] = candidates[soonest], candidates[begin]
    landing_bound[begin], landing_bound[soonest] = (
        landing_bound[soonest],
        landing_bound[begin],
    )
