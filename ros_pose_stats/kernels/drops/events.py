"""The first event on a step: a vertex reaches the plate, or a contact lets go."""

from __future__ import annotations

import math

from ...tolerances import AT_REST, JUST_TOUCHING, PULL, SINKING
from ..compilation import inlined
from .candidates import candidates, height_series, lowest_first, stays_above
from .layout import (
    EDGE,
    FLIGHT,
    FORCE,
    LENGTH,
    MODE,
    NEAR,
    STEP,
    TORQUE,
    DropBody,
    DropRules,
    Work,
)
from .roots import first_zero, lowest_bound

NOTHING = -2
LANDING = -1

FEW = 2
"""Up to this many corners are looked at in any order."""


@inlined
def first_release(work: Work, last: int) -> tuple[float, int]:
    """When the first contact force comes down to zero, as a fraction of the step.

    Returns infinity if none does; which of the contacts, or `NOTHING`.
    """
    series, poly = work.series, work.poly
    mode = work.tally[MODE]
    first, event = math.inf, NOTHING
    length = work.contact[LENGTH]
    for which in range(2):
        if work.active[which] < 0:
            continue
        for k in range(last):
            far = series[k, TORQUE] / length
            if mode != EDGE:
                poly[k] = series[k, FORCE]
            elif which == 1:
                poly[k] = far
            else:
                poly[k] = series[k, FORCE] - far
        grown = 0
        if poly[0] <= PULL * (work.clock[STEP] * work.clock[STEP]):  # it starts from zero
            if poly[1] < 0.0:
                return 0.0, which
            grown = 1
        at = first_zero(poly, grown, last - 1, min(first, 1.0), work.local)
        if at < first:
            first, event = at, which
    return first, event


@inlined
def first_landing(body: DropBody, rules: DropRules, work: Work, last: int,
                  before: float) -> tuple[float, int, int]:
    """When the first corner reaches the plate, if that is before a given fraction.

    Contact is a height of at most 0 that falls: a corner that is a rounding below the
    plate and moves up touches nothing.

    Returns infinity if none does; the corner; number of corners in `work.found`: all that come as
    close as counts as touching.
    """
    first, corner = math.inf, -1
    flying = work.tally[MODE] == FLIGHT
    live = candidates(body, rules, work, last)
    if live > FEW:
        lowest_first(work.found, work.outlook, live)
    for i in range(live):
        if stays_above(work.outlook, i, min(first, before, 1.0), 0.0):
            continue
        j = work.found[i]
        if not flying and (j == work.active[0] or j == work.active[1]):
            continue
        height_series(body, work.series, last, j, work.poly)
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
        at = first_zero(work.poly, known, last, min(first, before, 1.0), work.local)
        if at < first:
            first, corner = at, j
    return first, corner, live


@inlined
def _zeros_on_plate(work: Work) -> int:
    """How many coefficients are zero for a corner on the plate that nothing is known of.

    None if it moves or accelerates downwards, beyond rounding: it lands.
    """
    step = work.clock[STEP]
    still = AT_REST * step
    if work.poly[1] > still:
        return 1
    if work.poly[1] < -still or work.poly[2] < -SINKING * (step * step):
        return 0
    return 2


@inlined
def _known_zeros(work: Work, j: int) -> int:
    """How many of a corner's leading coefficients are zero but for rounding.

    One where it has just been hit, two where it has been brought to rest, three where its
    contact force has just come down to zero.
    """
    for i in range(work.tally[NEAR]):
        if work.near[i] == j:
            return int(1 + work.rested[i])
    return 0
