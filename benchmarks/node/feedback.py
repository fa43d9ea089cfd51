"""How often the action tells how far it is."""

from __future__ import annotations

import time
from typing import Any

from ros_pose_stats_msgs.action import SimulateDrops

from ..results import Row, Section, Target
from . import jobs
from .client import Client
from .spread import gaps, per_second
from .surroundings import cores

BOUND = 5.0  # messages a second

TIMED = (
    "Feedback of a goal on {} workers as it arrives over {:g} s: messages a second between the "
    "first and the last, and the longest time between two. The bound is {:g} a second.")


def feedback(client: Client, parts: dict[str, str], seconds: float) -> Section:
    """A row for each part; names in the table by id."""
    with jobs.action_client(client) as action:
        rows = [_row(name, _arrivals(client, action, part_id, seconds))
                for part_id, name in parts.items()]
    return Section("feedback", "Feedback of the action", TIMED.format(cores(), seconds, BOUND),
                   tuple(rows))


def _arrivals(client: Client, action: Any, part_id: str, seconds: float) -> list[float]:
    times: list[float] = []
    goal = client.result(action.send_goal_async(
        SimulateDrops.Goal(part_id=part_id, drops=jobs.ENDLESS, seed=next(jobs.SEEDS)),
        feedback_callback=lambda _: times.append(time.perf_counter())), "answer to the goal")
    coming = goal.get_result_async()
    client.spin_until(lambda: times, "feedback")
    client.spin_for(seconds)
    found = list(times)
    client.result(goal.cancel_goal_async(), "answer to the cancel request")
    client.result(coming, "result")
    return found


def _row(name: str, times: list[float]) -> Row:
    rate = per_second(times)
    return Row(name, {"messages": len(times), "a second": rate,
                      "longest gap, ms": 1e3 * max(gaps(times))},
               (Target("a second", rate, BOUND, at_least=True),))
