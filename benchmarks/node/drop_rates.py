"""Drops a second through the action beside those of the library."""

from __future__ import annotations

from typing import Any

from ros_pose_stats_msgs.action import SimulateDrops

from ros_pose_stats import Part, simulate

from ..results import Row, Section
from ..timing import Contender, Pace, race
from . import jobs
from .client import Client
from .surroundings import cores

ACTION, LIBRARY = "action of the node", "simulate() in this process"

TIMED = (
    "{} drops of the clamp at restitution 0.5 on {} workers: through the action, from sending the "
    "goal to its result with feedback, job events and results in the bag and a client that "
    "listens; and by the library in this process, in turns. The ratio, the median over the "
    "rounds, is what the node costs.")


def drop_rates(client: Client, part_id: str, part: Part, drops: int, pace: Pace) -> Section:
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
                action.send_goal_async(goal, feedback_callback=lambda _: None), "goal's answer")
            result = client.result(handle.get_result_async(), "result").result
            if jobs.accepted(result).statistics.drops != drops:
                raise RuntimeError(f"{result.statistics.drops} drops, not {drops}")

        def goal() -> Any:
            return SimulateDrops.Goal(part_id=part_id, drops=drops, seed=next(jobs.SEEDS))

        timings = race([
            Contender(ACTION, through_node, goal),
            Contender(LIBRARY, lambda seed: simulate(part, drops, seed=seed, workers=cores()),
                      lambda: next(jobs.SEEDS)),
        ], pace)
    return Section("node_drops", "Drops a second through the node", TIMED.format(drops, cores()),
                   tuple(Row(name, {"runs": len(timings.seconds[name]),
                                    "drops/s": drops / timings.median(name),
                                    "of the library's": timings.ratio(LIBRARY, name)})
                         for name in (ACTION, LIBRARY)))
