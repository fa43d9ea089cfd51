"""Drops from release to a certain outcome: detect the next event, evolve to it, resolve it."""

import math

from ..array_types import Array, Array2, Fixed2, Index, Index2
from ..compilation import entry_kernel, inlined
from . import layout as at
from .detect import detect
from .evolve import LONGEST, evolve, prepare_step
from .resolve import resolve, take_up
from .trap import energy, judge_outcome, may_go_on


@entry_kernel
def run_drops(body: at.DropBody, rules: at.DropRules, releases: Fixed2, outcome: Index2,
              measure: Array2, tape: Array2) -> None:
    """Simulate drops (section 3, appendices A and B).

    `releases` (k, 8): state at release; see `layout`. A body that reaches below the plate is
    lifted onto it; `outcome` (k, 5): filled; see `layout` for its columns. The pose is -1 where a
    drop is unsettled; `measure` (k, 2): filled with duration and energy left, in sqrt(radius / g)
    and m g radius; `tape` (T, 14): filled with the events of the last drop from row 1 on; empty
    for none.
    """
    work = at.new_work(body.x.shape[0])
    top = 0.0
    for level in body.way_out:
        top = max(top, level)
    for i in range(releases.shape[0]):
        _release(body, rules, releases[i], top, work, outcome[i], tape)
        _drop(body, rules, top, work, outcome[i], measure[i], tape)


@inlined
def _release(body: at.DropBody, rules: at.DropRules, begin: Array, top: float, work: at.Work,
             outcome: Index, tape: Array) -> None:
    """Put the body above the plate, touching it where the height is too low to fit."""
    state, tally = work.state, work.tally
    for k in range(at.STATE):
        state[k] = begin[k]
    # Where the search for the lowest corner begins decides ties: nothing of the last drop may
    # be left.
    tally[at.MODE], tally[at.NEAR], tally[at.LOWEST] = at.FLIGHT, 0, 0
    tally[at.IMPACTS], tally[at.STEPS] = 0, 0
    tally[at.LIMIT], work.clock[at.SPARE] = rules.most_steps, math.inf
    work.active[0] = work.active[1] = -1
    work.clock[at.TIME], work.clock[at.REACH] = 0.0, LONGEST
    work.clock[at.EXPECTED_BOUNCE] = math.inf
    outcome[at.TOUCHED] = 0
    if state[at.Z] <= max(1.0, top) + rules.touching:
        tally[at.LOWEST] = at.lowest_corner(state, body)
        low = at.corner_height(state, body, tally[at.LOWEST])
        if low < 0.0:
            state[at.Z] -= low
            outcome[at.TOUCHED] = 1
        for j in range(body.x.shape[0]):
            if at.corner_height(state, body, j) <= rules.touching:
                work.near[tally[at.NEAR]] = j
                tally[at.NEAR] += 1
    if tape.shape[0] > 0:
        tape[0, 0] = 0.0
    at.note(work, tape, at.RELEASE, -1)


@inlined
def _drop(body: at.DropBody, rules: at.DropRules, top: float, work: at.Work, outcome: Index,
          measure: Array, tape: Array) -> None:
    """From event to event, until the outcome is certain or the steps granted have run out."""
    tally = work.tally
    landed = tally[at.NEAR] > 0
    ending, pose = judge_outcome(body, rules, top, work)
    while ending == at.UNSETTLED and may_go_on(body, rules, work):
        if landed:
            landed = not resolve(body, rules, work, tape)
            ending, pose = judge_outcome(body, rules, top, work)
        if landed or ending != at.UNSETTLED:
            continue
        tally[at.STEPS] += 1
        last = prepare_step(body, rules, work)
        if last > 0:  # else it has turned freely, high above the plate
            event = detect(body, rules, work, last)
            evolve(body, work, last, event)
            landed = take_up(body, rules, work, event, tape)
    outcome[at.POSE], outcome[at.ENDING] = pose, ending
    outcome[at.IMPACT_COUNT], outcome[at.STEP_COUNT] = tally[at.IMPACTS], tally[at.STEPS]
    measure[at.DURATION] = work.clock[at.TIME]
    measure[at.ENERGY] = energy(work.state, body.moment)
    at.note(work, tape, at.END, -1)
