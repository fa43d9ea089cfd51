"""Drops of many bodies, all judged: `python -m tests.soak.drops [--drops N] [--bodies N]`."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import count, islice

from benchmarks.report import machine
from ros_pose_stats.records import DropScene
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import DropOutcomes, compute_drops, drop_rules
from ros_pose_stats.simulation.starts import random_starts

from .drop_tally import Tally, Task, judge, report

RESTITUTIONS = (0.2, 0.5, 0.8)
SHIFTS = (0.0, 1.0)
"""Scales of the shift of the centre of mass; bodies take them in turn."""


def tasks(drops: int, bodies: int) -> Iterator[Task]:
    """All drops, spread evenly over bodies and restitutions."""
    jobs = bodies * len(RESTITUTIONS)
    numbers = count()
    for body in range(bodies):
        kind = body % len(SHIFTS)
        part = random_polyhedron(kind, body // len(SHIFTS), SHIFTS[kind]).part()
        for restitution in RESTITUTIONS:
            number = next(numbers)
            share = drops * (number + 1) // jobs - drops * number // jobs
            if share:
                yield Task(part, restitution, number, share)


def drop(task: Task) -> DropOutcomes | Exception:
    """Outcomes, every stable face by itself; what went wrong is an outcome too."""
    try:
        body = drop_body(task.part, 0.0, 0)
        rules = drop_rules(DropScene(task.restitution), body.radius)
        return compute_drops(body, rules, random_starts(task.seed, 0, task.drops))
    except Exception as error:
        return error


def soak(drops: int, bodies: int, workers: int,
         said: Callable[[Tally], object] = lambda _: None) -> Tally:
    """Drop them all, telling the tally after every body."""
    tally = Tally()
    with ThreadPoolExecutor(workers) as pool:
        ahead = tasks(drops, bodies)
        while batch := list(islice(ahead, 2 * len(RESTITUTIONS) * workers)):
            for task, outcomes in zip(batch, pool.map(drop, batch), strict=True):
                judge(task, outcomes, tally)
            said(tally)
    return tally


def main(arguments: Sequence[str] | None = None) -> int:
    """Drop, print, and return the exit status: 1 where anything was wrong."""
    parser = argparse.ArgumentParser(prog="tests.soak.drops", description=__doc__)
    parser.add_argument("--drops", type=int, default=1_000_000)
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_args(arguments)
    if min(options.drops, options.bodies, options.workers) < 1:
        parser.error("give at least one drop, body and worker")
    where = machine()
    soak(len(RESTITUTIONS), 1, 1)  # compiles
    begin = time.perf_counter()
    tally = soak(options.drops, options.bodies, options.workers, lambda found: print(
        f"\r{found.drops} drops, {found.unsettled} unsettled", end="", file=sys.stderr))
    print(file=sys.stderr)
    print(", ".join(f"{name} {value}" for name, value in where.items()))
    print(report(tally, time.perf_counter() - begin))
    return 0 if tally.passed else 1


if __name__ == "__main__":
    raise SystemExit(main())
