"""How soon a cancelled drop simulation ends, by the service and by the action."""

from __future__ import annotations

import time
from collections.abc import Sequence
from statistics import median
from typing import Any, NamedTuple

from ros_pose_stats_msgs.action import SimulateDrops

from lab.frame.results import Row, Section, Target

from . import jobs
from .client import Client
from .processes import cores
from .spread import p99

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


def cancelling(client: Client, parts: dict[str, str], runs: int) -> Section:
    """Rows for the service and the action.

    Parameters
    ----------
    client : Client
    parts : dict of str to str
        Names of the parts in the table, by the id of a known part.
    runs : int
    """
    rows = []
    with jobs.action_client(client) as action:
        for part_id, name in parts.items():
            by_service = [_by_service(client, part_id, _pause(i)) for i in range(runs)]
            by_action = [
                _by_action(client, action, part_id, _pause(i)) for i in range(runs)
            ]
            rows += [
                _cancelling_row(f"service, {name}", by_service),
                _cancelling_row(f"action, {name}", by_action),
            ]
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


def _by_service(client: Client, part_id: str, pause: float) -> Ending:
    job_id = jobs.start(client, jobs.start_request(part_id, jobs.ENDLESS))
    jobs.wait_for_drops(client, job_id)
    client.spin_for(pause)
    begin = time.perf_counter()
    jobs.accepted(jobs.cancel(client, job_id))
    answer = time.perf_counter() - begin
    while jobs.state(client, job_id).status.state < jobs.DONE:
        pass
    return Ending(answer, time.perf_counter() - begin)


def _by_action(client: Client, action: Any, part_id: str, pause: float) -> Ending:
    feedback: list[Any] = []
    goal = client.result(
        action.send_goal_async(
            SimulateDrops.Goal(
                part_id=part_id, drops=jobs.ENDLESS, seed=next(jobs.SEEDS)
            ),
            feedback_callback=feedback.append,
        ),
        "answer to the goal",
    )
    result = goal.get_result_async()
    client.spin_until(lambda: feedback, "feedback")
    client.spin_for(pause)
    begin = time.perf_counter()
    client.result(goal.cancel_goal_async(), "answer to the cancel request")
    answer = time.perf_counter() - begin
    client.result(result, "result")
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
