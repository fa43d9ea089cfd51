"""Drops from release to a certain outcome: next event, advance, resolve."""

from __future__ import annotations

import math

from ..array_types import Array, Array2, Fixed2, Index, Index2
from ..compilation import entry_kernel, inlined
from .contacts import let_go
from .events import LANDING, NOTHING, first_landing, first_release
from .landing import corner_height, lowest_corner, resolve
from .layout import (
    ARRIVAL,
    DURATION,
    END,
    ENDING,
    ENERGY,
    EXPECTED_BOUNCE,
    FLIGHT,
    IMPACT_COUNT,
    IMPACTS,
    LIFT_OFF,
    LIMIT,
    LOWEST,
    MODE,
    NEAR,
    POSE,
    REACH,
    RELEASE,
    SPARE,
    STATE,
    STEP,
    STEP_COUNT,
    STEPS,
    TIME,
    TOUCHED,
    UNSETTLED,
    DropBody,
    DropRules,
    V,
    Work,
    Z,
    new_work,
)
from .motion import LONGEST, SHORTEST, advance, onto_invariants, prepare_step
from .tape import note, note_contact
from .trap import energy, judge_outcome, may_go_on


@entry_kernel
def run_drops(body: DropBody, rules: DropRules, releases: Fixed2, outcome: Index2,
              measure: Array2, tape: Array2) -> None:
    """Simulate drops (section 3, appendices A and B).

    `releases` (k, 8): state at release; see `layout`. A body that reaches below the plate is
    lifted onto it; `outcome` (k, 5): filled; see `layout` for its columns. The pose is -1 where a
    drop is unsettled; `measure` (k, 2): filled with duration and energy left, in sqrt(radius / g)
    and m g radius; `tape` (T, 14): filled with the events of the last drop from row 1 on; empty
    for none.
    """
    work = new_work(body.x.shape[0])
    top = 0.0
    for level in body.way_out:
        top = max(top, level)
    for i in range(releases.shape[0]):
        _release(body, rules, releases[i], top, work, outcome[i], tape)
        _drop(body, rules, top, work, outcome[i], measure[i], tape)


@inlined
def _release(body: DropBody, rules: DropRules, begin: Array, top: float, work: Work,
             outcome: Index, tape: Array) -> None:
    """Put the body above the plate, touching it where the height is too low to fit."""
    state, tally = work.state, work.tally
    for k in range(STATE):
        state[k] = begin[k]
    # Where the search for the lowest corner begins decides ties: nothing of the last drop may
    # be left.
    tally[MODE], tally[NEAR], tally[IMPACTS], tally[STEPS], tally[LOWEST] = FLIGHT, 0, 0, 0, 0
    tally[LIMIT], work.clock[SPARE] = rules.most_steps, math.inf
    work.active[0] = work.active[1] = -1
    work.clock[TIME], work.clock[EXPECTED_BOUNCE], work.clock[REACH] = 0.0, math.inf, LONGEST
    outcome[TOUCHED] = 0
    if state[Z] <= max(1.0, top) + rules.touching:
        tally[LOWEST] = lowest_corner(state, body)
        low = corner_height(state, body, tally[LOWEST])
        if low < 0.0:
            state[Z] -= low
            outcome[TOUCHED] = 1
        for j in range(body.x.shape[0]):
            if corner_height(state, body, j) <= rules.touching:
                work.near[tally[NEAR]] = j
                tally[NEAR] += 1
    if tape.shape[0] > 0:
        tape[0, 0] = 0.0
    note(work, tape, RELEASE, -1)


@inlined
def _drop(body: DropBody, rules: DropRules, top: float, work: Work, outcome: Index,
          measure: Array, tape: Array) -> None:
    state, tally = work.state, work.tally
    landed = tally[NEAR] > 0
    ending, pose = judge_outcome(body, rules, top, work)
    while ending == UNSETTLED and may_go_on(body, rules, work):
        if landed:
            landed = not resolve(body, rules, work, tape)
            note_contact(work, tape)
            ending, pose = judge_outcome(body, rules, top, work)
            if ending != UNSETTLED or landed:
                continue
        tally[STEPS] += 1
        last = prepare_step(body, rules, work)
        if last == 0:  # turned freely, high above the plate
            continue
        first, event = math.inf, NOTHING
        corner, live = -1, 0
        if tally[MODE] != FLIGHT:
            first, event = first_release(work, last)
        if not _stays_clear(state, work.clock[STEP]):
            at, corner, live = first_landing(body, rules, work, last, first)
            if at < first:
                first, event = at, LANDING
        fraction = min(first, 1.0)
        advance(state, work.series, work.contact, tally[MODE], last, work.clock[STEP], fraction)
        work.clock[TIME] += fraction * work.clock[STEP]
        if event == NOTHING:
            tally[NEAR] = 0
            continue
        work.clock[REACH] = max(fraction * work.clock[STEP], SHORTEST)
        onto_invariants(state, body.moment)
        if event == LANDING:
            landed = True
            tally[NEAR] = 0
            for i in range(live):
                if corner_height(state, body, work.found[i]) <= rules.touching:
                    work.near[tally[NEAR]] = work.found[i]
                    tally[NEAR] += 1
            note(work, tape, ARRIVAL, corner)
        else:
            tally[NEAR] = 1
            work.near[0], work.rested[0] = work.active[event], 2
            tally[MODE] = let_go(body, work, event)
            note(work, tape, LIFT_OFF, work.near[0])
    outcome[POSE], outcome[ENDING] = pose, ending
    outcome[IMPACT_COUNT], outcome[STEP_COUNT] = tally[IMPACTS], tally[STEPS]
    measure[DURATION], measure[ENERGY] = work.clock[TIME], energy(state, body.moment)
    note(work, tape, END, -1)


@inlined
def _stays_clear(state: Array, step: float) -> bool:
    """In flight: the centre of mass stays a radius above the plate, out of reach."""
    return bool(state[Z] > 1.0 and state[Z] + step * (state[V] - 0.5 * step) > 1.0)
