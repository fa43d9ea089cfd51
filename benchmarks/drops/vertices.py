"""Cost of a drop against the number of vertices."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import count

from ..bodies import Body
from ..growth import family, fitted
from ..results import Row, Section, Target
from ..timing import Contender, Pace, race
from .dropper import Dropper

RESTITUTION = 0.5
STEEPEST = 0.7
STEEPEST_EVENT = 0.2
FEWEST, PILOT = 8, 4
COST, IMPACTS, STEPS, EACH = "µs a drop", "impacts a drop", "steps a drop", "µs an event"

GROWTH = (
    f"Restitution {RESTITUTION}, release 20 radii up. `ellipsoid`: random points on one of axes "
    "1, 0.7, 0.5, at the cluster tolerance of the row: the more facets, the lower the barriers "
    "between those that are stable, and at tolerance 0 a drop goes on until the last one is "
    "decided. The others, from `benchmarks/bodies.py`, have six flats that stay the only stable "
    "faces however fine the rest becomes (the smallest flattened ellipsoids have a few more), "
    "cluster tolerance 0.005. `events` are impacts and steps of the motion between them. Time "
    "of dropping on one thread, the median over rounds of other drops.")
SLOPES = (
    "Least squares of the logarithms against that of the vertices: time of a drop, and the two "
    "that it is the product of, events and time of an event; 1 is proportional. A finer body has "
    "more events because it rolls over more corners, and loses less energy at each. Errors are "
    "standard errors from the scatter about the line.")


def growth(families: Sequence[tuple[str, float, Sequence[Body]]], seconds: float,
           pace: Pace) -> Section:
    """A row for each body.

    Parameters
    ----------
    families : sequence of (name, cluster tolerance, bodies by rising vertices)
    seconds : float
        About as long are the drops of a body in one round.
    pace : Pace
    """
    rows = [_row(name, Dropper(body, tolerance), seconds, pace)
            for name, tolerance, bodies in families for body in bodies]
    return Section("drop_growth", "Cost of a drop against vertices", GROWTH, tuple(rows))


def slopes(growth: Section) -> Section:
    """Exponents for each family in the rows of `growth`."""
    rows = []
    for name in dict.fromkeys(map(family, growth.rows)):
        cells = [row.cells for row in growth.rows if family(row) == name]
        vertices = [int(each["vertices"]) for each in cells]
        cost = fitted(vertices, [float(each[COST]) for each in cells])
        events = fitted(vertices, [float(each[IMPACTS]) + float(each[STEPS]) for each in cells])
        each_one = fitted(vertices, [float(each[EACH]) for each in cells])
        rows.append(Row(name, {
            "slope": cost.value, "error": cost.error,
            "of events": events.value, "its error": events.error,
            "of µs an event": each_one.value, "error of that": each_one.error,
            "from": vertices[0], "to": vertices[-1], "points": len(vertices),
        }, (Target("slope", cost.value, STEEPEST),
            Target("slope of µs an event", each_one.value, STEEPEST_EVENT))))
    return Section("drop_slopes", "Slopes of the cost of a drop", SLOPES, tuple(rows))


def _row(name: str, dropper: Dropper, seconds: float, pace: Pace) -> Row:
    rules = dropper.rules(RESTITUTION)
    begin = time.perf_counter()
    dropper.drop(rules, 0, PILOT)
    drops = max(FEWEST, int(seconds * PILOT / (time.perf_counter() - begin)))
    call: Callable[[int], object] = lambda seed: dropper.drop(rules, seed, drops)  # noqa: E731
    seeds = count(1)
    timings = race([Contender("drop", call, lambda: next(seeds))], pace)
    effort = dropper.effort(rules, 1, drops)
    cost = 1e6 * timings.median("drop") / drops
    return Row(f"{name}, {dropper.vertices} vertices", {
        "vertices": dropper.vertices, "poses": dropper.poses, COST: cost,
        IMPACTS: effort.impacts, STEPS: effort.steps,
        EACH: cost / (effort.impacts + effort.steps), "drops a round": drops,
    })
