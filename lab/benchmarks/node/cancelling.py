"""How soon a cancelled drop simulation ends, by the service and by the action."""

from __future__ import annotations

import time
from collections.abc import Sequence
from statistics import median
from typing import NamedTuple

from lab.frame.results import Row, Section, Target
from tests.contract.node.harness.client import DONE
from tests.contract.node.harness.goals import Goals
from tests.contract.node.harness.jobs import LONG, get

from .jobs import SEEDS, start_long
from .spread import p99
from .starting import cores

CANCELLING_BOUND = 100.0  # milliseconds

CANCELLING_TIMED = (
    "A drop simulation on {} workers, cancelled some time after its first drops. "
    "`answer`: from the call of `cancel_drop_simulation`, or the action's cancel "
    "request, to its answer; `end`: from the same call until `get_drop_simulation` "
    "says CANCELLED, or the action's result is there, with what was done in it and on "
    "disk. Milliseconds; the bound is {:g} ms, held against the 99th percentile, of "
    "fewer than 100 runs the largest."
)


class Ending(NamedTuple):
    """Seconds from a cancel to its answer and to the end."""

    answer: float
    end: float


def cancelling(client, parts: dict[str, str], runs: int) -> Section:
    """Rows for the service and the action; `parts`: names in the table by part_id."""
    rows = []
    goals = Goals(client)
    for part_id, name in parts.items():
        by_service = [_by_service(client, part_id, _pause(i)) for i in range(runs)]
        by_action = [_by_action(goals, part_id, _pause(i)) for i in range(runs)]
        rows += [
            _cancelling_row(f"service, {name}", by_service),
            _cancelling_row(f"action, {name}", by_action),
        ]
    goals.close()
    return Section(
        "cancelling",
        "Cancelling under full load",
        CANCELLING_TIMED.format(cores(), CANCELLING_BOUND),
        tuple(rows),
    )


def _pause(run: int) -> float:
    """Seconds before a cancel, different ones, so that it comes anywhere in a chunk of
    drops.
    """
    return 0.05 + 0.0137 * (run % 8)


def _by_service(client, part_id: str, pause: float) -> Ending:
    job_id = start_long(client, part_id)
    time.sleep(pause)
    begin = time.perf_counter()
    client.good("cancel_drop_simulation", job_id=job_id)
    answer = time.perf_counter() - begin
    while get(client, job_id).status.state < DONE:
        pass
    return Ending(answer, time.perf_counter() - begin)


def _by_action(goals: Goals, part_id: str, pause: float) -> Ending:
    goal = goals.send(part_id=part_id, drops=LONG, seed=next(SEEDS))
    goal.first_feedback()
    time.sleep(pause)
    begin = time.perf_counter()
    goal.cancel()
    answer = time.perf_counter() - begin
    goal.result()
    return Ending(answer, time.perf_counter() - begin)


def _cancelling_row(name: str, endings: Sequence[Ending]) -> Row:
    answers, ends = zip(*endings, strict=True)
    return Row(
        name,
        {
            "runs": len(endings),
            "answer, median": 1e3 * median(answers),
            "answer, p99": p99(answers),
            "end, median": 1e3 * median(ends),
            "end, p99": p99(ends),
        },
        (
            Target("answer, ms", p99(answers), CANCELLING_BOUND),
            Target("end, ms", p99(ends), CANCELLING_BOUND),
        ),
    )
