"""Drops a second: on one core, with several workers, and against the number of vertices."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from statistics import fmean

from numba import njit

from ros_pose_stats import simulate

from ..bodies import Body
from ..growth import family, fit_slope
from ..results import Row, Section, Target
from ..timing import Contender, Pace, race
from .dropper import RESTITUTIONS, Dropper

LEAST = {0.2: 12_000.0, 0.5: 8_500.0, 0.8: 4_000.0}
AIM = {0.5: 20_000.0}


def rates(droppers: Sequence[Dropper], drops: int, pace: Pace) -> Section:
    """A row for each restitution; every body is dropped as often."""
    corners = [dropper.vertices for dropper in droppers]
    timed = (
        f"{len(droppers)} random polyhedra as in the paper: hulls of 4 normally distributed "
        "points and as many more as a coin of 0.1 fails before its first success, homogeneous, "
        "at least two stable faces; "
        f"{min(corners)} to {max(corners)} vertices, {fmean(corners):.1f} on average. Cluster "
        "tolerance 0, release 20 radii up. Timed is what one worker does, on one thread and "
        f"warm: making random starting directions and dropping, {drops} drops of each body a "
        "round, others each round. `drops/s` is the median over the rounds, `best` the fastest "
        "one. `steps` are those of the motion between impacts."
    )
    return Section(
        "drop_rates",
        "Drops a second on one core",
        timed,
        tuple(_rows(droppers, drops, pace)),
    )


def _rows(droppers: Sequence[Dropper], drops: int, pace: Pace) -> list[Row]:
    timings = race(
        [
            Contender(str(restitution), _caller(droppers, restitution, drops))
            for restitution in RESTITUTIONS
        ],
        pace,
    )
    rows = []
    for restitution in RESTITUTIONS:
        number = drops * len(droppers)
        name = str(restitution)
        efforts = [
            dropper.effort(dropper.rules(restitution), 0, drops) for dropper in droppers
        ]
        impacts, steps = (fmean(each) for each in zip(*efforts, strict=True))
        rate = number / timings.median(name)
        targets = [Target("drops/s", rate, LEAST[restitution], at_least=True)]
        if restitution in AIM:
            targets.append(
                Target("aim: drops/s", rate, AIM[restitution], at_least=True)
            )
        rows.append(
            Row(
                f"restitution {restitution}",
                {
                    "drops/s": rate,
                    "best": number / min(timings.seconds[name]),
                    "impacts a drop": impacts,
                    "steps a drop": steps,
                    "µs an impact": 1e6 / rate / impacts,
                    "rounds": len(timings.seconds[name]),
                },
                tuple(targets),
            )
        )
    return rows


def _caller(
    droppers: Sequence[Dropper], restitution: float, drops: int
) -> Callable[[object], object]:
    seeds = count()
    rules = [dropper.rules(restitution) for dropper in droppers]

    def call(_: object) -> None:
        seed = next(seeds)
        for dropper, rule in zip(droppers, rules, strict=True):
            dropper.drop(rule, seed, drops)

    return call


LEAST_SCALED = 1.8
LEAST_OF_ARITHMETIC = 0.95
PIECE = 1_000_000
"""Turns of the arithmetic kernel that a thread fetches at a time, some milliseconds."""

TIMED = (
    "`simulate` of a body with {} vertices at restitution 0.5, {} drops, with 1 worker and with "
    "more, whole calls. Beside it a kernel that only computes (no memory, the interpreter's lock "
    "let go), its pieces handed to as many threads: what the machine has to give just then. All "
    "take turns; ratios are medians over {} rounds. On two cores the target is {} times, or "
    "where the machine does not give that, {} of what the arithmetic gets."
)


@njit(nogil=True)
def _arithmetic(turns: int) -> float:
    x = 0.3
    for _ in range(turns):
        x = 3.9 * x * (1.0 - x)
    return x


def scaling(dropper: Dropper, drops: int, pieces: int, pace: Pace) -> Section:
    """A row for 1, 2 and all workers.

    Parameters
    ----------
    dropper : Dropper
    drops : int
        By each call of `simulate`.
    pieces : int
        Of arithmetic, likewise.
    pace : Pace
    """
    cores = len(os.sched_getaffinity(0))
    workers = sorted({1, min(2, cores), cores})
    _arithmetic(1)
    calls: list[tuple[str, Callable[[int], Callable[[object], object]]]] = [
        (
            "simulate",
            lambda number: (
                lambda _: simulate(
                    dropper.part,
                    drops,
                    0.5,
                    1,
                    workers=number,
                    cluster_tolerance=0.0,
                    round_sides=0,
                )
            ),
        ),
        ("arithmetic", lambda number: lambda _: _in_threads(pieces, number)),
    ]
    timings = race(
        [
            Contender(f"{name} {number}", make(number))
            for number in workers
            for name, make in calls
        ],
        pace,
    )
    rows = []
    for number in workers:
        ours = timings.ratio("simulate 1", f"simulate {number}")
        theirs = timings.ratio("arithmetic 1", f"arithmetic {number}")
        rows.append(
            Row(
                f"{number} worker{'s' * (number > 1)}",
                {
                    "drops/s": drops / timings.median(f"simulate {number}"),
                    "times one worker": ours,
                    "arithmetic": theirs,
                    "of the arithmetic": ours / theirs,
                },
                (_target(ours, theirs),) if number == 2 else (),
            )
        )
    rounds = len(timings.seconds["simulate 1"])
    return Section(
        "drop_scaling",
        "More workers",
        TIMED.format(
            dropper.vertices, drops, rounds, LEAST_SCALED, LEAST_OF_ARITHMETIC
        ),
        tuple(rows),
    )


def _target(ours: float, theirs: float) -> Target:
    if ours >= LEAST_SCALED:
        return Target("times one worker", ours, LEAST_SCALED, at_least=True)
    return Target(
        "of the arithmetic", ours / theirs, LEAST_OF_ARITHMETIC, at_least=True
    )


def _in_threads(pieces: int, workers: int) -> None:
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(_arithmetic, [PIECE] * pieces))


RESTITUTION = 0.5
STEEPEST = 0.7
STEEPEST_EVENT = 0.2
FEWEST = 8
PILOT = 4
COST = "µs a drop"
IMPACTS = "impacts a drop"
STEPS = "steps a drop"
EACH = "µs an event"

GROWTH = (
    f"Restitution {RESTITUTION}, release 20 radii up. `ellipsoid`: random points on one of axes "
    "1, 0.7, 0.5, at the cluster tolerance of the row: the more facets, the lower the barriers "
    "between those that are stable, and at tolerance 0 a drop goes on until the last one is "
    "decided. The others, from `lab/benchmarks/bodies.py`, have six flats that stay the only "
    "stable faces however fine the rest becomes (the smallest flattened ellipsoids have a few "
    "more), cluster tolerance 0.005. `events` are impacts and steps of the motion between them. "
    "Time of dropping on one thread, the median over rounds of other drops."
)
SLOPES = (
    "Least squares of the logarithms against that of the vertices: time of a drop, and the two "
    "that it is the product of, events and time of an event; 1 is proportional. A finer body has "
    "more events because it rolls over more corners, and loses less energy at each. Errors are "
    "standard errors from the scatter about the line."
)


def growth(
    families: Sequence[tuple[str, float, Sequence[Body]]], seconds: float, pace: Pace
) -> Section:
    """A row for each body.

    Parameters
    ----------
    families : sequence of (name, cluster tolerance, bodies by rising vertices)
    seconds : float
        About as long are the drops of a body in one round.
    pace : Pace
    """
    rows = [
        _row(name, Dropper(body, tolerance), seconds, pace)
        for name, tolerance, bodies in families
        for body in bodies
    ]
    return Section(
        "drop_growth", "Cost of a drop against vertices", GROWTH, tuple(rows)
    )


def slopes(growth: Section) -> Section:
    """Exponents for each family in the rows of `growth`."""
    rows = []
    for name in dict.fromkeys(map(family, growth.rows)):
        cells = [row.cells for row in growth.rows if family(row) == name]
        vertices = [int(each["vertices"]) for each in cells]
        cost = fit_slope(vertices, [float(each[COST]) for each in cells])
        events = fit_slope(
            vertices, [float(each[IMPACTS]) + float(each[STEPS]) for each in cells]
        )
        each_one = fit_slope(vertices, [float(each[EACH]) for each in cells])
        rows.append(
            Row(
                name,
                {
                    "slope": cost.value,
                    "error": cost.error,
                    "of events": events.value,
                    "its error": events.error,
                    "of µs an event": each_one.value,
                    "error of that": each_one.error,
                    "from": vertices[0],
                    "to": vertices[-1],
                    "points": len(vertices),
                },
                (
                    Target("slope", cost.value, STEEPEST),
                    Target("slope of µs an event", each_one.value, STEEPEST_EVENT),
                ),
            )
        )
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
    return Row(
        f"{name}, {dropper.vertices} vertices",
        {
            "vertices": dropper.vertices,
            "poses": dropper.poses,
            COST: cost,
            IMPACTS: effort.impacts,
            STEPS: effort.steps,
            EACH: cost / (effort.impacts + effort.steps),
            "drops a round": drops,
        },
    )
