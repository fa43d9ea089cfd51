"""Drops by the action: their rate, the rate of its feedback, and how soon a cancelled one ends."""

from __future__ import annotations

import time
from collections.abc import Sequence
from statistics import median
from typing import Any, NamedTuple

from ros_pose_stats_msgs.action import SimulateDrops

from ros_pose_stats import Part, simulate

from ..results import Row, Section, Target
from ..timing import Contender, Pace, race
from . import jobs
from .client import Client
from .processes import cores
from .spread import gaps, p99, per_second

ACTION = "action of the node"
LIBRARY = "simulate() in this process"

RATES_TIMED = (
    "{} drops of the clamp at restitution 0.5 on {} workers: through the action, from sending the "
    "goal to its result with feedback, job events and results in the bag and a client that "
    "listens; and by the library in this process, in turns. The ratio, the median over the "
    "rounds, is what the node costs."
)


def drop_rates(
    client: Client, part_id: str, part: Part, drops: int, pace: Pace
) -> Section:
    """A row for each of the two ways.

    Parameters
    ----------
    client : Client
    part_id : str
        By which the node knows the part.
    part : Part
    drops : int
    pace : Pace
    """
    with jobs.action_client(client) as action:

        def through_node(goal: Any) -> None:
            handle = client.result(
                action.send_goal_async(goal, feedback_callback=lambda _: None),
                "goal's answer",
            )
            result = client.result(handle.get_result_async(), "result").result
            if jobs.accepted(result).statistics.drops != drops:
                raise RuntimeError(f"{result.statistics.drops} drops, not {drops}")

        def goal() -> Any:
            return SimulateDrops.Goal(
                part_id=part_id, drops=drops, seed=next(jobs.SEEDS)
            )

        timings = race(
            [
                Contender(ACTION, through_node, goal),
                Contender(
                    LIBRARY,
                    lambda seed: simulate(part, drops, seed=seed, workers=cores()),
                    lambda: next(jobs.SEEDS),
                ),
            ],
            pace,
        )
    return Section(
        "node_drops",
        "Drops a second through the node",
        RATES_TIMED.format(drops, cores()),
        tuple(
            Row(
                name,
                {
                    "runs": len(timings.seconds[name]),
                    "drops/s": drops / timings.median(name),
                    "of the library's": timings.ratio(LIBRARY, name),
                },
            )
            for name in (ACTION, LIBRARY)
        ),
    )


FEEDBACK_BOUND = 5.0  # messages a second

FEEDBACK_TIMED = (
    "Feedback of a goal on {} workers as it arrives over {:g} s: messages a second between the "
    "first and the last, and the longest time between two. The bound is {:g} a second."
)


def feedback(client: Client, parts: dict[str, str], seconds: float) -> Section:
    """A row for each part; names in the table by id."""
    with jobs.action_client(client) as action:
        rows = [
            _feedback_row(name, _arrivals(client, action, part_id, seconds))
            for part_id, name in parts.items()
        ]
    return Section(
        "feedback",
        "Feedback of the action",
        FEEDBACK_TIMED.format(cores(), seconds, FEEDBACK_BOUND),
        tuple(rows),
    )


def _arrivals(client: Client, action: Any, part_id: str, seconds: float) -> list[float]:
    times: list[float] = []
    goal = client.result(
        action.send_goal_async(
            SimulateDrops.Goal(
                part_id=part_id, drops=jobs.ENDLESS, seed=next(jobs.SEEDS)
            ),
            feedback_callback=lambda _: times.append(time.perf_counter()),
        ),
        "answer to the goal",
    )
    coming = goal.get_result_async()
    client.spin_until(lambda: times, "feedback")
    client.spin_for(seconds)
    found = list(times)
    client.result(goal.cancel_goal_async(), "answer to the cancel request")
    client.result(coming, "result")
    return found


def _feedback_row(name: str, times: list[float]) -> Row:
    rate = per_second(times)
    return Row(
        name,
        {
            "messages": len(times),
            "a second": rate,
            "longest gap, ms": 1e3 * max(gaps(times)),
        },
        (Target("a second", rate, FEEDBACK_BOUND, at_least=True),),
    )


CANCELLING_BOUND = 100.0  # milliseconds

CANCELLING_TIMED = (
    "A drop simulation on {} workers, cancelled some time after its first drops. `answer`: from "
    "the call of `cancel_drop_simulation`, or the action's cancel request, to its answer; `end`: "
    "from the same call until `get_drop_simulation` says CANCELLED, or the action's result is "
    "there, with what was done in it and on disk. Milliseconds; the bound is {:g} ms, held "
    "against the 99th percentile, of fewer than 100 runs the largest."
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
    """Seconds before a cancel, different ones, so that it comes anywhere in a chunk of drops."""
    return 0.05 + 0.0137 * (run % 8)


def _by_service(client: Client, part_id: str, pause: float) -> Ending:
    job_id = jobs.start(client, jobs.start_request(part_id, jobs.ENDLESS))
    jobs.wait_for_drops(client, job_id)
    client.spin_for(pause)
    begin = time.perf_counter()
    jobs.accepted(jobs.cancel(client, job_id))
    answer = time.perf_counter() - begin
    while jobs.state(client, job_id).state < jobs.DONE:
        pass
    return Ending(answer, time.perf_counter() - begin)


def _by_action(client: Client, action: Any, part_id: str, pause: float) -> Ending:
    told: list[Any] = []
    goal = client.result(
        action.send_goal_async(
            SimulateDrops.Goal(
                part_id=part_id, drops=jobs.ENDLESS, seed=next(jobs.SEEDS)
            ),
            feedback_callback=told.append,
        ),
        "answer to the goal",
    )
    coming = goal.get_result_async()
    client.spin_until(lambda: told, "feedback")
    client.spin_for(pause)
    begin = time.perf_counter()
    client.result(goal.cancel_goal_async(), "answer to the cancel request")
    answer = time.perf_counter() - begin
    client.result(coming, "result")
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
