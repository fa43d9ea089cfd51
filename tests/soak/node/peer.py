"""A client that is always in the middle of a call, to be killed there."""

from __future__ import annotations

from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops

from benchmarks.node import jobs
from benchmarks.node.client import Client

from .bodies import BODIES


def main() -> None:
    """Ask and ask; `ready` is said once before."""
    body = BODIES[0]
    with Client() as client, jobs.action_client(client) as action:
        client.service(srv.EstimatePoses, "/pose_stats/estimate")
        print("ready", flush=True)
        while True:
            request = srv.EstimatePoses.Request(part=body.message())
            client.call(srv.EstimatePoses, "estimate", request)
            goal = SimulateDrops.Goal(part=body.message(), drops=10**6, max_seconds=0.3)
            action.send_goal_async(goal)
            client.spin_for(0.01)


if __name__ == "__main__":
    main()
