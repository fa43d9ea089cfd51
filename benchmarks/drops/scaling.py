"""Rate with several workers."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from numba import njit

from ros_pose_stats import simulate

from ..results import Row, Section, Target
from ..timing import Contender, Pace, race
from .dropper import Dropper

LEAST, LEAST_OF_ARITHMETIC = 1.8, 0.95
PIECE = 1_000_000
"""Turns of the arithmetic kernel that a thread fetches at a time, some milliseconds."""

TIMED = (
    "`simulate` of a body with {} vertices at restitution 0.5, {} drops, with 1 worker and with "
    "more, whole calls. Beside it a kernel that only computes (no memory, the interpreter's lock "
    "let go), its pieces handed to as many threads: what the machine has to give just then. All "
    "take turns; ratios are medians over {} rounds. On two cores the target is {} times, or "
    "where the machine does not give that, {} of what the arithmetic gets.")


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
        ("simulate", lambda number: lambda _: simulate(
            dropper.part, drops, 0.5, 1, workers=number, cluster_tolerance=0.0)),
        ("arithmetic", lambda number: lambda _: _in_threads(pieces, number))]
    timings = race([Contender(f"{name} {number}", make(number))
                    for number in workers for name, make in calls], pace)
    rows = []
    for number in workers:
        ours = timings.ratio("simulate 1", f"simulate {number}")
        theirs = timings.ratio("arithmetic 1", f"arithmetic {number}")
        rows.append(Row(f"{number} worker{'s' * (number > 1)}", {
            "drops/s": drops / timings.median(f"simulate {number}"), "times one worker": ours,
            "arithmetic": theirs, "of the arithmetic": ours / theirs,
        }, (_target(ours, theirs),) if number == 2 else ()))
    rounds = len(timings.seconds["simulate 1"])
    return Section("drop_scaling", "More workers", TIMED.format(
        dropper.vertices, drops, rounds, LEAST, LEAST_OF_ARITHMETIC), tuple(rows))


def _target(ours: float, theirs: float) -> Target:
    if ours >= LEAST:
        return Target("times one worker", ours, LEAST, at_least=True)
    return Target("of the arithmetic", ours / theirs, LEAST_OF_ARITHMETIC, at_least=True)


def _in_threads(pieces: int, workers: int) -> None:
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(_arithmetic, [PIECE] * pieces))
